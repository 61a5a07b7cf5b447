//! All rays of one view of an object that moves.

use glam::DVec3;

use crate::error::Result;
use crate::geometry::{DetectorPose, Grid, RigidMotion, View};
use crate::pose_gradient::moving_ray::{Moving, MovingRay};
use crate::raycast::Beam;

/// The rays of a view of an object after a motion, in its index space, and their derivatives with respect to α, β, φ and t.
#[derive(Debug, Clone, Copy)]
pub(super) struct MovingBeam {
    beam: Beam,
    source: Moving,
    first_pixel: Moving,
    column_step: Moving,
    row_step: Moving,
}

impl MovingBeam {
    /// # Errors
    /// `InvalidArgument` when view or motion is not valid.
    pub(super) fn new(
        view: &DetectorPose,
        motion: &RigidMotion,
        pivot: DVec3,
        grid: &Grid,
        size: [usize; 2],
    ) -> Result<Self> {
        view.validate().map_err(|error| error.of("view"))?;
        motion.validate().map_err(|error| error.of("motion"))?;
        let seen = motion.seen_from(view, pivot);
        let turns = motion.rotation_derivatives().map(|turn| turn.transpose());
        let back = motion.rotation().transpose();
        // Index space sees x at Rᵀ (x − pivot − t) + pivot, and a step at Rᵀ step.
        let vector = |at: DVec3, world: DVec3| {
            let [alpha, beta, phi] = turns.map(|turn| grid.vector_to_index(turn * world));
            Moving { at, by: [alpha, beta, phi, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO] }
        };
        let point = |seen: DVec3, world: DVec3| {
            let mut moving = vector(grid.point_to_index(seen), world - pivot - motion.translation);
            for (k, axis) in DVec3::AXES.into_iter().enumerate() {
                moving.by[3 + k] = -grid.vector_to_index(back * axis);
            }
            moving
        };
        Ok(Self {
            beam: Beam::new(&View::Pose(seen), grid, size)?,
            source: point(seen.source, view.source),
            first_pixel: point(seen.first_pixel, view.first_pixel),
            column_step: vector(grid.vector_to_index(seen.column_step), view.column_step),
            row_step: vector(grid.vector_to_index(seen.row_step), view.row_step),
        })
    }

    /// The ray of pixel (column, row), which may be fractional.
    pub(super) fn ray(&self, column: f64, row: f64) -> MovingRay {
        let pixel = self.first_pixel.plus(column, &self.column_step).plus(row, &self.row_step);
        MovingRay::new(self.beam.ray(column, row), &self.source, &pixel)
    }
}
