//! Reading what a test has written.

use std::path::Path;

use crate::error::Result;
use crate::formats::{Slice, VoxelKind, open_ct};
use crate::geometry::Grid;

/// The grid, the kind and the HU of a CT, all slices one after the other.
pub(super) fn read(path: &Path) -> Result<(Grid, VoxelKind, Vec<f64>)> {
    let mut ct = open_ct(path, None)?;
    let mut values = vec![];
    ct.read(&mut |_, slice| {
        match slice {
            Slice::Int16(voxels) => values.extend(voxels.iter().map(|&v| f64::from(v))),
            Slice::Float32(voxels) => values.extend(voxels.iter().map(|&v| f64::from(v))),
        }
        Ok(())
    })?;
    Ok((ct.header().grid, ct.header().voxels, values))
}
