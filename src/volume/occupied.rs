//! Which bricks of a volume hold what counts, on all levels.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::Result;
use crate::volume::occupancy::{BRICK, bricks};

/// The bricks that hold matter that counts, and bricks of 2 × 2 × 2 of them, and so on: each twice as long as those of the
/// level below. One byte each: 1/7 of the finest for all coarser ones.
#[derive(Debug)]
pub struct Occupied {
    dimensions: [usize; 3],
    /// The finest first.
    levels: Vec<Level>,
}

/// Bricks of one size.
#[derive(Debug)]
pub(crate) struct Level {
    /// Along each axis.
    pub count: [usize; 3],
    /// Voxels along each side.
    pub size: usize,
    /// By brick, x fastest.
    occupied: Vec<bool>,
}

impl Level {
    fn filled(count: [usize; 3], size: usize, holds: impl Fn([usize; 3]) -> bool + Sync) -> Result<Self> {
        let mut occupied = filled(count.iter().product(), false, "the bricks that are occupied")?;
        occupied.par_chunks_mut(count[0]).enumerate().for_each(|(line, bricks)| {
            for (i, occupied) in bricks.iter_mut().enumerate() {
                *occupied = holds([i, line % count[1], line / count[1]]);
            }
        });
        Ok(Self { count, size, occupied })
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.count[1] + j) * self.count[0] + i
    }

    /// Whether a brick holds anything that counts.
    pub(crate) fn holds(&self, brick: [usize; 3]) -> bool {
        self.occupied[self.index(brick)]
    }

    /// Bricks twice as long.
    fn coarser(&self) -> Result<Self> {
        let pair = |at: usize, n: usize| 2 * at..(2 * at + 2).min(n);
        Self::filled(self.count.map(|n| n.div_ceil(2)), 2 * self.size, |[i, j, k]| {
            pair(k, self.count[2]).any(|k| {
                pair(j, self.count[1]).any(|j| pair(i, self.count[0]).any(|i| self.holds([i, j, k])))
            })
        })
    }
}

impl Occupied {
    /// `counts` says by brick, x fastest, whether it holds anything.
    pub(crate) fn new(dimensions: [usize; 3], counts: impl Fn(usize) -> bool + Sync) -> Result<Self> {
        let count = bricks(dimensions);
        let flat = |[i, j, k]: [usize; 3]| (k * count[1] + j) * count[0] + i;
        let mut levels = vec![Level::filled(count, BRICK, |brick| counts(flat(brick)))?];
        while let Some(finest) = levels.last().filter(|level| level.count.iter().any(|&n| n > 2)) {
            levels.push(finest.coarser()?);
        }
        Ok(Self { dimensions, levels })
    }

    /// Voxels along each axis.
    pub fn dimensions(&self) -> [usize; 3] {
        self.dimensions
    }

    /// Bricks of every size, the finest first.
    pub(crate) fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Whether brick (i, j, k) holds anything that counts.
    pub fn holds(&self, brick: [usize; 3]) -> bool {
        self.levels[0].holds(brick)
    }

    /// Whether all bricks do: then no ray can be shortened.
    pub fn is_full(&self) -> bool {
        self.levels[0].occupied.iter().all(|&occupied| occupied)
    }

    /// By brick, x fastest, what `shaders/vacuum.h` reads: 0 where neither it nor a brick beside it, also diagonally, holds
    /// anything that counts. Interpolation at a point of the brick reads nothing else.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn dilated(&self) -> Result<Vec<u8>> {
        let Level { count: [b0, b1, b2], occupied, .. } = &self.levels[0];
        let mut dilated = filled(occupied.len(), 0, "the volume's occupancy")?;
        dilated.par_iter_mut().zip(occupied).for_each(|(to, &from)| *to = u8::from(from));
        // Along one axis after the other: beside it along all of them.
        for (stride, count) in [(1, *b0), (*b0, *b1), (b0 * b1, *b2)] {
            let before = dilated.clone();
            dilated.par_iter_mut().enumerate().for_each(|(brick, value)| {
                let at = brick / stride % count;
                *value |= if at > 0 { before[brick - stride] } else { 0 };
                *value |= if at + 1 < count { before[brick + stride] } else { 0 };
            });
        }
        Ok(dilated)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&level.occupied[..])).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_one(dimensions: [usize; 3], voxel: [usize; 3]) -> Occupied {
        let [b0, b1, _] = bricks(dimensions);
        let [i, j, k] = voxel.map(|at| at / BRICK);
        Occupied::new(dimensions, |at| at == (k * b1 + j) * b0 + i).expect("little memory")
    }

    #[test]
    fn a_brick_is_dilated_when_one_beside_it_is_occupied() {
        let dimensions = [33, 20, 17];
        let [b0, b1, b2] = bricks(dimensions);
        assert_eq!([b0, b1, b2], [5, 3, 3]);
        for voxel in [[0, 0, 0], [32, 19, 16], [16, 8, 7], [15, 8, 8]] {
            let dilated = of_one(dimensions, voxel).dilated().expect("little memory");
            for (n, &value) in dilated.iter().enumerate() {
                let brick = [n % b0, n / b0 % b1, n / (b0 * b1)];
                let beside = (0..3).all(|axis| brick[axis].abs_diff(voxel[axis] / BRICK) <= 1);
                assert_eq!(value != 0, beside, "voxel {voxel:?}, brick {brick:?}");
            }
        }
    }

    #[test]
    fn coarse_bricks_hold_what_fine_ones_do() {
        let dimensions = [130, 41, 9];
        let voxel = [97, 40, 8];
        let occupied = of_one(dimensions, voxel);
        assert_eq!(occupied.levels.last().map(|level| level.count), Some([2, 1, 1]));
        for level in &occupied.levels {
            let [c0, c1, c2] = level.count;
            for brick in (0..c0 * c1 * c2).map(|n| [n % c0, n / c0 % c1, n / (c0 * c1)]) {
                assert_eq!(level.holds(brick), brick == voxel.map(|at| at / level.size), "{brick:?}");
            }
        }
    }

    #[test]
    fn a_volume_is_full_when_every_brick_holds_something() {
        let two = Occupied::new([33, 20, 17], |at| at == 1 || at == 5).expect("little memory");
        assert!(!two.is_full() && Occupied::new([9, 9, 9], |_| true).expect("little memory").is_full());
    }
}
