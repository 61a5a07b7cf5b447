//! All samples of one view, in closed form: index coordinates change evenly with column, row and step.

use glam::{DMat3, DVec3};

use crate::parallel::{ParallelGeometry, ViewParameters};

/// The sample of pixel (u, v) at step k is at `origin + u·column + v·row + k·step`, in index coordinates: a vector space that
/// derivatives with respect to a parameter belong to as well. k is counted from the middle step, which may be half a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub origin: DVec3,
    pub column: DVec3,
    pub row: DVec3,
    pub step: DVec3,
}

impl Frame {
    /// Where the samples are.
    pub(super) fn new(geometry: &ParallelGeometry, parameters: &ViewParameters) -> Self {
        let motion = parameters.motion();
        let back = motion.rotation().transpose();
        let spacing = geometry.spacing;
        let half = DVec3::from_array(geometry.dimensions.map(|n| 0.5 * (n as f64 - 1.0)));
        let middle = world_origin(geometry) - motion.translation;
        let frame = Self::of(geometry, back, middle);
        Self { origin: frame.origin - geometry.centre / spacing + half, ..frame }
    }

    /// How they move with α, β, φ, Δx, Δz.
    pub(super) fn derivatives(geometry: &ParallelGeometry, parameters: &ViewParameters) -> [Self; 5] {
        let motion = parameters.motion();
        let back = motion.rotation().transpose();
        let middle = world_origin(geometry) - motion.translation;
        let [alpha, beta, phi] =
            motion.rotation_derivatives().map(|turn| Self::of(geometry, turn.transpose(), middle));
        let [dx, dz] = [DVec3::X, DVec3::Z].map(|axis| Self {
            origin: -(back * axis) / geometry.spacing,
            column: DVec3::ZERO,
            row: DVec3::ZERO,
            step: DVec3::ZERO,
        });
        [alpha, beta, phi, dx, dz]
    }

    /// A linear map of the samples' world positions, in units of voxels; `middle` is that of pixel (0, 0) at step 0.
    fn of(geometry: &ParallelGeometry, map: DMat3, middle: DVec3) -> Self {
        let mapped = |world: DVec3| map * world / geometry.spacing;
        Self {
            origin: mapped(middle),
            column: mapped(geometry.pixel[0] * DVec3::X),
            row: mapped(geometry.pixel[1] * DVec3::Z),
            step: mapped(geometry.step * DVec3::Y),
        }
    }

    /// The point of pixel (u, v) at the middle step.
    pub(super) fn at(&self, u: usize, v: usize) -> DVec3 {
        self.origin + u as f64 * self.column + v as f64 * self.row
    }
}

/// Pixel (0, 0) at the middle step.
fn world_origin(geometry: &ParallelGeometry) -> DVec3 {
    geometry.pixel_position(0.0, 0.0) + geometry.centre.y * DVec3::Y
}
