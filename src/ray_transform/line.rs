//! A ray and its part inside the volume.

use crate::method::Algorithm;
use crate::ray_transform::slab::Slab;
use crate::ray_transform::weights::{self, Visit};
use crate::raycast::{Footprint, Ray, Span};
use crate::real::Real;

/// A ray that crosses the volume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    pub ray: Ray,
    pub span: Span,
    /// What its pixel covers.
    pub footprint: Footprint,
}

struct Sum<'a, T> {
    voxels: &'a [T],
    sum: f64,
}

struct Scatter<'a, T> {
    voxels: &'a mut [T],
    value: T,
}

impl Line {
    /// `None` when the ray misses the box of a volume of these dimensions.
    #[inline]
    pub(super) fn new(ray: Ray, footprint: Footprint, dimensions: [usize; 3]) -> Option<Self> {
        ray.clip(dimensions).map(|span| Self { ray, span, footprint })
    }

    /// The sum of voxel times weight.
    #[inline]
    pub(super) fn integral<T: Real>(&self, algorithm: Algorithm, slab: &Slab, voxels: &[T]) -> T {
        let mut out = Sum { voxels, sum: 0.0 };
        weights::for_each(algorithm, self, slab, &mut out);
        T::of(self.ray.mm_per_slice * out.sum)
    }

    /// Adds `value` times the weights to the slab's voxels.
    #[inline]
    pub(super) fn scatter<T: Real>(&self, algorithm: Algorithm, value: T, slab: &Slab, voxels: &mut [T]) {
        let value = T::of(self.ray.mm_per_slice * value.into());
        weights::for_each(algorithm, self, slab, &mut Scatter { voxels, value });
    }
}

impl<T: Real> Visit<T> for Sum<'_, T> {
    #[inline(always)]
    fn visit<const N: usize>(&mut self, voxels: [usize; N], weights: [T; N]) {
        let mut sum = T::default();
        for (voxel, weight) in voxels.into_iter().zip(weights) {
            sum += self.voxels[voxel] * weight;
        }
        self.sum += sum.into();
    }
}

impl<T: Real> Visit<T> for Scatter<'_, T> {
    #[inline(always)]
    fn visit<const N: usize>(&mut self, voxels: [usize; N], weights: [T; N]) {
        for (voxel, weight) in voxels.into_iter().zip(weights) {
            self.voxels[voxel] += self.value * weight;
        }
    }
}
