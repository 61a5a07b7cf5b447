//! Where a ray passes from one cell to the next.

use crate::raycast::{Ray, Span, ray::TRANSVERSE};

/// The span cut wherever the ray crosses a plane `integer + offset` of any axis, ascending, ends included.
pub(crate) fn crossings(ray: &Ray, span: Span, offset: f64) -> Vec<f64> {
    let mut cuts = vec![span.enter, span.leave];
    let planes = |from: f64, to: f64| {
        let (low, high) = (from.min(to), from.max(to));
        let first = (low - offset).ceil();
        (0..=(high - offset - first).max(-1.0) as i64).map(move |k| first + k as f64 + offset)
    };
    cuts.extend(planes(span.enter, span.leave));
    let (enter, leave) = (ray.point(span.enter), ray.point(span.leave));
    for (t, axis) in TRANSVERSE[ray.axis].into_iter().enumerate() {
        if ray.slope[t] != 0.0 {
            cuts.extend(
                planes(enter[axis], leave[axis])
                    .map(|plane| ray.centre + (plane - ray.base[t]) / ray.slope[t]),
            );
        }
    }
    cuts.retain(|&s| (span.enter..=span.leave).contains(&s));
    cuts.sort_by(f64::total_cmp);
    cuts
}
