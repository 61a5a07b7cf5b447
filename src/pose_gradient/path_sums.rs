//! What is summed along a ray.

use crate::physics::MAX_MATERIALS;
use crate::real::Real;

/// Sums of one material in one vector, by what they are; as many as fill a vector register.
pub(super) const LANES: usize = 8;

/// Σ w f.
pub(super) const VALUE: usize = 0;
/// Σ w ∂f/∂u and Σ w ∂f/∂v.
pub(super) const SLOPE: [usize; 2] = [1, 2];
/// Σ w ∂f/∂s.
pub(super) const ALONG: usize = 3;
/// Σ w (s − centre) ∂f/∂u, and of v.
pub(super) const MOMENT: [usize; 2] = [4, 5];
/// Derivatives of Σ w f with respect to where the span starts and ends.
pub(super) const ENDS: [usize; 2] = [6, 7];

/// Samples whose sums are taken in their own width; blocks are added in float64.
pub(super) const BLOCK: usize = 64;

/// Sums by label: densities in g/cm³, lengths in units of s.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct PathSums<T> {
    pub of: [[T; LANES]; MAX_MATERIALS],
}

impl<T: Real> PathSums<T> {
    /// A sample of one material: its value, its slopes along u, v and s, all times its weight; its moment is s − centre.
    #[inline(always)]
    pub(super) fn add(&mut self, label: usize, [value, u, v, along]: [T; 4], moment: T) {
        let mut lanes = [T::default(); LANES];
        lanes[VALUE] = value;
        lanes[ALONG] = along;
        [lanes[SLOPE[0]], lanes[SLOPE[1]]] = [u, v];
        [lanes[MOMENT[0]], lanes[MOMENT[1]]] = [moment * u, moment * v];
        for (sum, lane) in self.of[label].iter_mut().zip(lanes) {
            *sum += lane;
        }
    }

    /// The sums of `block` too, which is emptied.
    pub(super) fn take(&mut self, block: &mut PathSums<impl Real>) {
        for (sums, block) in self.of.iter_mut().zip(&block.of) {
            for (sum, part) in sums.iter_mut().zip(block) {
                *sum += T::of((*part).into());
            }
        }
        *block = PathSums::default();
    }
}

impl PathSums<f64> {
    /// One of each material's sums.
    pub(super) fn lane(&self, lane: usize) -> [f64; MAX_MATERIALS] {
        self.of.map(|sums| sums[lane])
    }

    /// Σ over materials with these weights.
    pub(super) fn weighted(&self, weights: &[f64]) -> [f64; LANES] {
        let mut total = [0.0; LANES];
        for (weight, sums) in weights.iter().zip(&self.of) {
            for (total, sum) in total.iter_mut().zip(sums) {
                *total += weight * sum;
            }
        }
        total
    }
}
