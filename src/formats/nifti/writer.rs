//! Writing NIfTI-1, slice by slice.

use std::io::Write;
use std::marker::PhantomData;
use std::path::Path;

use flate2::{Compression, write::GzEncoder};
use glam::DVec3;

use super::header::{FIRST_VOXEL, HEADER_BYTES};
use crate::error::{Error, Result};
use crate::formats::replacement::Replacement;
use crate::formats::{file_error, has_ending};
use crate::geometry::Grid;

/// A type of voxel that can be written: `i16` for HU, `u8` for labels.
pub trait NiftiVoxel: Copy + sealed::Sealed {}

impl NiftiVoxel for i16 {}
impl NiftiVoxel for u8 {}

mod sealed {
    pub trait Sealed {
        const DATATYPE: i16;
        fn append(values: &[Self], bytes: &mut Vec<u8>)
        where
            Self: Sized;
    }

    impl Sealed for i16 {
        const DATATYPE: i16 = 4;
        fn append(values: &[Self], bytes: &mut Vec<u8>) {
            bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        }
    }

    impl Sealed for u8 {
        const DATATYPE: i16 = 2;
        fn append(values: &[Self], bytes: &mut Vec<u8>) {
            bytes.extend_from_slice(values);
        }
    }
}

enum Sink {
    Plain(Replacement),
    Gzip(Box<GzEncoder<Replacement>>),
}

/// A NIfTI-1 file being written; compressed when its name ends in `.gz`. The grid goes to sform in RAS, where the
/// format holds float32 only. Without `finish` no file appears.
pub struct NiftiWriter<T: NiftiVoxel> {
    path: std::path::PathBuf,
    sink: Sink,
    slice_voxels: usize,
    slices: usize,
    written: usize,
    bytes: Vec<u8>,
    voxel: PhantomData<T>,
}

impl<T: NiftiVoxel> NiftiWriter<T> {
    /// Starts a file with the dimensions and the place of `grid`.
    pub fn create(path: &Path, grid: &Grid) -> Result<Self> {
        let header = header(grid, T::DATATYPE, size_of::<T>())?;
        let file = Replacement::create(path)?;
        let sink = if has_ending(path, &[".gz"]) {
            Sink::Gzip(Box::new(GzEncoder::new(file, Compression::fast())))
        } else {
            Sink::Plain(file)
        };
        let [n0, n1, slices] = grid.dimensions();
        let (path, bytes) = (path.to_owned(), header);
        let mut writer =
            Self { path, sink, slice_voxels: n0 * n1, slices, written: 0, bytes, voxel: PhantomData };
        writer.flush()?;
        Ok(writer)
    }

    /// Writes the next slice: n0 × n1 voxels, voxel (i, j) at `j*n0 + i`.
    pub fn push_slice(&mut self, voxels: &[T]) -> Result<()> {
        if voxels.len() != self.slice_voxels {
            return Err(Error::invalid("voxels.len()", voxels.len(), self.slice_voxels.to_string()));
        }
        if self.written == self.slices {
            return Err(Error::invalid("slice", self.written, format!("0 … {}", self.slices - 1)));
        }
        self.written += 1;
        T::append(voxels, &mut self.bytes);
        self.flush()
    }

    /// Completes the file, for which all slices must have been written.
    pub fn finish(self) -> Result<()> {
        if self.written != self.slices {
            return Err(Error::invalid("slices written", self.written, self.slices.to_string()));
        }
        match self.sink {
            Sink::Plain(file) => file.commit(),
            Sink::Gzip(encoder) => encoder.finish().map_err(|e| file_error(&self.path, e))?.commit(),
        }
    }

    fn flush(&mut self) -> Result<()> {
        let done = match &mut self.sink {
            Sink::Plain(file) => file.write_all(&self.bytes),
            Sink::Gzip(encoder) => encoder.write_all(&self.bytes),
        };
        self.bytes.clear();
        done.map_err(|e| file_error(&self.path, e))
    }
}

/// The header, little-endian; offsets are those of the standard.
fn header(grid: &Grid, datatype: i16, voxel_bytes: usize) -> Result<Vec<u8>> {
    let mut header = vec![0; FIRST_VOXEL as usize];
    let mut put = |offset: usize, bytes: &[u8]| header[offset..offset + bytes.len()].copy_from_slice(bytes);
    put(0, &(HEADER_BYTES as i32).to_le_bytes());
    let mut dim = [3, 0, 0, 0, 1, 1, 1, 1];
    for (axis, n) in grid.dimensions().into_iter().enumerate() {
        let valid = format!("1 … {}, the most that NIfTI-1 can hold", i16::MAX);
        dim[axis + 1] =
            i16::try_from(n).map_err(|_| Error::invalid(format!("dimensions[{axis}]"), n, valid))?;
    }
    for (i, n) in dim.into_iter().enumerate() {
        put(40 + 2 * i, &n.to_le_bytes());
    }
    put(70, &datatype.to_le_bytes());
    put(72, &(8 * voxel_bytes as i16).to_le_bytes());
    let map = grid.index_to_world();
    let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis, map.translation];
    let [dx, dy, dz] = [columns[0], columns[1], columns[2]].map(DVec3::length);
    for (i, spacing) in [1.0, dx, dy, dz].into_iter().enumerate() {
        put(76 + 4 * i, &(spacing as f32).to_le_bytes());
    }
    put(108, &(FIRST_VOXEL as f32).to_le_bytes());
    put(112, &1_f32.to_le_bytes());
    put(123, &[2]); // mm
    put(254, &1_i16.to_le_bytes()); // sform: scanner coordinates
    for (i, column) in columns.into_iter().enumerate() {
        // LPS to RAS.
        for (row, value) in [-column.x, -column.y, column.z].into_iter().enumerate() {
            put(280 + 16 * row + 4 * i, &(value as f32).to_le_bytes());
        }
    }
    put(344, b"n+1\0");
    Ok(header)
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3};

    use super::*;
    use crate::formats::{Slice, VoxelKind, open_ct, open_labels};

    fn oblique(dimensions: [usize; 3]) -> Grid {
        // Sheared and mirrored; exact in float32.
        let matrix3 = DMat3::from_cols_array(&[0.5, 0.25, 0.0, -0.25, 0.75, 0.0, 0.0, 0.125, -2.5]);
        Grid::new(dimensions, DAffine3 { matrix3, translation: DVec3::new(-100.5, 20.0, 3.0) }).unwrap()
    }

    #[test]
    fn hu_and_labels_come_back_with_their_grid() {
        let grid = oblique([3, 2, 4]);
        let hu: Vec<i16> = (-12..12).map(|i| i * 2730).collect();
        let labels: Vec<u8> = (232..=255).collect();
        let folder = tempfile::tempdir().unwrap();
        for ending in ["nii", "nii.gz"] {
            let path = folder.path().join(format!("ct.{ending}"));
            let mut writer = NiftiWriter::create(&path, &grid).unwrap();
            for slice in hu.chunks(6) {
                writer.push_slice(slice).unwrap();
            }
            assert!(!path.exists(), "the name appears with the whole file");
            writer.finish().unwrap();
            let compressed = std::fs::read(&path).unwrap().starts_with(&[0x1f, 0x8b]);
            assert_eq!(compressed, ending == "nii.gz");
            let mut ct = open_ct(&path, None).unwrap();
            assert_eq!((ct.header().grid, ct.header().voxels), (grid, VoxelKind::Int16));
            ct.read(&mut |k, slice| {
                assert_eq!(slice, Slice::Int16(&hu[6 * k..6 * k + 6]));
                Ok(())
            })
            .unwrap();

            let path = folder.path().join(format!("labels.{ending}"));
            let mut writer = NiftiWriter::create(&path, &grid).unwrap();
            for slice in labels.chunks(6) {
                writer.push_slice(slice).unwrap();
            }
            writer.finish().unwrap();
            let mut read = vec![];
            open_labels(&path, &grid)
                .unwrap()
                .read(&mut |_, slice| {
                    read.extend_from_slice(slice);
                    Ok(())
                })
                .unwrap();
            assert_eq!(read, labels);
        }
    }

    #[test]
    fn only_whole_volumes_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ct.nii.gz");
        let mut writer = NiftiWriter::<i16>::create(&path, &oblique([2, 2, 1])).unwrap();
        assert!(writer.push_slice(&[0; 3]).unwrap_err().to_string().contains("valid: 4"));
        writer.push_slice(&[0; 4]).unwrap();
        assert!(writer.push_slice(&[0; 4]).is_err());
        drop(writer);
        let writer = NiftiWriter::<i16>::create(&path, &oblique([2, 2, 1])).unwrap();
        assert!(writer.finish().is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn dimensions_beyond_the_format_are_refused() {
        let path = tempfile::tempdir().unwrap().path().join("ct.nii");
        let message = NiftiWriter::<u8>::create(&path, &oblique([32768, 1, 1])).err().unwrap().to_string();
        assert!(message.contains("dimensions[0] is 32768"), "{message}");
    }
}
