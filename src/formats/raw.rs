//! Raw little-endian arrays without a header.

use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::allocation::{grow, reserved};
use crate::error::Result;
use crate::formats::replacement::Replacement;
use crate::formats::slices::SliceStream;
use crate::formats::{CtHeader, CtReader, LabelReader, Slice, VoxelKind, file_error};
use crate::geometry::Grid;

/// What a raw volume doesn't say of itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawLayout {
    /// Voxels along x, y, z; x runs fastest in the file.
    pub dimensions: [usize; 3],
    /// Distance of voxel centres along x, y, z, mm.
    pub spacing: DVec3,
    /// World position of the centre of voxel (0, 0, 0), mm.
    pub origin: DVec3,
}

/// A raw volume of little-endian int16 HU, x fastest.
#[derive(Debug)]
pub struct RawCt {
    path: PathBuf,
    header: CtHeader,
}

impl RawCt {
    /// Opens a raw volume; the file must have exactly the size that the layout gives.
    pub fn open(path: &Path, layout: RawLayout) -> Result<Self> {
        let grid = Grid::axis_aligned(layout.dimensions, layout.spacing, layout.origin)?;
        check_size(path, &grid, size_of::<i16>())?;
        Ok(Self { path: path.to_owned(), header: CtHeader { grid, voxels: VoxelKind::Int16 } })
    }
}

impl CtReader for RawCt {
    fn header(&self) -> &CtHeader {
        &self.header
    }

    fn read(&mut self, consume: &mut dyn FnMut(usize, Slice<'_>) -> Result<()>) -> Result<()> {
        let [n0, n1, _] = self.header.grid.dimensions();
        let mut voxels: Vec<i16> = Vec::new();
        let mut slices = open_slices(&self.path, &self.header.grid, size_of::<i16>())?;
        while let Some((k, bytes)) = slices.next_slice()? {
            grow(&mut voxels, n0 * n1, 0, "a slice of voxels")?;
            for (voxel, &bytes) in voxels.iter_mut().zip(bytes.as_chunks().0) {
                *voxel = i16::from_le_bytes(bytes);
            }
            consume(k, Slice::Int16(&voxels))?;
        }
        Ok(())
    }
}

/// A raw volume of uint8 labels, x fastest.
#[derive(Debug)]
pub struct RawLabels {
    path: PathBuf,
    grid: Grid,
}

impl RawLabels {
    /// Opens labels on the grid of a CT; the file must have exactly one byte per voxel.
    pub fn open(path: &Path, ct: &Grid) -> Result<Self> {
        check_size(path, ct, 1)?;
        Ok(Self { path: path.to_owned(), grid: *ct })
    }
}

impl LabelReader for RawLabels {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn read(&mut self, consume: &mut dyn FnMut(usize, &[u8]) -> Result<()>) -> Result<()> {
        let mut slices = open_slices(&self.path, &self.grid, 1)?;
        while let Some((k, labels)) = slices.next_slice()? {
            consume(k, labels)?;
        }
        Ok(())
    }
}

/// Reads so many little-endian float32 values.
///
/// # Errors
/// `File` for a file of another size; `OutOfMemory`.
pub fn read_raw_f32(path: &Path, count: usize) -> Result<Vec<f32>> {
    let mut file = BufReader::new(File::open(path).map_err(|e| file_error(path, e))?);
    let actual = std::fs::metadata(path).map_err(|e| file_error(path, e))?.len();
    let expected = (count * size_of::<f32>()) as u64;
    if actual != expected {
        let reason = format!("has {actual} bytes, but {count} values of 4 bytes are {expected} bytes");
        return Err(file_error(path, reason));
    }
    let mut values = reserved(count, "the values of a file")?;
    let mut bytes = [0; size_of::<f32>()];
    for _ in 0..count {
        file.read_exact(&mut bytes).map_err(|e| file_error(path, e))?;
        values.push(f32::from_le_bytes(bytes));
    }
    Ok(values)
}

/// Writes float32 values, little-endian, in the order given.
pub fn write_raw_f32(path: &Path, values: &[f32]) -> Result<()> {
    write(path, values, f32::to_le_bytes)
}

/// Writes float64 values, little-endian, in the order given.
pub fn write_raw_f64(path: &Path, values: &[f64]) -> Result<()> {
    write(path, values, f64::to_le_bytes)
}

fn write<T: Copy, const N: usize>(path: &Path, values: &[T], bytes: fn(T) -> [u8; N]) -> Result<()> {
    let mut file = Replacement::create(path)?;
    for &value in values {
        file.write_all(&bytes(value)).map_err(|e| file_error(path, e))?;
    }
    file.commit()
}

fn check_size(path: &Path, grid: &Grid, voxel_bytes: usize) -> Result<()> {
    let actual = std::fs::metadata(path).map_err(|e| file_error(path, e))?.len();
    let expected = (grid.voxel_count() * voxel_bytes) as u64;
    if actual != expected {
        let [n0, n1, n2] = grid.dimensions();
        let reason = format!(
            "has {actual} bytes, but {n0} x {n1} x {n2} voxels of {voxel_bytes} byte(s) are {expected} bytes"
        );
        return Err(file_error(path, reason));
    }
    Ok(())
}

fn open_slices(path: &Path, grid: &Grid, voxel_bytes: usize) -> Result<SliceStream> {
    let file = File::open(path).map_err(|e| file_error(path, e))?;
    let [n0, n1, n2] = grid.dimensions();
    Ok(SliceStream::new(path, Box::new(BufReader::new(file)), n0 * n1 * voxel_bytes, n2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let values = [1.5, -0.0, f32::INFINITY, 1e-40];
        write_raw_f32(file.path(), &values).unwrap();
        assert_eq!(read_raw_f32(file.path(), 4).unwrap(), values);
        let error = read_raw_f32(file.path(), 5).unwrap_err().to_string();
        assert!(error.contains("has 16 bytes, but 5 values of 4 bytes are 20 bytes"), "{error}");
    }
    use crate::formats::{open_ct, open_labels};

    const LAYOUT: RawLayout =
        RawLayout { dimensions: [3, 2, 2], spacing: DVec3::new(0.5, 1.0, 2.0), origin: DVec3::ONE };

    #[test]
    fn int16_voxels_come_slice_by_slice_as_often_as_asked() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let values: Vec<i16> = (-6..6).map(|i| i * 5461).collect();
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(file.path(), bytes).unwrap();
        let mut ct = open_ct(file.path(), Some(LAYOUT)).unwrap();
        assert_eq!(ct.header().voxels, VoxelKind::Int16);
        assert_eq!(ct.header().grid.index_to_world().transform_point3(DVec3::ONE), DVec3::new(1.5, 2.0, 3.0));
        for _ in 0..2 {
            let mut read = vec![];
            ct.read(&mut |k, slice| {
                assert_eq!(k * 6, read.len());
                let Slice::Int16(voxels) = slice else { panic!("int16 was promised") };
                read.extend_from_slice(voxels);
                Ok(())
            })
            .unwrap();
            assert_eq!(read, values);
        }
    }

    #[test]
    fn a_wrong_size_is_refused_with_both_sizes() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), [0; 25]).unwrap();
        let message = open_ct(file.path(), Some(LAYOUT)).err().unwrap().to_string();
        assert!(message.contains("25 bytes") && message.contains("24 bytes"), "{message}");
        let grid = Grid::axis_aligned(LAYOUT.dimensions, LAYOUT.spacing, LAYOUT.origin).unwrap();
        let message = open_labels(file.path(), &grid).err().unwrap().to_string();
        assert!(message.contains("25 bytes") && message.contains("12 bytes"), "{message}");
    }

    #[test]
    fn a_claimed_size_is_checked_before_memory_is_taken() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), [0; 24]).unwrap();
        let layout = RawLayout { dimensions: [1 << 15, 1 << 15, 4], ..LAYOUT };
        let message = open_ct(file.path(), Some(layout)).err().unwrap().to_string();
        assert!(message.contains("24 bytes") && message.contains("8589934592 bytes"), "{message}");
    }

    #[test]
    fn a_file_of_unknown_format_is_refused() {
        assert!(open_ct(Path::new("ct.img"), None).err().unwrap().to_string().contains(".nii.gz"));
    }

    #[test]
    fn floats_are_little_endian_and_keep_their_bits() {
        let file = tempfile::NamedTempFile::new().unwrap();
        write_raw_f32(file.path(), &[1.0, f32::NAN, -0.0]).unwrap();
        assert_eq!(std::fs::read(file.path()).unwrap(), [0, 0, 0x80, 0x3f, 0, 0, 0xc0, 0x7f, 0, 0, 0, 0x80]);
        write_raw_f64(file.path(), &[-2.0]).unwrap();
        assert_eq!(std::fs::read(file.path()).unwrap(), [0, 0, 0, 0, 0, 0, 0, 0xc0]);
    }
}
