//! Volumes and images of fewer, larger voxels and pixels.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::{Error, Result};
use crate::parallel::ParallelGeometry;
use crate::pixel_blocks::PixelBlocks;
use crate::real::Real;
use crate::values::check_count;

/// How many voxels or pixels become one, along each axis, in one geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockMeans {
    fine: ParallelGeometry,
    coarse: ParallelGeometry,
    /// Along x, y, z of the volume.
    voxels: [usize; 3],
    /// Along u, v of images.
    pixels: PixelBlocks,
}

impl BlockMeans {
    /// Blocks of `voxels` along x, y, z and `pixels` along u, v; steps grow like voxels along y. A volume whose size is no
    /// multiple gets 0 beyond its end, which the field is there, so that sums stay; of an image, columns and rows that fill
    /// no block are left out. Centres move so that nothing else does.
    ///
    /// # Errors
    /// `InvalidArgument` for a geometry that is not valid, blocks of 0, and blocks larger than the image.
    pub fn new(fine: ParallelGeometry, voxels: [usize; 3], pixels: [usize; 2]) -> Result<Self> {
        fine.validate()?;
        if voxels.contains(&0) {
            return Err(Error::invalid("voxels", format!("{voxels:?}"), "at least 1 along each axis"));
        }
        if (0..2).any(|axis| pixels[axis] == 0 || pixels[axis] > fine.detector[axis]) {
            let [nu, nv] = fine.detector;
            return Err(Error::invalid("pixels", format!("{pixels:?}"), format!("1 … [{nu}, {nv}]")));
        }
        let mut coarse = fine;
        for (axis, &block) in voxels.iter().enumerate() {
            let n = fine.dimensions[axis];
            coarse.dimensions[axis] = n.div_ceil(block);
            coarse.spacing[axis] *= block as f64;
            let beyond = coarse.dimensions[axis] * block - n;
            coarse.centre[axis] += 0.5 * beyond as f64 * fine.spacing[axis];
        }
        for (axis, &block) in pixels.iter().enumerate() {
            let n = fine.detector[axis];
            coarse.pixel[axis] *= block as f64;
            coarse.detector_centre[axis] -= 0.5 * (n % block) as f64 * fine.pixel[axis];
        }
        let pixels = PixelBlocks::new(fine.detector, pixels);
        coarse.detector = pixels.size();
        coarse.step *= voxels[1] as f64;
        coarse.steps = fine.steps.div_ceil(voxels[1]);
        coarse.validate()?;
        Ok(Self { fine, coarse, voxels, pixels })
    }

    /// The geometry of the means.
    pub fn geometry(&self) -> &ParallelGeometry {
        &self.coarse
    }

    /// The volume's means, x fastest.
    ///
    /// # Errors
    /// `InvalidArgument` for a volume of another size; `OutOfMemory`.
    pub fn volume<T: Real>(&self, volume: &[T]) -> Result<Vec<T>> {
        let ([nx, ny, nz], [bx, by, bz]) = (self.fine.dimensions, self.voxels);
        check_count("volume", volume.len(), nx * ny * nz, "voxel")?;
        let [mx, my, mz] = self.coarse.dimensions;
        let mut means = filled(mx * my * mz, T::default(), "the means of voxels")?;
        let part = 1.0 / (bx * by * bz) as f64;
        means.par_chunks_mut(mx).enumerate().for_each(|(row, means)| {
            let (j, k) = (row % my, row / my);
            for (i, mean) in means.iter_mut().enumerate() {
                let mut sum = 0.0;
                for z in k * bz..nz.min((k + 1) * bz) {
                    for y in j * by..ny.min((j + 1) * by) {
                        let row = (z * ny + y) * nx;
                        let block = &volume[row + i * bx..row + nx.min((i + 1) * bx)];
                        sum += block.iter().map(|&value| -> f64 { value.into() }).sum::<f64>();
                    }
                }
                *mean = T::of(part * sum);
            }
        });
        Ok(means)
    }

    /// An image's means, `v*nu + u`.
    ///
    /// # Errors
    /// `InvalidArgument` for an image of another size; `OutOfMemory`.
    pub fn image<T: Real>(&self, image: &[T]) -> Result<Vec<T>> {
        check_count("image", image.len(), self.fine.pixels(), "pixel")?;
        self.pixels.means(image)
    }

    /// Which pixels' means count: those of which every part does.
    ///
    /// # Errors
    /// `InvalidArgument` for a mask of another size; `OutOfMemory`.
    pub fn mask(&self, mask: &[bool]) -> Result<Vec<bool>> {
        check_count("mask", mask.len(), self.fine.pixels(), "pixel")?;
        self.pixels.mask(mask)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn odd() -> ParallelGeometry {
        let mut geometry = ParallelGeometry::new([5, 4, 7], DVec3::new(1.0, 2.0, 3.0), [5, 7], [0.5, 0.25]);
        geometry.centre = DVec3::new(10.0, -20.0, 30.0);
        geometry.detector_centre = [3.0, -4.0];
        geometry
    }

    /// Σ value · position, which means in the right places keep.
    fn moment(geometry: &ParallelGeometry, volume: &[f64]) -> (f64, DVec3) {
        let grid = geometry.grid().expect("valid");
        let [nx, ny, _] = geometry.dimensions;
        let voxel = geometry.spacing.element_product();
        volume.iter().enumerate().fold((0.0, DVec3::ZERO), |(mass, moment), (n, value)| {
            let index = DVec3::new((n % nx) as f64, (n / nx % ny) as f64, (n / nx / ny) as f64);
            let at = grid.index_to_world().transform_point3(index);
            (mass + voxel * value, moment + voxel * value * at)
        })
    }

    #[test]
    fn mass_stays_and_means_lie_in_the_middle_of_their_voxels() {
        let means = BlockMeans::new(odd(), [2, 3, 4], [1, 1]).expect("valid");
        assert_eq!(means.geometry().dimensions, [3, 2, 2]);
        // One value for each block: then its mean's place is the middle of its voxels, those beyond the end are 0.
        let full = |n: usize| n % 5 < 4 && n / 5 % 4 < 3 && n / 20 < 4;
        let volume: Vec<f64> = (0..140).map(|n| if full(n) { (1 + n % 5 / 2) as f64 } else { 0.0 }).collect();
        let (mass, place) = moment(&odd(), &volume);
        let coarse = means.volume(&volume).expect("means");
        let (coarse_mass, coarse_place) = moment(means.geometry(), &coarse);
        assert!((mass - coarse_mass).abs() < 1e-12 * mass, "{mass} {coarse_mass}");
        assert!((place - coarse_place).length() < 1e-12 * place.length(), "{place} {coarse_place}");
    }

    #[test]
    fn pixels_that_fill_no_block_are_left_out_and_the_others_stay_in_place() {
        let means = BlockMeans::new(odd(), [1, 1, 1], [2, 3]).expect("valid");
        let coarse = means.geometry();
        assert_eq!((coarse.detector, coarse.pixel), ([2, 2], [1.0, 0.75]));
        for (u, v) in [(0, 0), (1, 1)] {
            let at = odd().pixel_position(2.0 * f64::from(u) + 0.5, 3.0 * f64::from(v) + 1.0);
            assert!((coarse.pixel_position(f64::from(u), f64::from(v)) - at).length() < 1e-14);
        }
        let image: Vec<f64> = (0..35).map(f64::from).collect();
        // Pixels (2, 0) … (3, 2) are 2, 3, 7, 8, 12, 13.
        assert_eq!(means.image(&image).expect("means")[1], 7.5);
        let mask: Vec<bool> = (0..35).map(|n| n != 8 && n != 34).collect();
        assert_eq!(means.mask(&mask).expect("a mask"), [true, false, true, true]);
    }

    #[test]
    fn steps_cover_what_they_covered() {
        let means = BlockMeans::new(odd(), [2, 2, 2], [2, 2]).expect("valid");
        let coarse = means.geometry();
        assert_eq!((coarse.step, coarse.steps), (4.0, 2));
        assert_eq!(coarse.step * coarse.steps as f64, odd().step * odd().steps as f64);
    }

    #[test]
    fn bad_blocks_and_sizes_are_named() {
        let refused =
            |voxels, pixels| BlockMeans::new(odd(), voxels, pixels).expect_err("refused").to_string();
        assert_eq!(refused([0, 1, 1], [1, 1]), "voxels is [0, 1, 1]; valid: at least 1 along each axis");
        assert_eq!(refused([1, 1, 1], [6, 1]), "pixels is [6, 1]; valid: 1 … [5, 7]");
        let means = BlockMeans::new(odd(), [2, 2, 2], [2, 2]).expect("valid");
        let error = means.volume(&[0.0_f32; 3]).expect_err("refused").to_string();
        assert_eq!(error, "volume's length is 3; valid: 140, one per voxel");
        assert!(means.image(&[0.0_f32; 36]).is_err() && means.mask(&[true; 34]).is_err());
    }
}
