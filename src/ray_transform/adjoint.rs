//! Aᵀ b: every ray adds its value to the voxels along it.
//!
//! Rays are taken by driving axis, axis after axis. The slices across the axis are split into slabs, one task each, that
//! goes over all rays of the axis in order and adds only to its own slices. No voxel is written by two tasks, and what
//! it gets comes in the order of the rays however many slabs there are: the sums are the same for any number of threads.

use std::ops::Range;

use rayon::prelude::*;

use crate::allocation::{filled, reserved};
use crate::error::Result;
use crate::ray_transform::RayTransform;
use crate::ray_transform::line::Line;
use crate::ray_transform::slab::Slab;
use crate::real::Real;

/// Rays that are made at a time, for all slabs together.
const BLOCK: usize = 1 << 14;

/// Slabs per thread, so that threads end at about the same time, and fewest slices of one: each slab looks at every ray.
const SLABS_PER_THREAD: usize = 4;
const FEWEST_SLICES: usize = 4;

/// A slab and what its voxels have got.
struct Part<T> {
    slab: Slab,
    voxels: Vec<T>,
}

impl<T: Real> RayTransform<T> {
    /// The back-projection of images, into zeros.
    pub(super) fn back_project(&self, images: &[T], volume: &mut [T]) -> Result<()> {
        let [nx, ny, _] = self.grid.dimensions();
        let mut lines = reserved(BLOCK.min(images.len()), "rays")?;
        for axis in 0..3 {
            if !self.drives.iter().any(|drives| drives[axis]) {
                continue;
            }
            let mut parts = self.parts(axis)?;
            for first in (0..images.len()).step_by(BLOCK) {
                let pixels = first..(first + BLOCK).min(images.len());
                self.lines(axis, pixels, images, &mut lines);
                parts.par_iter_mut().for_each(|part| {
                    for (line, value) in lines.iter().flatten() {
                        line.scatter(self.algorithm, *value, &part.slab, &mut part.voxels);
                    }
                });
            }
            volume.par_chunks_mut(nx).enumerate().for_each(|(n, row)| {
                for part in &parts {
                    part.slab.add_row(&part.voxels, [n % ny, n / ny], row);
                }
            });
        }
        Ok(())
    }

    /// The volume in slabs across an axis, empty.
    fn parts(&self, axis: usize) -> Result<Vec<Part<T>>> {
        let dimensions = self.grid.dimensions();
        let tasks = SLABS_PER_THREAD * self.context.threads();
        let slices = dimensions[axis].div_ceil(tasks).max(FEWEST_SLICES);
        let mut parts = reserved(dimensions[axis].div_ceil(slices), "slabs")?;
        for first in (0..dimensions[axis]).step_by(slices) {
            let slab = Slab::new(dimensions, axis, first..(first + slices).min(dimensions[axis]));
            let voxels = filled(slab.voxels(), T::default(), "a slab of the volume")?;
            parts.push(Part { slab, voxels });
        }
        Ok(parts)
    }

    /// The rays of pixels whose driving axis this is, with their values; nothing for others and for values of 0.
    fn lines(&self, axis: usize, pixels: Range<usize>, images: &[T], lines: &mut Vec<Option<(Line, T)>>) {
        let per_view = self.size[0] * self.size[1];
        let line = |pixel: usize| {
            let value = images[pixel];
            if value == T::default() || !self.drives[pixel / per_view][axis] {
                return None;
            }
            self.line(pixel).filter(|line| line.ray.axis == axis).map(|line| (line, value))
        };
        pixels.into_par_iter().map(line).collect_into_vec(lines);
    }
}
