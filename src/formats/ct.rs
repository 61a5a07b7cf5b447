//! A source of CT voxels.

use std::path::Path;

use crate::error::Result;
use crate::formats::{RawCt, RawLayout, StoredCt, file_error, has_ending, stored};
use crate::geometry::Grid;

/// How the voxels of a CT are delivered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VoxelKind {
    /// Every voxel is a whole number of HU that fits an int16.
    Int16,
    /// HU in float32.
    Float32,
}

/// What is known of a CT before its voxels are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CtHeader {
    /// Dimensions and place; the world is LPS (x to the patient's left, y to the back, z to the head), mm.
    pub grid: Grid,
    /// How the voxels are delivered.
    pub voxels: VoxelKind,
}

/// One slice of voxels in HU: n0 × n1 values, voxel (i, j) at `j*n0 + i`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Slice<'a> {
    /// The slices of `VoxelKind::Int16`.
    Int16(&'a [i16]),
    /// The slices of `VoxelKind::Float32`; all finite.
    Float32(&'a [f32]),
}

/// A CT that can be read slice by slice, any number of times.
pub trait CtReader: Send {
    /// Dimensions, place and voxel kind.
    fn header(&self) -> &CtHeader;

    /// Hands every slice to `consume`, with its index k = 0, 1, …, n2−1.
    ///
    /// # Errors
    /// `File` when the file is damaged, or has voxels that are NaN or infinite (their number and the first of them
    /// are named); whatever `consume` returns. What was consumed before an error must not be used.
    fn read(&mut self, consume: &mut dyn FnMut(usize, Slice<'_>) -> Result<()>) -> Result<()>;

    /// What else a user may want to know, a sentence each: what the file says of itself, and what was passed over. The
    /// number of padding voxels is among it once they have been read. What may make images wrong begins with "warning: ".
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Opens a CT: DICOM when it is a folder or a DICOM file, NIfTI, MetaImage or NRRD when the name
/// ends in `.nii`, `.nii.gz`, `.mha`, `.mhd`, `.nrrd` or `.nhdr`, otherwise raw int16 HU, for which `raw` must be given.
pub fn open_ct(path: &Path, raw: Option<RawLayout>) -> Result<Box<dyn CtReader>> {
    if stored::is_stored(path) {
        return Ok(Box::new(StoredCt::open(path)?));
    }
    if raw.is_none() && is_dicom(path) {
        return open_dicom(path);
    }
    let reason = "unknown format; valid: a DICOM folder, .nii, .nii.gz, .mha, .mhd, .nrrd, .nhdr, or raw int16 HU with its dimensions, spacing and origin";
    let layout = raw.ok_or_else(|| file_error(path, reason))?;
    Ok(Box::new(RawCt::open(path, layout)?))
}

/// Whether a CT doesn't say itself what it holds: neither a folder, nor a file of a known format.
pub fn is_raw(path: &Path) -> bool {
    !stored::is_stored(path) && !is_dicom(path)
}

/// By the content, where a name doesn't tell.
fn is_dicom(path: &Path) -> bool {
    path.is_dir() || has_ending(path, &[".dcm", "dicomdir"]) || says_dicom(path)
}

#[cfg(feature = "dicom")]
fn says_dicom(path: &Path) -> bool {
    // What cannot be read is found out when it is opened.
    crate::formats::dicom::is_dicom(path).unwrap_or(false)
}

#[cfg(feature = "dicom")]
fn open_dicom(path: &Path) -> Result<Box<dyn CtReader>> {
    Ok(Box::new(crate::formats::DicomCt::open(path, None)?))
}

#[cfg(not(feature = "dicom"))]
fn says_dicom(_path: &Path) -> bool {
    false
}

#[cfg(not(feature = "dicom"))]
fn open_dicom(path: &Path) -> Result<Box<dyn CtReader>> {
    Err(file_error(path, "is DICOM, which this build does not read; valid: a build with the feature dicom"))
}
