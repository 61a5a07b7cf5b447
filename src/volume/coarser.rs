//! A volume of fewer, larger voxels.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::{Error, Result};
use crate::physics::MAX_MATERIALS;
use crate::volume::{MaterialStatistics, Volume, Voxel, Voxels};

impl Volume {
    /// The volume in voxels twice as large along each axis that has more than one: mean densities of 2×2×2 voxels, vacuum
    /// beyond the end, so that mass stays; the label is the one with the most mass. Labels as given, or as thresholds made
    /// them, keep their meaning.
    ///
    /// # Errors
    /// `InvalidArgument` where voxels become too large for a grid; `Unsupported` for voxels in a texture; `OutOfMemory`.
    pub fn coarser(&self) -> Result<Self> {
        if let Voxels::Texture { .. } = self.voxels {
            return Err(Error::Unsupported("voxels in a texture are not read here: no means of them".into()));
        }
        let fine = self.grid.dimensions();
        let block = fine.map(|n| n.min(2));
        let grid = self.grid.of_blocks(block)?;
        let [nx, ny, _] = grid.dimensions();
        let count = grid.voxel_count();
        let mut density = filled(count, 0.0_f32, "the coarser volume")?;
        let mut label = filled(count, 0_u8, "the coarser volume's labels")?;
        let rows = density.par_chunks_mut(nx).zip(label.par_chunks_mut(nx)).enumerate();
        rows.for_each(|(row, (densities, labels))| {
            for (i, (density, label)) in densities.iter_mut().zip(labels).enumerate() {
                let voxel = self.block([i, row % ny, row / ny], block);
                (*density, *label) = (voxel.density as f32, voxel.label);
            }
        });
        let mut materials = [MaterialStatistics::default(); MAX_MATERIALS];
        for (&density, &label) in density.iter().zip(&label) {
            materials[usize::from(label)].note(Voxel { density: f64::from(density), label });
        }
        let voxels = Voxels::Dense { density, label };
        Ok(Self::made(grid, voxels, materials, self.classes.clone(), self.how.clone()))
    }

    /// The mean of a block's voxels.
    fn block(&self, at: [usize; 3], block: [usize; 3]) -> Voxel {
        let n = self.grid.dimensions();
        let mut masses = [0.0; MAX_MATERIALS];
        // Where all is vacuum, the first voxel's label.
        let mut label = None;
        let range = |axis: usize| at[axis] * block[axis]..n[axis].min((at[axis] + 1) * block[axis]);
        for (k, j) in range(2).flat_map(|k| range(1).map(move |j| (k, j))) {
            for i in range(0) {
                let voxel = self.voxels.get((k * n[1] + j) * n[0] + i);
                masses[usize::from(voxel.label)] += voxel.density;
                label = label.or(Some(voxel.label));
            }
        }
        let first = usize::from(label.unwrap_or_default());
        let most = (0..MAX_MATERIALS).fold(first, |most, m| if masses[m] > masses[most] { m } else { most });
        let density = masses.iter().sum::<f64>() / block.iter().product::<usize>() as f64;
        Voxel { density, label: most as u8 }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3, DVec3};

    use super::*;
    use crate::geometry::Grid;
    use crate::physics::{Calibration, Thresholds};
    use crate::volume::Classification;

    #[test]
    fn mass_and_its_centre_stay() {
        let matrix3 = DMat3::from_cols(DVec3::new(-1.0, 0.1, 0.0), DVec3::Y * 2.0, DVec3::new(0.0, 0.3, 1.5));
        let grid = Grid::new([4, 6, 2], DAffine3 { matrix3, translation: DVec3::new(3.0, 4.0, 5.0) })
            .expect("valid");
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("known");
        // Equal within blocks, so that their mass is in their middle.
        let value =
            |n: usize| [n % 4 / 2, n / 4 % 6 / 2, n / 24 / 2].iter().fold(1, |hash, i| 5 * hash + i) % 7;
        let hu: Vec<f32> = (0..48).map(|n| 100.0 * value(n) as f32).collect();
        let fine = Volume::from_float32(grid, &hu, None, &how).expect("valid");
        let coarse = fine.coarser().expect("valid");
        assert_eq!(coarse.grid().dimensions(), [2, 3, 1]);
        let moments = |volume: &Volume| {
            let [nx, ny, _] = volume.grid().dimensions();
            let cell = volume.grid().index_to_world().matrix3.determinant().abs();
            (0..volume.grid().voxel_count()).fold((0.0, DVec3::ZERO), |(mass, moment), n| {
                let index = DVec3::new((n % nx) as f64, (n / nx % ny) as f64, (n / nx / ny) as f64);
                let own = cell * volume.voxels().get(n).density;
                (mass + own, moment + own * volume.grid().index_to_world().transform_point3(index))
            })
        };
        let ((mass, moment), (coarse_mass, coarse_moment)) = (moments(&fine), moments(&coarse));
        assert!((coarse_mass / mass - 1.0).abs() < 1e-6, "{mass} {coarse_mass}");
        assert!((moment - coarse_moment).length() < 1e-6 * moment.length());
        assert_eq!(coarse.classes(), fine.classes());
    }

    #[test]
    fn the_heavier_material_names_the_block_and_nothing_lies_beyond_the_end() {
        let grid = Grid::centred([3, 1, 1], DVec3::ONE).expect("valid");
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("known");
        let labels = [2, 3, 1];
        let fine = Volume::from_float32(grid, &[0.0, 900.0, 0.0], Some(&labels), &how).expect("valid");
        let coarse = fine.coarser().expect("valid");
        let [own, means] = [&fine, &coarse].map(|volume| [0, 1].map(|n| volume.voxels().get(n)));
        assert_eq!(coarse.grid().dimensions(), [2, 1, 1]);
        assert_eq!(means.map(|voxel| voxel.label), [3, 1]);
        assert!((means[0].density / (0.5 * (own[0].density + own[1].density)) - 1.0).abs() < 1e-6);
        assert!((means[1].density / (0.5 * fine.voxels().get(2).density) - 1.0).abs() < 1e-6);
        // The first voxel's outer face stays.
        let face =
            |volume: &Volume| volume.grid().index_to_world().transform_point3(DVec3::new(-0.5, 0.0, 0.0));
        assert!((face(&fine) - face(&coarse)).length() < 1e-12);
    }
}
