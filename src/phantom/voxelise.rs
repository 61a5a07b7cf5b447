//! Phantoms as voxel volumes, slice by slice.

use glam::DVec3;
use rayon::prelude::*;

use super::row::Row;
use super::{BACKGROUND_HU, BACKGROUND_MATERIAL, Part, Phantom, Sampling};
use crate::error::{Error, Result};
use crate::geometry::Grid;

impl Phantom {
    /// Gives the volume to `slice(k, hu, labels)`, one call per k in ascending order. Both slices have n0 · n1 voxels,
    /// i fastest; labels are material indices. Never holds more than one slice; an error of `slice` ends the work.
    ///
    /// With [`Sampling::PartialVolume`] the HU is the mean over the voxel, rounded half to even: exact where one
    /// cuboid or axis-parallel cylinder meets the voxel, otherwise from 256 exact chords. The label is the material
    /// other than air with the largest share, air only if there is none: a voxel with 10 % of soft tissue is soft
    /// tissue of a tenth of the density.
    ///
    /// # Errors
    /// `InvalidArgument` when the grid's axes are not those of the world, `OutOfMemory` when a slice does not fit.
    pub fn voxelise(
        &self,
        grid: &Grid,
        mut slice: impl FnMut(usize, &[i16], &[u8]) -> Result<()>,
    ) -> Result<()> {
        let lattice = Lattice::of(grid)?;
        let [width, height, depth] = grid.dimensions();
        let mut hu = reserve::<i16>(width * height)?;
        let mut labels = reserve::<u8>(width * height)?;
        for k in 0..depth {
            hu.clear();
            hu.resize(width * height, BACKGROUND_HU);
            labels.clear();
            labels.resize(width * height, BACKGROUND_MATERIAL);
            let present: Vec<usize> =
                (0..self.parts().len()).filter(|&n| lattice.meets(2, k, &self.parts()[n])).collect();
            hu.par_chunks_mut(width).zip(labels.par_chunks_mut(width)).enumerate().for_each_init(
                || Row::new(self, &lattice),
                |row, (j, (hu, labels))| {
                    row.select(&present, [j, k]);
                    match self.sampling {
                        Sampling::Centre => row.paint_centres(hu, labels),
                        Sampling::PartialVolume => row.paint_shares(hu, labels),
                    }
                    if self.noise {
                        row.add_noise(grid.dimensions(), hu);
                    }
                },
            );
            slice(k, &hu, &labels)?;
        }
        Ok(())
    }
}

fn reserve<T>(count: usize) -> Result<Vec<T>> {
    let mut buffer = Vec::new();
    buffer.try_reserve_exact(count).map_err(|_| Error::OutOfMemory {
        what: "a slice of the phantom".into(),
        bytes: count * size_of::<T>(),
    })?;
    Ok(buffer)
}

/// An axis-aligned grid.
pub(super) struct Lattice {
    dimensions: [usize; 3],
    origin: DVec3,
    /// Step per index, mm; negative on a mirrored axis.
    spacing: DVec3,
    /// Half a voxel, mm, positive.
    pub(super) half: DVec3,
}

impl Lattice {
    fn of(grid: &Grid) -> Result<Self> {
        let map = grid.index_to_world();
        let spacing = DVec3::new(map.matrix3.x_axis.x, map.matrix3.y_axis.y, map.matrix3.z_axis.z);
        if map.matrix3 != glam::DMat3::from_diagonal(spacing) {
            let text = format!("{:?}", map.matrix3);
            return Err(Error::invalid("grid.index_to_world", text, "a diagonal matrix and a translation"));
        }
        let half = 0.5 * spacing.abs();
        Ok(Self { dimensions: grid.dimensions(), origin: map.translation, spacing, half })
    }

    pub(super) fn centre(&self, [i, j, k]: [usize; 3]) -> DVec3 {
        DVec3::new(i as f64, j as f64, k as f64) * self.spacing + self.origin
    }

    /// Whether the part's bounds reach into the layer of voxels with this index along an axis.
    pub(super) fn meets(&self, axis: usize, index: usize, part: &Part) -> bool {
        let [low, high] = part.shape.bounds();
        let centre = index as f64 * self.spacing[axis] + self.origin[axis];
        low[axis] <= centre + self.half[axis] && high[axis] >= centre - self.half[axis]
    }

    /// Indices i of all voxels that the part's bounds may touch.
    pub(super) fn columns(&self, part: &Part) -> std::ops::Range<usize> {
        let ends = part.shape.bounds().map(|bound| (bound.x - self.origin.x) / self.spacing.x);
        // One voxel more on either side covers rounding; conversion saturates.
        let first = (ends[0].min(ends[1]) - 1.0).floor() as usize;
        let end = (ends[0].max(ends[1]) + 2.0).ceil() as usize;
        first.min(self.dimensions[0])..end.min(self.dimensions[0])
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::{DAffine3, DMat3};

    use super::*;
    use crate::phantom::Shape;
    use crate::phantom::thorax::noise;

    fn volume(phantom: &Phantom, grid: &Grid) -> (Vec<i16>, Vec<u8>) {
        let (mut hu, mut labels) = (Vec::new(), Vec::new());
        let collect = |k: usize, h: &[i16], l: &[u8]| {
            assert_eq!(hu.len(), k * h.len(), "slices come in order");
            hu.extend_from_slice(h);
            labels.extend_from_slice(l);
            Ok(())
        };
        phantom.voxelise(grid, collect).unwrap();
        (hu, labels)
    }

    /// Σ (HU + 1000) / 1000 times the voxel's volume: mm³ of water.
    fn mass(phantom: &Phantom, grid: &Grid) -> f64 {
        let m = grid.index_to_world().matrix3;
        let sum: f64 = volume(phantom, grid).0.iter().map(|&hu| f64::from(hu) + 1000.0).sum();
        sum / 1000.0 * m.determinant().abs()
    }

    fn single(shape: Shape) -> Phantom {
        Phantom::new("single", vec![Part { shape, hu: 1000, material: 3 }]).unwrap()
    }

    #[test]
    fn mass_is_that_of_the_solid() {
        let tilted = Shape::Cylinder {
            centre: DVec3::new(0.3, -0.2, 0.7),
            axis: DVec3::new(2.0, -1.0, 2.0) / 3.0,
            radius: 3.0,
            half_length: 11.0,
        };
        let across =
            Shape::Cylinder { centre: DVec3::splat(0.3), axis: DVec3::X, radius: 1.0, half_length: 9.0 };
        let egg = Shape::Ellipsoid { centre: DVec3::splat(0.4), semi_axes: DVec3::new(12.0, 7.0, 9.0) };
        let fine = Grid::centred([30, 28, 32], DVec3::new(0.9, 1.0, 0.8)).unwrap();
        let coarse = Grid::centred([64, 60, 50], DVec3::new(3.5, 3.7, 6.1)).unwrap();
        for (phantom, grid, expected) in [
            (Phantom::water_cylinder(), coarse, PI * 100.0 * 100.0 * 280.0),
            (single(tilted), fine, 2.0 * PI * 9.0 * 22.0),
            (single(across), fine, 2.0 * PI * 18.0),
            (single(egg), fine, 2.0 * 4.0 / 3.0 * PI * 12.0 * 7.0 * 9.0),
        ] {
            let error = mass(&phantom, &grid) / expected - 1.0;
            assert!(error.abs() < 1e-4, "{:?}: {error:.2e}", phantom.parts()[0].shape);
        }
    }

    #[test]
    fn mixed_voxels_are_the_mean_of_what_is_visible() {
        let parts = [
            (Shape::sphere(DVec3::ZERO, 9.0), 0, 2),
            (Shape::sphere(DVec3::new(5.0, 1.0, 0.0), 6.0), 600, 3),
            (
                Shape::Cylinder {
                    centre: DVec3::ZERO,
                    axis: DVec3::new(0.6, 0.0, 0.8),
                    radius: 2.5,
                    half_length: 12.0,
                },
                -800,
                1,
            ),
            (Shape::Cuboid { minimum: DVec3::splat(-7.3), maximum: DVec3::new(-1.0, 2.0, 3.1) }, 100, 2),
        ];
        let parts = parts.map(|(shape, hu, material)| Part { shape, hu, material });
        let phantom = Phantom::new("mixed", parts.to_vec()).unwrap();
        let grid = Grid::centred([8; 3], DVec3::splat(3.0)).unwrap();
        let (hu, labels) = volume(&phantom, &grid);
        let m = 16;
        for (n, &hu) in hu.iter().enumerate() {
            let centre = grid
                .index_to_world()
                .transform_point3([n % 8, n / 8 % 8, n / 64].map(|index| index as f64).into());
            let (mut mean, mut shares) = (0.0, [0.0; 4]);
            for p in 0..m * m * m {
                let at = DVec3::new(f64::from(p % m), f64::from(p / m % m), f64::from(p / m / m));
                let point = centre + 3.0 * ((at + 0.5) / f64::from(m) - 0.5);
                let top = parts.iter().rfind(|part| part.shape.contains(point));
                mean += f64::from(top.map_or(-1000, |part| part.hu)) / f64::from(m * m * m);
                shares[usize::from(top.map_or(0, |part| part.material))] += 1.0 / f64::from(m * m * m);
            }
            // Counting points is good to about one layer of them on a flat face: 1/32 of the largest step of 1600.
            assert!((f64::from(hu) - mean).abs() < 50.0, "{centre}: {hu} {mean}");
            let largest = shares[1..].iter().copied().fold(0.0, f64::max);
            let labelled = if labels[n] == 0 { 0.0 } else { shares[usize::from(labels[n])] };
            assert!(labelled >= largest - 0.05, "{centre}: {} of {shares:?}", labels[n]);
        }
    }

    #[test]
    fn boxes_have_the_mass_of_their_visible_parts() {
        let phantom = Phantom::boxes();
        let grid = Grid::centred([63, 62, 61], DVec3::new(4.0, 4.0, 3.9)).unwrap();
        let size = |n: usize| {
            let [low, high] = phantom.parts()[n].shape.bounds();
            (high - low).element_product()
        };
        // The first three are nested, in this order.
        let visible = [size(0) - size(1), size(1) - size(2), size(2), size(3), size(4), size(5), size(6)];
        let density = |n: usize| (f64::from(phantom.parts()[n].hu) + 1000.0) / 1000.0;
        let expected: f64 = visible.iter().enumerate().map(|(n, volume)| volume * density(n)).sum();
        let error = mass(&phantom, &grid) / expected - 1.0;
        assert!(error.abs() < 1e-4, "{error:.2e}");
    }

    #[test]
    fn a_tenth_of_tissue_is_tissue_of_a_tenth_of_the_density() {
        let slab = Shape::Cuboid { minimum: DVec3::splat(-1.5), maximum: DVec3::new(-1.4, 1.5, 1.5) };
        let part = Part { shape: slab, hu: 0, material: 2 };
        let phantom = Phantom::new("slab", vec![part]).unwrap();
        let (hu, labels) = volume(&phantom, &Grid::centred([3, 1, 1], DVec3::ONE).unwrap());
        assert_eq!((hu, labels), (vec![-900, -1000, -1000], vec![2, 0, 0]));
        let sampled = phantom.with_sampling(Sampling::Centre);
        let (hu, labels) = volume(&sampled, &Grid::centred([3, 1, 1], DVec3::ONE).unwrap());
        assert_eq!((hu, labels), (vec![-1000; 3], vec![0; 3]));
    }

    #[test]
    fn thorax_takes_the_last_part_at_the_centre_and_noise_stays_in_the_body() {
        let thorax = Phantom::thorax();
        let grid = thorax.grid([40, 36, 20]).unwrap();
        let (hu, labels) = volume(&thorax, &grid);
        let (noisy, noisy_labels) = volume(&thorax.clone().with_noise(true), &grid);
        let mut changed = 0;
        for n in 0..hu.len() {
            let index = [n % 40, n / 40 % 36, n / 1440].map(|index| index as f64);
            let point = grid.index_to_world().transform_point3(index.into());
            let top = thorax.parts().iter().rfind(|part| part.shape.contains(point));
            let expected = top.map_or((-1000, 0), |part| (part.hu, part.material));
            assert_eq!((hu[n], labels[n]), expected, "{point}");
            let added = if thorax.parts()[0].shape.contains(point) { noise(n as u32) } else { 0 };
            assert_eq!(noisy[n] - hu[n], added, "{point}");
            changed += usize::from(added != 0);
        }
        assert_eq!(labels, noisy_labels);
        assert!(changed > 5000);
    }

    #[test]
    fn a_mirrored_grid_mirrors_the_volume_and_a_turned_one_is_refused() {
        let phantom = Phantom::spheres();
        let spacing = DVec3::new(9.0, 9.0, 11.0);
        let grid = Grid::centred([31, 17, 23], spacing).unwrap();
        let map = grid.index_to_world();
        let mirrored = DAffine3 {
            matrix3: map.matrix3 * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
            translation: map.translation * DVec3::new(-1.0, 1.0, 1.0),
        };
        let (hu, _) = volume(&phantom, &grid);
        let (flipped, _) = volume(&phantom, &Grid::new([31, 17, 23], mirrored).unwrap());
        assert!(hu.chunks(31).zip(flipped.chunks(31)).all(|(a, b)| a.iter().eq(b.iter().rev())));
        assert!(hu.iter().any(|&value| value != -1000));

        let turned = DAffine3::from_rotation_z(0.1);
        let result = phantom.voxelise(&Grid::new([4; 3], turned).unwrap(), |_, _, _| Ok(()));
        assert!(matches!(result, Err(Error::InvalidArgument { .. })));
    }

    #[test]
    fn an_error_of_the_receiver_ends_the_work() {
        let phantom = Phantom::water_cylinder();
        let mut calls = 0;
        let result = phantom.voxelise(&phantom.grid([4, 4, 9]).unwrap(), |k, _, _| {
            calls += 1;
            if k == 2 { Err(Error::Unsupported("full".into())) } else { Ok(()) }
        });
        assert_eq!((result, calls), (Err(Error::Unsupported("full".into())), 3));
    }
}
