//! The integral of one ray, and what its derivatives are made of.

use glam::DVec3;

use crate::parallel::frame::Frame;

/// Integrals along a ray, mm times the field's unit, in float64: they are added from blocks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct RaySum {
    /// Σ f Δs.
    pub value: f64,
    /// Σ ∇f Δs, per voxel.
    pub slope: [f64; 3],
    /// Σ k ∇f Δs, k from the middle step.
    pub moment: [f64; 3],
}

impl RaySum {
    /// All integrals times this.
    #[inline(always)]
    pub(super) fn scale(&mut self, factor: f64) {
        self.value *= factor;
        for axis in 0..3 {
            self.slope[axis] *= factor;
            self.moment[axis] *= factor;
        }
    }

    /// Derivatives of the value with respect to what the frames are derivatives by, of pixel (u, v).
    pub(super) fn derivatives(&self, frames: &[Frame; 5], u: usize, v: usize) -> [f64; 5] {
        let [slope, moment] = [self.slope, self.moment].map(DVec3::from_array);
        frames.map(|frame| frame.at(u, v).dot(slope) + frame.step.dot(moment))
    }
}
