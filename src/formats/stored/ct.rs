//! HU from a file that is one array.

use std::path::Path;

use super::open;
use super::volume::StoredVolume;
use crate::allocation::grow;
use crate::error::Result;
use crate::formats::{CtHeader, CtReader, Slice, VoxelKind, file_error, nifti};

/// A CT that is one array: NIfTI-1, MetaImage or NRRD, compressed or not, of any integer or float type, in either byte
/// order.
#[derive(Debug)]
pub struct StoredCt {
    volume: StoredVolume,
    header: CtHeader,
}

impl StoredCt {
    /// Opens a file, whose name says what it is. Integers that might not fit an int16 by their type and scaling are read
    /// once to see.
    pub fn open(path: &Path) -> Result<Self> {
        Self::new(open::volume(path)?)
    }

    /// Opens a NIfTI file that is part of the program; `name` stands for the path in messages.
    pub fn from_nifti(name: &str, bytes: &'static [u8]) -> Result<Self> {
        Self::new(nifti::from_bytes(name, bytes)?)
    }

    fn new(volume: StoredVolume) -> Result<Self> {
        let header = CtHeader { grid: volume.array.grid, voxels: voxel_kind(&volume)? };
        Ok(Self { volume, header })
    }

    fn read_int16(&self, consume: &mut dyn FnMut(usize, Slice<'_>) -> Result<()>) -> Result<()> {
        let [n0, n1, _] = self.header.grid.dimensions();
        let mut voxels: Vec<i16> = Vec::new();
        let mut slices = self.volume.slices()?;
        while let Some((k, bytes)) = slices.next_slice()? {
            grow(&mut voxels, n0 * n1, 0, "a slice of voxels")?;
            let mut places = voxels.iter_mut();
            // Exact: `voxel_kind` has established that every value fits.
            self.volume.decode(bytes, |value| {
                if let Some(place) = places.next() {
                    *place = value as i16;
                }
            });
            consume(k, Slice::Int16(&voxels))?;
        }
        Ok(())
    }

    fn read_float32(&self, consume: &mut dyn FnMut(usize, Slice<'_>) -> Result<()>) -> Result<()> {
        let [n0, n1, _] = self.header.grid.dimensions();
        let mut voxels: Vec<f32> = Vec::new();
        let mut not_finite = 0_usize;
        let mut first = [0; 3];
        let mut slices = self.volume.slices()?;
        while let Some((k, bytes)) = slices.next_slice()? {
            grow(&mut voxels, n0 * n1, 0.0, "a slice of voxels")?;
            let mut places = voxels.iter_mut();
            self.volume.decode(bytes, |value| {
                if let Some(place) = places.next() {
                    *place = value as f32;
                }
            });
            if let Some(index) = voxels.iter().position(|v| !v.is_finite()) {
                if not_finite == 0 {
                    first = self.volume.position(index, k);
                }
                not_finite += voxels[index..].iter().filter(|v| !v.is_finite()).count();
            }
            // After the first bad voxel the rest of the file is only counted.
            if not_finite == 0 {
                consume(k, Slice::Float32(&voxels))?;
            }
        }
        if not_finite > 0 {
            let reason = format!(
                "{not_finite} voxel(s) are NaN or infinite, the first at (i, j, k) = {first:?}; valid: finite HU"
            );
            return Err(file_error(self.volume.path(), reason));
        }
        Ok(())
    }
}

impl CtReader for StoredCt {
    fn header(&self) -> &CtHeader {
        &self.header
    }

    fn read(&mut self, consume: &mut dyn FnMut(usize, Slice<'_>) -> Result<()>) -> Result<()> {
        match self.header.voxels {
            VoxelKind::Int16 => self.read_int16(consume),
            VoxelKind::Float32 => self.read_float32(consume),
        }
    }
}

/// Int16 when every HU is whole and fits, by the type's range where that suffices, otherwise by looking.
fn voxel_kind(volume: &StoredVolume) -> Result<VoxelKind> {
    let array = &volume.array;
    let Some(range) = array.storage.integer_range() else { return Ok(VoxelKind::Float32) };
    if array.slope.fract() != 0.0 || array.intercept.fract() != 0.0 {
        return Ok(VoxelKind::Float32);
    }
    let fits = |value: f64| (f64::from(i16::MIN)..=f64::from(i16::MAX)).contains(&value);
    if range.iter().all(|&stored| fits(array.slope * stored + array.intercept)) {
        return Ok(VoxelKind::Int16);
    }
    let mut slices = volume.slices()?;
    while let Some((_, bytes)) = slices.next_slice()? {
        let mut all_fit = true;
        volume.decode(bytes, |value| all_fit &= fits(value));
        if !all_fit {
            return Ok(VoxelKind::Float32);
        }
    }
    Ok(VoxelKind::Int16)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::formats::nifti::TestFile;
    use crate::formats::{open_ct, test_volume};

    /// The voxels, all slices one after the other, and their kind.
    fn read(bytes: &[u8]) -> Result<(VoxelKind, Vec<f64>)> {
        let (_folder, path) = TestFile::save("ct.nii", bytes);
        let (_, kind, values) = test_volume::read(&path)?;
        Ok((kind, values))
    }

    #[test]
    fn every_type_and_byte_order_gives_its_values() {
        let values = [0.0, 1.0, 2.0, 100.0, 126.0, 127.0];
        macro_rules! check {
            ($($number:ty, $datatype:literal, $kind:ident);*) => {$(
                for big in [false, true] {
                    let mut file = TestFile::new(big, [3, 1, 2], $datatype);
                    file.voxels(values.map(|v| (v as $number).to_le_bytes()));
                    assert_eq!(read(&file.bytes).unwrap(), (VoxelKind::$kind, values.to_vec()), "{}", $datatype);
                    assert_eq!(read(&file.gzip()).unwrap(), (VoxelKind::$kind, values.to_vec()), "{}", $datatype);
                }
            )*};
        }
        check!(u8, 2, Int16; i8, 256, Int16; u16, 512, Int16; i16, 4, Int16; u32, 768, Int16; i32, 8, Int16;
            u64, 1280, Int16; i64, 1024, Int16; f32, 16, Float32; f64, 64, Float32);
    }

    #[test]
    fn int16_is_chosen_only_when_every_value_fits() {
        let kind = |slope: f32, intercept: f32, values: [u16; 2]| {
            let mut file = TestFile::new(false, [1, 1, 2], 512);
            file.put_f32(112, slope).put_f32(116, intercept).voxels(values.map(u16::to_le_bytes));
            read(&file.bytes).unwrap()
        };
        assert_eq!(kind(1.0, 0.0, [5, 32767]), (VoxelKind::Int16, vec![5.0, 32767.0]));
        assert_eq!(kind(1.0, 0.0, [5, 32768]), (VoxelKind::Float32, vec![5.0, 32768.0]));
        assert_eq!(kind(1.0, -1024.0, [0, 4095]), (VoxelKind::Int16, vec![-1024.0, 3071.0]));
        assert_eq!(kind(-1.0, 0.0, [0, 32768]), (VoxelKind::Int16, vec![0.0, -32768.0]));
        assert_eq!(kind(0.5, 0.0, [3, 4]), (VoxelKind::Float32, vec![1.5, 2.0]));
        assert_eq!(kind(1.0, 0.25, [3, 4]), (VoxelKind::Float32, vec![3.25, 4.25]));
    }

    #[test]
    fn int16_extremes_survive() {
        let mut file = TestFile::new(true, [2, 1, 1], 4);
        file.voxels([i16::MIN, i16::MAX].map(i16::to_le_bytes));
        assert_eq!(read(&file.bytes).unwrap().1, [-32768.0, 32767.0]);
    }

    #[test]
    fn the_grid_is_in_lps() {
        let (_folder, path) =
            TestFile::save("CT.NII.GZ", &TestFile::new(false, [1, 1, 1], 2).voxels([[1]]).gzip());
        let map = open_ct(&path, None).unwrap().header().grid.index_to_world();
        // diag(−1, 2, 3) and the origin (10, 0, 0) in RAS.
        assert_eq!(map.transform_point3(DVec3::ONE), DVec3::new(-9.0, -2.0, 3.0));
        assert!(map.matrix3.determinant() < 0.0);
    }

    #[test]
    fn voxels_that_are_not_finite_are_counted_and_not_delivered() {
        let mut file = TestFile::new(false, [2, 2, 3], 64);
        let mut values = [0.0; 12];
        values[7] = f64::NAN; // (1, 1, 1)
        values[8] = f64::INFINITY;
        values[11] = 1e300; // too large for float32
        file.voxels(values.map(f64::to_le_bytes));
        let (_folder, path) = TestFile::save("ct.nii", &file.bytes);
        let mut slices = vec![];
        let result = StoredCt::open(&path).unwrap().read(&mut |k, _| {
            slices.push(k);
            Ok(())
        });
        let message = result.unwrap_err().to_string();
        assert!(message.contains("3 voxel(s)") && message.contains("[1, 1, 1]"), "{message}");
        assert_eq!(slices, [0]);
    }

    #[test]
    fn extensions_before_the_voxels_are_skipped() {
        let mut file = TestFile::new(false, [2, 1, 1], 2);
        file.put_f32(108, 368.0).bytes.extend([9; 16]);
        file.voxels([[3], [4]]);
        assert_eq!(read(&file.bytes).unwrap().1, [3.0, 4.0]);
    }

    #[test]
    fn truncated_files_are_refused() {
        let mut file = TestFile::new(false, [64, 64, 4], 8);
        file.voxels((0..64 * 64 * 4).map(i32::to_le_bytes));
        assert!(read(&file.bytes).is_ok());
        let plain = read(&file.bytes[..file.bytes.len() - 1]).unwrap_err().to_string();
        assert!(plain.contains("truncated") && plain.contains("65888") && plain.contains("65887"), "{plain}");
        let header = read(&file.bytes[..347]).unwrap_err().to_string();
        assert!(header.contains("348"), "{header}");

        let gzip = file.gzip();
        assert!(read(&gzip[..gzip.len() / 2]).is_err());
        // All voxels are there, but the checksum at the end is cut off or wrong.
        assert!(read(&gzip[..gzip.len() - 6]).is_err());
        let mut damaged = gzip.clone();
        damaged[gzip.len() - 8] ^= 1;
        assert!(read(&damaged).is_err());
        // The stream is sound, but shorter than the header says.
        file.bytes.truncate(352 + 64 * 64 * 4 * 2 + 5);
        let short = read(&file.gzip()).unwrap_err().to_string();
        assert!(short.contains("slice 2 of 4"), "{short}");
    }

    #[test]
    fn a_claimed_size_is_checked_before_memory_is_taken() {
        for dimensions in [[32767, 32767, 1024], [32767, 32767, 7], [32767, 32767, 32767]] {
            let mut file = TestFile::new(false, dimensions, 64);
            file.voxels([[0]; 100]);
            for bytes in [file.bytes.clone(), file.gzip()] {
                let message = read(&bytes).unwrap_err().to_string();
                assert!(message.contains("truncated") || message.contains("voxels in all"), "{message}");
            }
        }
    }

    #[test]
    fn a_file_that_expands_without_end_is_not_read_to_its_end() {
        let mut file = TestFile::new(false, [2, 1, 1], 4);
        file.voxels([[3, 0], [4, 0]]).bytes.resize(1 << 26, 0);
        let mut bytes = file.gzip();
        assert!(bytes.len() < 1 << 19);
        // Damage beyond what is allowed to follow the voxels would be found if it were reached.
        let middle = bytes.len() / 2;
        bytes[middle..].fill(0xff);
        let message = read(&bytes).unwrap_err().to_string();
        assert!(message.contains("after its last voxel"), "{message}");
    }

    #[test]
    fn embedded_bytes_are_read_like_a_file() {
        let mut file = TestFile::new(false, [2, 1, 1], 4);
        file.voxels([[3, 0], [4, 0]]);
        let mut ct = StoredCt::from_nifti("embedded", file.gzip().leak()).unwrap();
        ct.read(&mut |_, slice| {
            assert_eq!(slice, Slice::Int16(&[3, 4]));
            Ok(())
        })
        .unwrap();
        assert!(
            StoredCt::from_nifti("embedded", b"nonsense").unwrap_err().to_string().starts_with("embedded: ")
        );
    }

    #[test]
    fn an_error_of_the_consumer_ends_the_reading() {
        let mut file = TestFile::new(false, [1, 1, 9], 2);
        file.voxels([[0]; 9]);
        let mut ct = StoredCt::from_nifti("embedded", file.gzip().leak()).unwrap();
        let mut count = 0;
        let result = ct.read(&mut |_, _| {
            count += 1;
            Err(crate::Error::Unsupported("stop".to_owned()))
        });
        assert_eq!((result.unwrap_err().to_string().as_str(), count), ("stop", 1));
    }
}
