//! A source of CT voxels.

use std::path::Path;

use crate::error::Result;
use crate::formats::{NiftiCt, RawCt, RawLayout, file_error, nifti};
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
}

/// Opens a CT: NIfTI when the name ends in `.nii` or `.nii.gz`, otherwise raw int16 HU, for which `raw` must be given.
pub fn open_ct(path: &Path, raw: Option<RawLayout>) -> Result<Box<dyn CtReader>> {
    if nifti::is_nifti(path) {
        return Ok(Box::new(NiftiCt::open(path)?));
    }
    let reason =
        "unknown format; valid: .nii, .nii.gz, or raw int16 HU with its dimensions, spacing and origin";
    let layout = raw.ok_or_else(|| file_error(path, reason))?;
    Ok(Box::new(RawCt::open(path, layout)?))
}
