//! Distance-driven weights (De Man and Basu, Phys Med Biol 49, 2463, 2004).

use crate::ray_transform::slab::Slab;
use crate::ray_transform::weights::Visit;
use crate::raycast::distance_driven::for_each_weight;
use crate::raycast::{Footprint, Ray, Span, ray::TRANSVERSE};
use crate::real::Real;

/// The part of the pixel's footprint over every voxel of a slice that it covers.
#[inline]
pub(super) fn for_each<T: Real>(
    ray: &Ray,
    footprint: &Footprint,
    span: Span,
    slab: &Slab,
    out: &mut impl Visit<T>,
) {
    let (axis, across, strides) = (slab.axis, TRANSVERSE[slab.axis], slab.strides());
    let mut dimensions = [slab.count; 3];
    across.into_iter().zip(slab.across()).for_each(|(t, n)| dimensions[t] = n);
    for_each_weight(ray, footprint, span, dimensions, slab.first..slab.end, |voxel, weight| {
        let in_slice = across.into_iter().zip(strides).map(|(t, stride)| voxel[t] * stride);
        out.visit([slab.slice(voxel[axis] as i32) + in_slice.sum::<usize>()], [T::of(weight)]);
    });
}
