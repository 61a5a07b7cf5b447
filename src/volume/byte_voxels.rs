//! The voxels of a volume once more, in one byte each: fewer bytes to read, and a table of their meaning that stays in
//! first-level cache.

use rayon::prelude::*;

use crate::allocation::{filled, reserved};
use crate::error::Result;
use crate::volume::Voxel;
use crate::volume::levels::Levels;

/// Levels of density; see [`Levels`].
#[derive(Debug)]
pub(crate) struct ByteVoxels {
    /// One per voxel, x fastest.
    pub levels: Vec<u8>,
    /// The meaning of each; at most 256.
    pub table: Vec<Voxel>,
}

/// Voxels per parallel piece of work.
const PIECE: usize = 1 << 16;

impl ByteVoxels {
    /// Of the 16-bit codes with this meaning.
    pub(super) fn new(codes: &[u16], table: &[Voxel]) -> Result<Self> {
        let Levels { voxels, of_code } = Levels::choose(&counts(codes)?, table)?;
        let mut levels = reserved(codes.len(), "8-bit voxels")?;
        levels.par_extend(codes.par_iter().with_min_len(PIECE).map(|&code| of_code[usize::from(code)]));
        Ok(Self { levels, table: voxels })
    }
}

/// How many voxels have each code.
fn counts(codes: &[u16]) -> Result<Vec<u64>> {
    let none = || filled(1 << 16, 0, "the histogram of the volume");
    let count = |piece: &[u16]| {
        let mut counts = none()?;
        for &code in piece {
            counts[usize::from(code)] += 1;
        }
        Ok(counts)
    };
    let add = |mut a: Vec<u64>, b: Vec<u64>| {
        for (sum, count) in a.iter_mut().zip(b) {
            *sum += count;
        }
        Ok(a)
    };
    let piece = codes.len().div_ceil(rayon::current_num_threads()).max(PIECE);
    codes.par_chunks(piece).map(count).try_reduce_with(add).unwrap_or_else(none)
}
