//! A CT of any bytes is whole and finite, or an error.

use std::path::Path;

use drr::formats::{Slice, VoxelKind, open_ct};

/// The bits of all voxels; none where the file is refused.
pub(crate) fn voxels(path: &Path) -> Option<Vec<u32>> {
    let mut ct = open_ct(path, None).ok()?;
    let header = *ct.header();
    let [n0, n1, n2] = header.grid.dimensions();
    let mut slices = 0;
    let mut voxels = Vec::new();
    let read = ct.read(&mut |k, slice| {
        assert_eq!(k, slices, "slices come in order");
        slices += 1;
        match slice {
            Slice::Int16(values) => {
                assert_eq!((header.voxels, values.len()), (VoxelKind::Int16, n0 * n1));
                voxels.extend(values.iter().map(|&v| u32::from(v.cast_unsigned())));
            }
            Slice::Float32(values) => {
                assert_eq!((header.voxels, values.len()), (VoxelKind::Float32, n0 * n1));
                assert!(values.iter().all(|v| v.is_finite()));
                voxels.extend(values.iter().map(|v| v.to_bits()));
            }
        }
        Ok(())
    });
    read.ok()?;
    assert_eq!(slices, n2, "no slice is missing");
    Some(voxels)
}
