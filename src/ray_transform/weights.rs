//! The elements of the matrix, ray by ray: the only place that knows them. The forward map sums with them and the adjoint
//! scatters with them, so that the two are a pair whatever the algorithm.

mod crossing;
mod distance_driven;
mod exact;
mod joseph;
mod march;
mod siddon;

use crate::method::Algorithm;
use crate::ray_transform::line::Line;
use crate::ray_transform::slab::Slab;
use crate::real::Real;

/// What is done with the elements of one row.
pub(super) trait Visit<T> {
    /// Some voxels and their weights, in units of s. A voxel may come several times, and with weight 0.
    fn visit<const N: usize>(&mut self, voxels: [usize; N], weights: [T; N]);
}

/// Visits the voxels of `slab` that the ray crosses, with their weights in units of s: those of one ray over all slices sum
/// to its chord. A voxel's weights are the same to the last bit, and come in the same order, whichever slices are around it.
#[inline]
pub(super) fn for_each<T: Real>(algorithm: Algorithm, line: &Line, slab: &Slab, out: &mut impl Visit<T>) {
    let Line { ray, span, footprint } = line;
    let span = *span;
    match algorithm {
        Algorithm::Joseph => joseph::for_each(ray, span, slab, out),
        Algorithm::March { step } => march::for_each(ray, span, step, slab, out),
        Algorithm::Siddon => siddon::for_each(ray, span, slab, out),
        Algorithm::DistanceDriven => {
            distance_driven::for_each(ray, footprint, span, slab, out);
        }
        Algorithm::Exact => exact::for_each(ray, span, slab, out),
    }
}
