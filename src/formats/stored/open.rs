//! Which format a file is in.

use std::path::Path;

use super::volume::StoredVolume;
use crate::error::Result;
use crate::formats::{meta_image, nifti, nrrd};

/// Whether the file's name is that of a format that is one array.
pub(in crate::formats) fn is_stored(path: &Path) -> bool {
    nifti::is_nifti(path) || meta_image::is_meta_image(path) || nrrd::is_nrrd(path)
}

/// Opens a file by its name: NIfTI unless that is another's.
pub(super) fn volume(path: &Path) -> Result<StoredVolume> {
    if meta_image::is_meta_image(path) {
        meta_image::open(path)
    } else if nrrd::is_nrrd(path) {
        nrrd::open(path)
    } else {
        nifti::open(path)
    }
}
