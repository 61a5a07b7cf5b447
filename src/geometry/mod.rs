//! Where things are: voxel grids, detector poses, projection matrices. Everything is float64 and in mm.

mod grid;
mod pose;
mod projection;

pub use grid::Grid;
pub use pose::DetectorPose;
pub use projection::Projection;

use crate::error::Result;

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
