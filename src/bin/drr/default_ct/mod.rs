//! The CT that the command carries; see ATTRIBUTION.md beside it.

use drr::formats::StoredCt;

/// What to call it.
pub(crate) const NAME: &str = "built-in CT (LIDC-IDRI-0001, low resolution)";

/// Opens it.
pub(crate) fn open() -> drr::Result<StoredCt> {
    StoredCt::from_nifti(NAME, include_bytes!("lidc_idri_0001_lowres.nii.gz"))
}
