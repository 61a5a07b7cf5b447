//! Siddon's exact lengths in float64.

use crate::engine::reference::PerLabel;
use crate::raycast::{Ray, Span, ray::TRANSVERSE};
use crate::volume::{Volume, Voxel};

/// The span cut wherever the ray crosses a plane `integer + offset` of any axis, ascending, ends included.
pub(super) fn crossings(ray: &Ray, span: Span, offset: f64) -> Vec<f64> {
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

/// Calls `visit` with the length, in units of s, and the voxel of every piece of the ray.
fn for_each_voxel(volume: &Volume, ray: &Ray, span: Span, mut visit: impl FnMut(f64, Voxel)) {
    let n = volume.grid().dimensions();
    for pair in crossings(ray, span, 0.5).windows(2) {
        let length = pair[1] - pair[0];
        if length <= 0.0 {
            continue;
        }
        let point = ray.point(0.5 * (pair[0] + pair[1]));
        let [i, j, k] =
            [0, 1, 2].map(|axis| (point[axis] + 0.5).floor().clamp(0.0, (n[axis] - 1) as f64) as usize);
        visit(length, volume.voxels().get((k * n[1] + j) * n[0] + i));
    }
}

/// Sum of length times density, each voxel to its own label.
pub(super) fn integrate(volume: &Volume, ray: &Ray, span: Span) -> PerLabel {
    let mut sum = PerLabel::default();
    for_each_voxel(volume, ray, span, |length, voxel| {
        sum[usize::from(voxel.label)] += length * voxel.density;
    });
    sum
}

/// Length through voxels of one label, in units of s.
pub(super) fn path_through(volume: &Volume, ray: &Ray, span: Span, label: u8) -> f64 {
    let mut sum = 0.0;
    for_each_voxel(volume, ray, span, |length, voxel| sum += if voxel.label == label { length } else { 0.0 });
    sum
}
