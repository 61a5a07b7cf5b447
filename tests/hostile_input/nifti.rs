//! The reader of NIfTI: any bytes are a whole CT of finite HU, or an error.

use std::io::Write;

use flate2::{Compression, write::GzEncoder};

use crate::{ct, file};

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
    ct::voxels(&file::with_content("ct.nii", bytes))
}
