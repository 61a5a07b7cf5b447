//! Labels from a file that is one array.

use std::path::Path;

use glam::DVec3;

use super::open;
use super::volume::StoredVolume;
use crate::allocation::grow;
use crate::error::Result;
use crate::formats::{Checked, LabelReader, file_error, nifti};
use crate::geometry::Grid;

/// Labels in NIfTI-1, MetaImage or NRRD, compressed or not; stored as any type, as long as every value is one of 0, 1, …, 255.
#[derive(Debug)]
pub struct StoredLabels {
    volume: StoredVolume,
}

impl StoredLabels {
    /// Opens a file whose voxels must be those of the CT.
    pub fn open(path: &Path, ct: &Grid) -> Result<Self> {
        Self::new(open::volume(path)?, ct)
    }

    /// Opens a NIfTI file that is part of the program; `name` stands for the path in messages.
    pub fn from_nifti(name: &str, bytes: &'static [u8], ct: &Grid) -> Result<Self> {
        Self::new(nifti::from_bytes(name, bytes)?, ct)
    }

    fn new(volume: StoredVolume, ct: &Grid) -> Result<Self> {
        check_same_voxels(&volume.array.grid, ct).map_err(|reason| file_error(volume.path(), reason))?;
        Ok(Self { volume })
    }
}

impl LabelReader for StoredLabels {
    fn grid(&self) -> &Grid {
        &self.volume.array.grid
    }

    fn read(&mut self, consume: &mut dyn FnMut(usize, &[u8]) -> Result<()>) -> Result<()> {
        let [n0, n1, _] = self.grid().dimensions();
        let mut labels: Vec<u8> = Vec::new();
        let mut slices = self.volume.slices()?;
        while let Some((k, bytes)) = slices.next_slice()? {
            grow(&mut labels, n0 * n1, 0, "a slice of labels")?;
            let mut wrong = None;
            let mut index = 0;
            self.volume.decode(bytes, |value| {
                let label = value as u8;
                if f64::from(label) != value && wrong.is_none() {
                    wrong = Some((index, value));
                }
                if let Some(place) = labels.get_mut(index) {
                    *place = label;
                }
                index += 1;
            });
            if let Some((index, value)) = wrong {
                let position = self.volume.position(index, k);
                let reason = format!("label at (i, j, k) = {position:?} is {value}; valid: 0, 1, …, 255");
                return Err(file_error(self.volume.path(), reason));
            }
            consume(k, &labels)?;
        }
        Ok(())
    }
}

/// Same dimensions, and every voxel within half a voxel of the CT's: flipped labels have the right dimensions too.
fn check_same_voxels(labels: &Grid, ct: &Grid) -> Checked<()> {
    let [own, wanted] = [labels, ct].map(|grid| {
        let [n0, n1, n2] = grid.dimensions();
        format!("{n0} x {n1} x {n2}")
    });
    if own != wanted {
        return Err(format!("has {own} labels, but the CT has {wanted} voxels"));
    }
    let last = DVec3::from_array(ct.dimensions().map(|n| n as f64 - 1.0));
    // An affine map differs most at a corner.
    for corner in 0..8 {
        let pick = |axis: u32| f64::from(corner >> axis & 1);
        let index = last * DVec3::new(pick(0), pick(1), pick(2));
        let [own, wanted] = [labels, ct].map(|grid| grid.index_to_world().transform_point3(index));
        let distance = (own - wanted).length();
        if distance > 0.5 * ct.smallest_spacing() {
            return Err(format!(
                "label {index} is at {own} mm, but the CT's voxel {index} is at {wanted} mm; valid: labels on the CT's grid"
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::formats::nifti::TestFile;
    use crate::formats::open_labels;

    fn ct_grid(dimensions: [usize; 3]) -> Grid {
        let mut map = DAffine3::from_scale(DVec3::new(1.0, -2.0, 3.0));
        map.translation.x = -10.0;
        Grid::new(dimensions, map).unwrap()
    }

    fn read(file: &TestFile, ct: &Grid) -> Result<Vec<u8>> {
        let (_folder, path) = TestFile::save("labels.nii.gz", &file.gzip());
        let mut labels = vec![];
        open_labels(&path, ct)?.read(&mut |_, slice| {
            labels.extend_from_slice(slice);
            Ok(())
        })?;
        Ok(labels)
    }

    #[test]
    fn labels_of_any_type_are_delivered_as_bytes() {
        let mut bytes = TestFile::new(false, [2, 1, 2], 2);
        bytes.voxels([[0], [1], [254], [255]]);
        let mut shorts = TestFile::new(true, [2, 1, 2], 4);
        shorts.voxels([0_i16, 1, 254, 255].map(i16::to_le_bytes));
        let mut doubles = TestFile::new(false, [2, 1, 2], 64);
        doubles.voxels([0.0, 1.0, 254.0, 255.0_f64].map(f64::to_le_bytes));
        for file in [bytes, shorts, doubles] {
            assert_eq!(read(&file, &ct_grid([2, 1, 2])).unwrap(), [0, 1, 254, 255]);
        }
    }

    #[test]
    fn values_beyond_a_byte_are_refused() {
        for (value, text) in [(-1.0, "-1"), (256.0, "256"), (0.5, "0.5"), (f32::NAN, "NaN")] {
            let mut file = TestFile::new(false, [2, 1, 2], 16);
            file.voxels([0.0, 0.0, 0.0, value].map(f32::to_le_bytes));
            let message = read(&file, &ct_grid([2, 1, 2])).unwrap_err().to_string();
            assert!(message.contains(text) && message.contains("[1, 0, 1]"), "{message}");
        }
    }

    #[test]
    fn other_dimensions_or_places_than_the_ct_are_refused() {
        let mut file = TestFile::new(false, [2, 1, 2], 2);
        file.voxels([[0]; 4]);
        let message = read(&file, &ct_grid([2, 1, 3])).unwrap_err().to_string();
        assert!(message.contains("2 x 1 x 2") && message.contains("2 x 1 x 3"), "{message}");
        file.put_f32(292, 10.25);
        assert!(read(&file, &ct_grid([2, 1, 2])).is_ok(), "a quarter of a voxel is tolerated");
        file.put_f32(292, 11.0).put_f32(280, 1.0);
        let message = read(&file, &ct_grid([2, 1, 2])).unwrap_err().to_string();
        assert!(message.contains("grid"), "{message}");
    }
}
