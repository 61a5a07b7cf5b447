//! Where a volume holds anything: what `shaders/vacuum.h` reads.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::Result;

/// Voxels along each side of a brick, `DRR_BRICK`.
const BRICK: usize = 8;

/// Bricks along each axis of a volume.
pub(super) fn bricks(dimensions: [usize; 3]) -> [usize; 3] {
    dimensions.map(|n| n.div_ceil(BRICK))
}

/// One byte per brick, x fastest: 0 where neither it nor a brick beside it, also diagonally, holds anything but vacuum.
/// `holds` says whether the voxel at a flat index does.
pub(super) fn occupancy(dimensions: [usize; 3], holds: impl Fn(usize) -> bool + Sync) -> Result<Vec<u8>> {
    let [n0, n1, n2] = dimensions;
    let [b0, b1, b2] = bricks(dimensions);
    let mut occupied = filled(b0 * b1 * b2, 0, "the volume's occupancy")?;
    occupied.par_chunks_mut(b0).enumerate().for_each(|(line, bricks)| {
        let [j, k] = [line % b1, line / b1].map(|brick| brick * BRICK);
        for row in
            (k..(k + BRICK).min(n2)).flat_map(|k| (j..(j + BRICK).min(n1)).map(move |j| (k * n1 + j) * n0))
        {
            for (i, brick) in bricks.iter_mut().enumerate() {
                let voxels = row + i * BRICK..row + ((i + 1) * BRICK).min(n0);
                *brick |= u8::from(*brick == 0 && voxels.into_iter().any(&holds));
            }
        }
    });
    // Along one axis after the other: beside it along all of them.
    for (stride, count) in [(1, b0), (b0, b1), (b0 * b1, b2)] {
        let before = occupied.clone();
        occupied.par_iter_mut().enumerate().for_each(|(brick, value)| {
            let at = brick / stride % count;
            *value |= if at > 0 { before[brick - stride] } else { 0 };
            *value |= if at + 1 < count { before[brick + stride] } else { 0 };
        });
    }
    Ok(occupied)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_brick_is_occupied_when_one_beside_it_is() {
        let dimensions = [33, 20, 17];
        let [b0, b1, b2] = bricks(dimensions);
        assert_eq!([b0, b1, b2], [5, 3, 3]);
        for voxel in [[0, 0, 0], [32, 19, 16], [16, 8, 7], [15, 8, 8]] {
            let index = (voxel[2] * dimensions[1] + voxel[1]) * dimensions[0] + voxel[0];
            let occupied = occupancy(dimensions, |at| at == index).expect("little memory");
            for (n, &value) in occupied.iter().enumerate() {
                let brick = [n % b0, n / b0 % b1, n / (b0 * b1)];
                let beside = (0..3).all(|axis| brick[axis].abs_diff(voxel[axis] / BRICK) <= 1);
                assert_eq!(value != 0, beside, "voxel {voxel:?}, brick {brick:?}");
            }
        }
    }
}
