//! Trilinear samples at equal steps.

use crate::ray_transform::slab::{Slab, cell, inside};
use crate::ray_transform::weights::Visit;
use crate::raycast::{Ray, Span};
use crate::real::Real;

/// The driving axis is divided into cells of `step` voxels from −½ on; each cell that the span touches gives one trilinear
/// sample at the middle of the part inside, weighted by that part's length. A sample between two slabs is seen by both.
#[inline]
pub(super) fn for_each<T: Real>(ray: &Ray, span: Span, step: f64, slab: &Slab, out: &mut impl Visit<T>) {
    let Some((from, to)) = reach(span, slab) else { return };
    // One cell more at both ends than rounding could hide; it gives nothing to the slab, or is outside the span.
    let first = ((from + 0.5) / step).floor() - 1.0;
    let cells = ((to - from) / step).ceil() as i32 + 3;
    for n in 0..cells {
        let lower = -0.5 + (first + f64::from(n)) * step;
        let upper = -0.5 + (first + f64::from(n + 1)) * step;
        let (from, to) = (lower.max(span.enter), upper.min(span.leave));
        if to <= from {
            continue;
        }
        let s = 0.5 * (from + to);
        let sample = slab.bilinear(ray, s);
        let slice = cell(s, slab.count);
        let weight = T::of(to - from);
        let above = weight * T::of(inside(s, slab.count) - f64::from(slice));
        if slab.contains(slice) {
            out.visit(sample.voxels(slab.slice(slice)), sample.weights(weight - above));
        }
        if slab.contains(slice + 1) {
            out.visit(sample.voxels(slab.slice(slice + 1)), sample.weights(above));
        }
    }
}

/// The part of the span whose samples touch the slab: from the slice below it to the one above; all on the volume's sides.
fn reach(span: Span, slab: &Slab) -> Option<(f64, f64)> {
    let Span { enter, leave } = span;
    let from = if slab.first == 0 { enter } else { enter.max(f64::from(slab.first) - 1.0) };
    let to = if slab.end as usize == slab.count { leave } else { leave.min(f64::from(slab.end)) };
    (from < to).then_some((from, to))
}
