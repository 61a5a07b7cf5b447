//! The box of voxels that neighbouring rays cross within some slices, brought into cache ahead of them.

use std::hint::black_box;

use crate::engine::cpu::Path;
use crate::engine::cpu::field::Field;
use crate::engine::cpu::lanes::Lanes;
use crate::raycast::ray::TRANSVERSE;

/// Voxels along x from one touch to the next; one cache line of 16-bit codes.
const LINE: usize = 32;

/// Index ranges, inclusive, along x, y, z.
pub(super) struct Window {
    first: [usize; 3],
    last: [usize; 3],
}

impl Window {
    /// The voxels that `paths`, which share a driving axis, can read in the cells `cells`, first to one past the last.
    pub(super) fn around(
        paths: &[(usize, Path)],
        cells: [u32; 2],
        step: f64,
        dimensions: [usize; 3],
    ) -> Option<Self> {
        let axis = paths.first()?.1.axis();
        let mut low = [f32::INFINITY; 2];
        let mut high = [f32::NEG_INFINITY; 2];
        for (_, path) in paths {
            for cell in cells {
                let relative = path.at(path.cells_to(cell) as f32 - 0.5);
                for t in 0..2 {
                    low[t] = low[t].min(relative[t].value() - path.across[t].low);
                    high[t] = high[t].max(relative[t].value() - path.across[t].low);
                }
            }
        }
        let [u, v] = TRANSVERSE[axis];
        let slices = cells.map(|cell| (f64::from(cell) * step - 0.5) as f32);
        let (mut first, mut last) = ([0; 3], [0; 3]);
        for (axis, from, to) in [(axis, slices[0], slices[1]), (u, low[0], high[0]), (v, low[1], high[1])] {
            let end = dimensions[axis] - 1;
            // `as` saturates: coordinates outside the box become its ends.
            (first[axis], last[axis]) = ((from as usize).min(end), (to as usize + 1).min(end));
        }
        Some(Self { first, last })
    }

    /// Reads one voxel of every cache line, all at once, so that the processor waits for memory once and not at every
    /// line that a ray happens upon. Does nothing when that would be more reads than the rays' `samples`.
    pub(super) fn touch<L: Lanes>(&self, field: &impl Field<L>, dimensions: [usize; 3], samples: usize) {
        let size = |axis: usize| self.last[axis] - self.first[axis] + 1;
        let lines = size(0).div_ceil(LINE) + 1;
        if lines * size(1) * size(2) > samples {
            return;
        }
        let mut sum = 0_u32;
        for k in self.first[2]..=self.last[2] {
            for j in self.first[1]..=self.last[1] {
                let row = (k * dimensions[1] + j) * dimensions[0];
                for i in (self.first[0]..=self.last[0]).step_by(LINE) {
                    sum = sum.wrapping_add(field.touch((row + i) as u32));
                }
                sum = sum.wrapping_add(field.touch((row + self.last[0]) as u32));
            }
        }
        black_box(sum);
    }
}
