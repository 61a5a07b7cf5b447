//! Hand-made NIfTI files for tests.

use std::path::PathBuf;

use flate2::{Compression, write::GzEncoder};

/// A file in memory: a header with the affine diag(−1, 2, 3) in sform (RAS), then voxels.
pub(in crate::formats) struct TestFile {
    big: bool,
    pub(in crate::formats) bytes: Vec<u8>,
}

impl TestFile {
    pub(in crate::formats) fn new(big: bool, dimensions: [i16; 3], datatype: i16) -> Self {
        let mut file = Self { big, bytes: vec![0; 352] };
        let size = if big { 348_i32.to_be_bytes() } else { 348_i32.to_le_bytes() };
        file.bytes[..4].copy_from_slice(&size);
        file.bytes[344..348].copy_from_slice(b"n+1\0");
        file.put_i16(40, 3).put_i16(70, datatype).put_f32(108, 352.0).put_i16(254, 1);
        for (axis, n) in dimensions.into_iter().enumerate() {
            file.put_i16(42 + 2 * axis, n);
        }
        file.put_f32(280, -1.0).put_f32(300, 2.0).put_f32(320, 3.0).put_f32(292, 10.0);
        file
    }

    /// Sets a header field; offsets are those of the standard.
    pub(in crate::formats) fn put_i16(&mut self, offset: usize, value: i16) -> &mut Self {
        let bytes = if self.big { value.to_be_bytes() } else { value.to_le_bytes() };
        self.bytes[offset..offset + 2].copy_from_slice(&bytes);
        self
    }

    pub(in crate::formats) fn put_f32(&mut self, offset: usize, value: f32) -> &mut Self {
        let bytes = if self.big { value.to_be_bytes() } else { value.to_le_bytes() };
        self.bytes[offset..offset + 4].copy_from_slice(&bytes);
        self
    }

    /// Appends voxels, given as the little-endian bytes of one number each.
    pub(in crate::formats) fn voxels<const N: usize>(
        &mut self,
        voxels: impl IntoIterator<Item = [u8; N]>,
    ) -> &mut Self {
        for mut voxel in voxels {
            if self.big {
                voxel.reverse();
            }
            self.bytes.extend(voxel);
        }
        self
    }

    pub(in crate::formats) fn gzip(&self) -> Vec<u8> {
        let mut encoder = GzEncoder::new(vec![], Compression::fast());
        std::io::Write::write_all(&mut encoder, &self.bytes).unwrap();
        encoder.finish().unwrap()
    }

    /// Writes `bytes` to a file that lives as long as the folder that is returned with its path.
    pub(in crate::formats) fn save(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        (folder, path)
    }
}
