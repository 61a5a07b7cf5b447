//! Joseph's rule (IEEE TMI 1(3), 192, 1982).

use crate::ray_transform::slab::Slab;
use crate::ray_transform::weights::Visit;
use crate::raycast::{Ray, Span};
use crate::real::Real;

/// One bilinear sample in every slice k that the ray's span touches, weighted by the part of [k−½, k+½] inside the span.
#[inline]
pub(super) fn for_each<T: Real>(ray: &Ray, span: Span, slab: &Slab, out: &mut impl Visit<T>) {
    let first = ((span.enter + 0.5).max(0.0) as i32).max(slab.first);
    for slice in first..slab.end {
        let s = f64::from(slice);
        let weight = span.leave.min(s + 0.5) - span.enter.max(s - 0.5);
        if weight <= 0.0 {
            break;
        }
        let sample = slab.bilinear(ray, s);
        out.visit(sample.voxels(slab.slice(slice)), sample.weights(T::of(weight)));
    }
}
