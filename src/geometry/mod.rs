//! Where things are: voxel grids, detector poses, projection matrices, directions in the patient. Everything is float64 and
//! in mm.

mod anatomical_direction;
mod grid;
mod patient_orientation;
mod pose;
mod projection;
mod rigid_motion;

pub use anatomical_direction::AnatomicalDirection;
pub use grid::Grid;
pub use patient_orientation::PatientOrientation;
pub use pose::DetectorPose;
pub use projection::Projection;
pub use rigid_motion::RigidMotion;

use glam::DVec3;

use crate::error::{Error, Result};

/// Largest coordinate of anything in the world, mm: float64 still resolves 2e-6 mm there.
pub(crate) const MAX_COORDINATE: f64 = 1e10;

/// Checks that the components of a world vector, mm, are finite and not too large.
pub(crate) fn check_coordinates(argument: &str, v: DVec3) -> Result<()> {
    // NaN is not in the range either.
    if v.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE) {
        return Ok(());
    }
    let valid = format!("−{MAX_COORDINATE:e} … {MAX_COORDINATE:e} mm");
    Err(Error::invalid(argument, format!("[{:e}, {:e}, {:e}]", v.x, v.y, v.z), valid))
}

/// One view: how the pixels of one image map to rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum View {
    /// Segments from a point source to pixel centres.
    Pose(DetectorPose),
    /// Half-lines from a source (cone beam), or full lines (parallel beam), given by a world→clip matrix.
    Projection(Projection),
}

impl View {
    /// Checks the numbers; see [`DetectorPose::validate`] and [`Projection::validate`].
    pub fn validate(&self) -> Result<()> {
        match self {
            Self::Pose(pose) => pose.validate(),
            Self::Projection(projection) => projection.validate(),
        }
    }
}
