//! Some neighbouring rays, walking through the volume together, block of slices by block of slices.

use crate::engine::cpu::Path;
use crate::engine::cpu::field::{Field, Readable, WithField};
use crate::engine::cpu::kernel::{BLOCK, Kernel};
use crate::engine::cpu::lanes::Lanes;
use crate::engine::cpu::sum::Sum;
use crate::engine::cpu::window::Window;
use crate::physics::MAX_MATERIALS;
use crate::raycast::{Footprint, Ray, Span};
use crate::volume::{Occupied, Volume};

/// The rays that hit, in order of their bins: all rays of a bin take the same steps.
pub(super) struct Tile<'a> {
    volume: &'a Volume,
    rays: usize,
    /// Each path with the number of its ray.
    paths: Vec<(usize, Path)>,
    /// Slices per cell.
    step: f64,
}

struct March<'a, K, S> {
    kernel: &'a K,
    tile: &'a Tile<'a>,
    opaque: &'a dyn Fn(&[f64; MAX_MATERIALS]) -> bool,
    /// Of each ray.
    sums: Vec<S>,
    /// Of each ray, up to the end of its last block.
    integrals: Vec<[f64; MAX_MATERIALS]>,
}

impl<'a> Tile<'a> {
    /// Clips the rays; cells are of `step` slices. Where they meet nothing of `occupied` they are not walked, which changes no
    /// bit of what does not count there but is 0; `reach` says how far beyond a voxel's faces a ray reads it.
    pub(super) fn new(
        rays: &[Ray],
        volume: &'a Volume,
        step: f64,
        occupied: Option<&Occupied>,
        reach: impl Fn(usize, Span) -> f64,
    ) -> Self {
        let dimensions = volume.grid().dimensions();
        let path = |(k, ray): (usize, &Ray)| {
            let span = ray.clip(dimensions)?;
            let met = occupied.map_or(Some(span), |occupied| occupied.tighten(ray, span, reach(k, span)))?;
            Some((k, Path::new(ray, span, dimensions, step).within(met, step)))
        };
        let mut paths: Vec<_> = rays.iter().enumerate().filter_map(path).collect();
        paths.sort_by_key(|(k, path)| (path.bin, *k));
        Self { volume, rays: rays.len(), paths, step }
    }

    /// The same rays of pixels with these footprints.
    pub(super) fn of_pixels(mut self, footprints: &[Footprint], rays: &[Ray]) -> Self {
        for (k, path) in &mut self.paths {
            *path = path.of_pixel(&footprints[*k], &rays[*k]);
        }
        self
    }

    /// ∫ dl of each ray in cm times the field's unit, lane by lane, summed by `S`. A ray stops once `opaque` says so.
    pub(super) fn integrate<S: Sum<L>, L: Lanes>(
        &self,
        kernel: &impl Kernel,
        voxels: &impl Readable<L>,
        opaque: &dyn Fn(&[f64; MAX_MATERIALS]) -> bool,
    ) -> Vec<[f64; MAX_MATERIALS]> {
        let sums = vec![S::ZERO; self.rays];
        let integrals = vec![[0.0; MAX_MATERIALS]; self.rays];
        let mut march = March { kernel, tile: self, opaque, sums, integrals };
        voxels.read(self.volume, &mut march);
        march.integrals
    }
}

impl<K: Kernel, L: Lanes, S: Sum<L>> WithField<L> for March<'_, K, S> {
    fn run<F: Field<L>>(&mut self, field: &F) {
        let dimensions = self.tile.volume.grid().dimensions();
        for paths in self.tile.paths.chunk_by(|(_, a), (_, b)| a.axis() == b.axis()) {
            let blocks = paths.iter().map(|(_, path)| K::blocks(path));
            let (first, last) = blocks.fold((u32::MAX, 0), |(a, b), r| (a.min(*r.start()), b.max(*r.end())));
            for block in first..=last {
                let cells = [block * BLOCK, (block + 1) * BLOCK];
                if let Some(window) = Window::around(paths, cells, self.tile.step, dimensions) {
                    window.touch(field, dimensions, paths.len() * BLOCK as usize);
                }
                for (k, path) in paths {
                    let integral = &mut self.integrals[*k];
                    if !K::blocks(path).contains(&block) || (self.opaque)(integral) {
                        continue;
                    }
                    let sum = self.kernel.block::<L, F, S>(field, path, block, self.sums[*k]);
                    self.sums[*k] = sum.carried(path.cm_per_cell, integral);
                }
            }
        }
    }
}
