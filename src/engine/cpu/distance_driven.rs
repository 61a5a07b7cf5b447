//! The mean of the voxels that a pixel covers, slice by slice.

use crate::engine::cpu::field::Field;
use crate::engine::cpu::kernel::{Kernel, WIDTH, bilinear};
use crate::engine::cpu::lanes::Lanes;
use crate::engine::cpu::path::{Limits, Path, Position, limit, nearest};
use crate::engine::cpu::sum::Sum;

/// The distance-driven mean of a slice, as [`for_each_weight`](crate::raycast::distance_driven::for_each_weight) defines it.
/// A pixel no wider than a voxel covers two along each axis: a bilinear sample with other fractions.
pub(super) struct DistanceDriven;

/// The voxels that a footprint covers along one axis, as numbers from the reference voxel.
struct Cover {
    middle: Position,
    /// Over the footprint's width.
    per_width: f32,
    first: f32,
    last: f32,
}

impl Cover {
    #[inline(always)]
    fn new(middle: Position, half: f32, limits: Limits) -> Self {
        let voxel = |x: f32| nearest(limit(x, limits.low, limits.high)).1;
        let x = middle.value();
        Self { middle, per_width: 0.5 / half, first: voxel(x - half), last: voxel(x + half) }
    }

    /// The part of the footprint below a voxel's upper face; what is beyond the border is over the outermost voxel.
    #[inline(always)]
    fn below(&self, voxel: f32) -> f32 {
        if voxel == self.last { 1.0 } else { below(self.middle, voxel, self.per_width) }
    }

    /// Sum of `value` over the voxels, each times the part that is over it.
    #[inline(always)]
    fn sum<L: Lanes>(&self, value: impl Fn(f32) -> L) -> L {
        let (mut sum, mut before, mut voxel) = (L::ZERO, 0.0, self.first);
        loop {
            let below = self.below(voxel);
            sum = sum + value(voxel) * (below - before);
            if voxel >= self.last {
                return sum;
            }
            before = below;
            voxel += 1.0;
        }
    }
}

/// The part of a footprint around `middle` below the upper face of a voxel.
#[inline(always)]
fn below(middle: Position, voxel: f32, per_width: f32) -> f32 {
    limit(0.5 - middle.from(voxel + 0.5) * per_width, 0.0, 1.0)
}

/// The lower of the two voxels that a footprint no wider than one can cover, and the part that is over the upper one.
/// Without `LIMIT`, `middle` must be well inside the limits.
#[inline(always)]
fn pair<const LIMIT: bool>(middle: Position, half: f32, limits: Limits) -> (u32, f32) {
    let (index, lower) = nearest(middle.value() - 0.5);
    if LIMIT {
        let lower = limit(lower, limits.low, limits.last_cell);
        (nearest(lower).0, 1.0 - below(middle, lower, 0.5 / half))
    } else {
        (index, 1.0 - below(middle, lower, 0.5 / half))
    }
}

impl DistanceDriven {
    /// Corner and fractions `t` slices from the middle one, of a footprint no wider than a voxel.
    #[inline(always)]
    fn position<const LIMIT: bool>(path: &Path, t: i32) -> (u32, f32, f32) {
        let [u, v] = path.at(t as f32);
        let (iu, fu) = pair::<LIMIT>(u, path.widths.at(0, t as f32), path.across[0]);
        let (iv, fv) = pair::<LIMIT>(v, path.widths.at(1, t as f32), path.across[1]);
        (path.index(t.cast_unsigned(), [iu, iv]), fu, fv)
    }

    /// The mean `t` slices from the middle one, of a footprint of any width.
    #[inline(never)]
    fn wide<L: Lanes, F: Field<L>>(field: &F, path: &Path, t: i32) -> L {
        let [u, v] = path.at(t as f32);
        let [u, v] = [(0, u), (1, v)]
            .map(|(axis, middle)| Cover::new(middle, path.widths.at(axis, t as f32), path.across[axis]));
        v.sum(|n| u.sum(|m| field.at(path.index(t.cast_unsigned(), [nearest(m).0, nearest(n).0]))))
    }
}

impl Kernel for DistanceDriven {
    #[inline(always)]
    fn part<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32, _: f32, length: f32) -> L {
        self.whole::<true, L, F>(field, path, cell) * length
    }

    #[inline(always)]
    fn whole<const LIMIT: bool, L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32) -> L {
        let t = path.cells_to(cell);
        if !path.widths.narrow {
            return Self::wide(field, path, t);
        }
        let (corner, fu, fv) = Self::position::<LIMIT>(path, t);
        bilinear(field, path, corner, fu, fv)
    }

    /// All positions first: the compiler makes vectors of them.
    #[inline(always)]
    fn run<L: Lanes, F: Field<L>, S: Sum<L>>(&self, field: &F, path: &Path, first: u32, sum: S) -> S {
        let t = path.cells_to(first);
        if !path.widths.narrow {
            return sum.plus_all((0..WIDTH as i32).map(|i| Self::wide(field, path, t + i)));
        }
        let (mut corner, mut fu, mut fv) = ([0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
        for i in 0..WIDTH {
            (corner[i], fu[i], fv[i]) = Self::position::<false>(path, t + i as i32);
        }
        sum.plus_all((0..WIDTH).map(|i| bilinear(field, path, corner[i], fu[i], fv[i])))
    }
}
