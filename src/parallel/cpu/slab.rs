//! Layers of voxels that one thread adds to.

use std::ops::Range;

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::Result;
use crate::parallel::cpu::field::{Limits, SLACK};
use crate::real::Real;

/// Layers of x: what the rays reach there stays in the cache.
pub(super) const SLAB: usize = 8;

/// Slices of z that are copied together: a few lines of the cache of the slabs' voxels.
const SLICES: usize = 32;

/// Columns of x that are copied together: a whole line of the cache of the volume's voxels.
const COLUMNS: usize = 16;

/// How far outside a slab's cells samples are still visited, lest rounding miss one.
const MARGIN: f64 = 0.0625;

/// A few layers of x of a field that what lies in them is added to. Whoever adds visits all rays, in the same order
/// for every slab: sums are the same for any number of threads.
pub(super) struct Slab<T> {
    /// Of the field, with the border.
    pub sides: [usize; 3],
    /// Which layers of the field, whose first is the border.
    pub layers: Range<usize>,
    /// Their values, z fastest, between two slacks.
    pub values: Vec<T>,
}

impl<T: Real> Slab<T> {
    /// Number of slabs that a field has.
    pub(super) fn count(sides: [usize; 3]) -> usize {
        (sides[0] - 2).div_ceil(SLAB)
    }

    /// Memory for any slab of a field.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(super) fn new(sides: [usize; 3]) -> Result<Self> {
        let count = SLAB.min(sides[0] - 2) * sides[1] * sides[2] + 2 * SLACK;
        Ok(Self { sides, layers: 0..0, values: filled(count, T::default(), "layers of the volume")? })
    }

    /// Becomes the field's slab `n`, all 0.
    pub(super) fn restart(&mut self, n: usize) {
        let first = 1 + n * SLAB;
        self.layers = first..(first + SLAB).min(self.sides[0] - 1);
        self.values.fill(T::default());
    }

    /// Where samples that add to these layers are.
    pub(super) fn limits(&self) -> Limits {
        let mut limits = Limits::of(self.sides);
        let [low, high] = limits.0[0];
        let cells = [self.layers.start as f64 - 2.0 - MARGIN, self.layers.end as f64 - 1.0 + MARGIN];
        limits.0[0] = [low.max(cells[0]), high.min(cells[1])];
        limits
    }

    /// Adds `value` at an index-space point: to the corners of its cell, by their shares in the field there.
    pub(super) fn add(&mut self, point: [f64; 3], value: T) {
        let mut cell = [0; 3];
        let mut upper = [T::default(); 3];
        for axis in 0..3 {
            let floor = point[axis].floor();
            if !(floor >= -1.0 && floor <= (self.sides[axis] - 3) as f64) {
                return;
            }
            cell[axis] = (floor + 1.0) as usize;
            upper[axis] = T::of(point[axis] - floor);
        }
        let [x, y, z] = cell;
        let [fx, fy, fz] = upper;
        let above = fx * value;
        for (x, value) in [(x, value - above), (x + 1, above)] {
            if !self.layers.contains(&x) {
                continue;
            }
            let first = self.line(x, y) + z;
            let above = fy * value;
            for (at, value) in [(first, value - above), (first + self.sides[2], above)] {
                let above = fz * value;
                self.values[at] += value - above;
                self.values[at + 1] += above;
            }
        }
    }

    /// Where the line of the field's layer `x`, which is one of these, begins.
    #[inline(always)]
    pub(super) fn line(&self, x: usize, y: usize) -> usize {
        SLACK + ((x - self.layers.start) * self.sides[1] + y) * self.sides[2]
    }
}

/// Copies slabs that follow one another into a volume without border, x fastest.
pub(super) fn copy<T: Real>(slabs: &[Slab<T>], voxels: &mut [T]) {
    let [nx, ny, nz] = slabs[0].sides.map(|side| side - 2);
    let columns = slabs[0].layers.start - 1..slabs[slabs.len() - 1].layers.end - 1;
    voxels.par_chunks_mut(SLICES * ny * nx).enumerate().for_each(|(n, slices)| {
        let first = n * SLICES;
        let count = SLICES.min(nz - first);
        let mut lines = [[T::default(); SLICES]; COLUMNS];
        for j in 0..ny {
            for i in columns.clone().step_by(COLUMNS) {
                let width = COLUMNS.min(columns.end - i);
                // Copied as they are, lines wait for memory together; turned at once, one after the other.
                for (m, line) in lines.iter_mut().enumerate().take(width) {
                    let slab = &slabs[(i + m - columns.start) / SLAB];
                    let from = slab.line(i + m + 1, j + 1) + 1 + first;
                    line[..count].copy_from_slice(&slab.values[from..][..count]);
                }
                // Slices may be powers of two apart, where caches hold few lines: each is written once.
                for (k, slice) in slices.chunks_exact_mut(ny * nx).enumerate() {
                    let row = std::array::from_fn::<_, COLUMNS, _>(|m| lines[m][k]);
                    slice[j * nx + i..][..width].copy_from_slice(&row[..width]);
                }
            }
        }
    });
}
