//! A volume of a CT that is a file.

use crate::error::Result;
use crate::formats::{CtReader, Slice, VoxelKind};
use crate::volume::{Classification, Volume, VolumeBuilder};

/// Reads every slice of a CT and makes a volume of them; holds one slice beside it. Materials follow from the thresholds.
///
/// # Errors
/// As [`CtReader::read`]; `OutOfMemory`.
pub fn read_volume(ct: &mut dyn CtReader, how: &Classification) -> Result<Volume> {
    let grid = ct.header().grid;
    let mut builder = match ct.header().voxels {
        VoxelKind::Int16 => VolumeBuilder::int16(grid, how, false)?,
        VoxelKind::Float32 => VolumeBuilder::float32(grid, how)?,
    };
    ct.read(&mut |_, slice| match slice {
        Slice::Int16(hu) => builder.push_int16(hu, None),
        Slice::Float32(hu) => builder.push_float32(hu, None),
    })?;
    builder.finish()
}
