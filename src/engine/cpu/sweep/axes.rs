//! Which way a view is swept.

use crate::raycast::ray::TRANSVERSE;

/// The axes of the volume, as the rays of a view see them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Axes {
    /// The driving axis: slices lie across it.
    pub driving: usize,
    /// The axis along lines of a slice.
    pub across: usize,
    /// The axis from line to line.
    pub along: usize,
}

/// With lines as they are in memory, where that can be.
impl From<usize> for Axes {
    fn from(driving: usize) -> Self {
        let [across, along] = TRANSVERSE[driving];
        Self { driving, across, along }
    }
}
