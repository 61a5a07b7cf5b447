//! Views are aligned: the rigid motion is found at which a volume's projection fits a measured image best.
//!
//! [`Pyramid::align_view`] aligns one view of a parallel beam in its five parameters: the method of
//! [Levenberg and Marquardt](crate::levenberg_marquardt) on the sums that a pass over the rays gives, on coarse voxels
//! first. [`JointAlignment`] finds views and volume together. [`Misalignment`] and [`PhotonNoise`] make views to be aligned.

mod block_means;
mod common_motion;
mod joint;
mod misalignment;
mod pyramid;
mod view;
mod weighted;

pub use block_means::BlockMeans;
pub use common_motion::without_common_motion;
pub use joint::{JointAlignment, JointProblem, JointReport, JointRound, JointSolution};
pub use misalignment::Misalignment;
pub use pyramid::Pyramid;
pub use view::{Alignment, AlignmentOptions};

pub use crate::effects::PhotonNoise;
pub use crate::levenberg_marquardt::{MAX_LEVELS, Solution, Step, Stop};
