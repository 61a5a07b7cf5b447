//! The reader of NIfTI: any bytes are a whole CT of finite HU, or an error.

use std::io::Write;

use drr::formats::{Slice, VoxelKind, open_ct};
use flate2::{Compression, write::GzEncoder};

use crate::file;

/// Whether the file was accepted. Reads the bytes as they are, and as the content of a compressed file: its checksums
/// would stop every mutation.
pub(crate) fn check(bytes: &[u8]) -> bool {
    let plain = read(bytes);
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).expect("to memory");
    let compressed = read(&encoder.finish().expect("to memory"));
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        assert_eq!(plain, compressed, "the same voxels whether compressed or not");
    }
    plain.is_some()
}

/// The bits of all voxels.
fn read(bytes: &[u8]) -> Option<Vec<u32>> {
    let path = file::with_content("ct.nii", bytes);
    let mut ct = open_ct(&path, None).ok()?;
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
