//! NIfTI-1 (`.nii`, `.nii.gz`): HU and labels, slice by slice.

mod affine;
mod ct;
mod header;
mod labels;
mod storage;
#[cfg(test)]
mod test_file;
mod volume;
mod writer;

use std::path::Path;

use crate::formats::has_ending;

pub use ct::NiftiCt;
pub use labels::NiftiLabels;
pub use writer::{NiftiVoxel, NiftiWriter};

/// Whether the file's name is that of a NIfTI file.
pub(super) fn is_nifti(path: &Path) -> bool {
    has_ending(path, &[".nii", ".nii.gz"])
}
