//! From what the rays of a part of a view have met to its pixels.

use std::ops::Range;

use crate::allocation::filled;
use crate::engine::cpu::level::{AtLevel, LANES, Level, Wide};
use crate::engine::cpu::signal::Signal;
use crate::engine::cpu::sweep::{Met, Part};
use crate::engine::cpu::{Cpu, TILE};
use crate::engine::images::PixelValue;
use crate::engine::{Layers, ViewJob};
use crate::error::Result;
use crate::physics::MAX_MATERIALS;
use crate::raycast::{Beam, Ray};

/// A part of a view, whose rays have been swept.
pub(super) struct Developed<'a> {
    pub cpu: &'a Cpu,
    pub view: &'a ViewJob,
    pub layers: Layers,
    pub part: &'a Part,
    pub met: &'a Met,
}

impl Developed<'_> {
    /// The part's pixels, row-major. `beam` has one pixel per ray.
    pub(super) fn pixels(&self, beam: &Beam) -> Result<Vec<PixelValue>> {
        let signal = &*self.cpu.signal(self.view);
        let mut rays = self.cpu.level.dispatch(Rays { developed: self, signal })?;
        if self.layers.bone_path {
            self.put_bone(beam, &mut rays);
        }
        let n = self.cpu.supersampling;
        if n == 1 {
            return Ok(rays);
        }
        let width = self.columns().len();
        let mut pixels = Vec::with_capacity(rays.len() / (n * n));
        let mut of_pixel = Vec::with_capacity(n * n);
        for rows in rays.chunks(n * width) {
            for first in (0..width).step_by(n) {
                of_pixel.clear();
                rows.chunks(width).for_each(|row| of_pixel.extend_from_slice(&row[first..first + n]));
                pixels.push(PixelValue::mean(&of_pixel));
            }
        }
        Ok(pixels)
    }

    /// Columns of rays.
    fn columns(&self) -> Range<usize> {
        self.part.columns(self.cpu.size[0] * self.cpu.supersampling)
    }

    /// Tile by tile.
    fn put_bone(&self, beam: &Beam, values: &mut [PixelValue]) {
        let (rows, columns) = (self.part.rows.clone(), self.columns());
        for row in rows.clone().step_by(TILE[0]) {
            for column in columns.clone().step_by(TILE[1]) {
                let tile = (row..(row + TILE[0]).min(rows.end))
                    .flat_map(|j| (column..(column + TILE[1]).min(columns.end)).map(move |i| (i, j)));
                let places: Vec<_> = tile.collect();
                let rays: Vec<Ray> = places.iter().map(|&(i, j)| beam.ray(i as f64, j as f64)).collect();
                for ((i, j), bone) in places.into_iter().zip(self.cpu.bone_paths(&rays)) {
                    values[(j - rows.start) * columns.len() + i - columns.start].bone_path = bone;
                }
            }
        }
    }
}

/// The values of single rays.
struct Rays<'a> {
    developed: &'a Developed<'a>,
    signal: &'a Signal,
}

impl AtLevel for Rays<'_> {
    type Output = Result<Vec<PixelValue>>;

    #[inline(always)]
    fn run<S: Level>(self, simd: S) -> Self::Output {
        let Self { developed: Developed { cpu, layers, part, met, .. }, signal } = self;
        let lit = layers.intensity || layers.line_integral;
        let width = self.developed.columns().len();
        let count = part.rows.len() * width;
        let mut values = filled(count, PixelValue::vacuum(signal.i0()), "rows of the detector")?;
        let mut depth = Vec::new();
        let mut areal_densities: Vec<(usize, Wide)> = Vec::with_capacity(MAX_MATERIALS);
        for row in 0..part.rows.len() {
            for block in 0..part.blocks.len() {
                areal_densities.clear();
                for (accumulator, &label) in cpu.labels.iter().enumerate() {
                    let areal = met.areal_density(accumulator, row, block);
                    if areal.iter().any(|&areal| areal != 0.0) {
                        areal_densities.push((usize::from(label), *areal));
                    }
                }
                if areal_densities.is_empty() {
                    continue;
                }
                let first = block * LANES;
                let lanes = LANES.min(width - first);
                let pixels = &mut values[row * width + first..][..lanes];
                for (material, areal) in &areal_densities {
                    for (pixel, &areal) in pixels.iter_mut().zip(areal) {
                        pixel.areal_density[*material] = f64::from(areal);
                    }
                }
                if lit {
                    let signals = signal.of_lanes(simd, &areal_densities, &mut depth);
                    for (pixel, signal) in pixels.iter_mut().zip(signals) {
                        (pixel.intensity, pixel.line_integral) = signal;
                    }
                }
            }
        }
        Ok(values)
    }
}
