//! What the rays of a block have met.

use super::spans::Spans;
use crate::engine::cpu::level::{LANES, Wide};

/// Slices that are summed in float32 before the sum goes to float64.
pub(super) const BLOCK: usize = 64;

/// Sums of partial density over slices, by material and row.
pub(super) struct Sums {
    rows: usize,
    /// Of the block of slices, and of all before it.
    block: Vec<Wide>,
    total: Vec<[f64; LANES]>,
}

impl Sums {
    pub(super) fn new(materials: usize, rows: usize) -> Self {
        let n = materials * rows;
        Self { rows, block: vec![[0.0; LANES]; n], total: vec![[0.0; LANES]; n] }
    }

    /// The rows of a material.
    #[inline(always)]
    pub(super) fn of(&mut self, material: usize) -> &mut [Wide] {
        &mut self.block[material * self.rows..][..self.rows]
    }

    /// A block of slices is complete.
    #[inline(always)]
    pub(super) fn carry(&mut self) {
        for (total, block) in self.total.iter_mut().zip(&mut self.block) {
            for n in 0..LANES {
                total[n] += f64::from(block[n]);
            }
            *block = [0.0; LANES];
        }
    }

    /// g/cm², never below 0: where a place has been rounded across a voxel's centre, vacuum beside bone would be.
    pub(super) fn areal_density(&self, material: usize, row: usize, spans: &Spans) -> Wide {
        let (total, cm) = (&self.total[material * self.rows + row], &spans.cm[row]);
        std::array::from_fn(|n| (total[n] * f64::from(cm[n])).max(0.0) as f32)
    }
}
