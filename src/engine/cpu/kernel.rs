//! The three algorithms, cell by cell of the driving axis.

use crate::engine::cpu::field::Field;
use crate::engine::cpu::lanes::{Lanes, lerp};
use crate::engine::cpu::path::{Path, cell, limit, nearest};

/// Cells that are summed in float32 before the sum goes to float64: error stops growing with the ray's length.
const BLOCK: u32 = 64;

/// An algorithm. Cell k of the driving axis is [−½ + k·step, −½ + (k+1)·step].
pub(super) trait Kernel: Sync {
    /// The integral over the part `from … to` (0 … 1) of a cell, in units of the cell.
    fn part<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32, from: f32, to: f32) -> L;

    /// The integral over a whole cell.
    fn whole<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32) -> L;

    /// Number of blocks that hold the path's cells, and the first of them.
    fn blocks(path: &Path) -> std::ops::RangeInclusive<u32> {
        path.cells[0] / BLOCK..=path.cells[1] / BLOCK
    }

    /// The integral over the cells of one block.
    #[inline(always)]
    fn block<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, block: u32) -> L {
        let [first, last] = path.cells;
        let [from, to] = path.ends;
        let mut begin = first.max(block * BLOCK);
        let mut end = (last + 1).min((block + 1) * BLOCK);
        let mut sum = L::ZERO;
        if begin >= end {
            return sum;
        }
        if begin == first {
            sum = self.part(field, path, first, from, if first == last { to } else { 1.0 });
            begin += 1;
        }
        let leaves_here = end == last + 1 && last > first;
        if leaves_here {
            end = last;
        }
        for cell in begin..end {
            sum = sum + self.whole::<L, F>(field, path, cell);
        }
        if leaves_here {
            sum = sum + self.part(field, path, last, 0.0, to);
        }
        sum
    }
}

/// One bilinear sample per slice.
pub(super) struct Joseph;

impl Kernel for Joseph {
    #[inline(always)]
    fn part<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32, from: f32, to: f32) -> L {
        self.whole::<L, F>(field, path, cell) * (to - from)
    }

    #[inline(always)]
    fn whole<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, slice: u32) -> L {
        let [u, v] = path.at(slice as f32);
        let (iu, fu) = cell(u, path.low[0], path.high[0], path.last_cell[0]);
        let (iv, fv) = cell(v, path.low[1], path.high[1], path.last_cell[1]);
        let corner =
            path.origin + slice as isize * path.slice_stride + iu * path.stride[0] + iv * path.stride[1];
        bilinear(field, path, corner, fu, fv)
    }
}

/// The field in one slice, between four voxels.
#[inline(always)]
fn bilinear<L: Lanes, F: Field<L>>(field: &F, path: &Path, corner: isize, fu: f32, fv: f32) -> L {
    let [du, dv] = path.stride;
    let at = |index: isize| field.at(index.cast_unsigned());
    let lower = lerp(at(corner), at(corner + du), fu);
    let upper = lerp(at(corner + dv), at(corner + dv + du), fu);
    lerp(lower, upper, fv)
}

/// One trilinear sample per cell of `step` slices.
pub(super) struct March {
    /// Cell length in slices.
    pub step: f32,
}

impl March {
    #[inline(always)]
    fn sample<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, position: f32) -> L {
        let s = position * self.step - 0.5;
        let [u, v] = path.at(s);
        let (is, fs) = cell(s, 0.0, path.last_slice[0], path.last_slice[1]);
        let (iu, fu) = cell(u, path.low[0], path.high[0], path.last_cell[0]);
        let (iv, fv) = cell(v, path.low[1], path.high[1], path.last_cell[1]);
        let corner = path.origin + is * path.slice_stride + iu * path.stride[0] + iv * path.stride[1];
        let lower = bilinear(field, path, corner, fu, fv);
        let upper = bilinear(field, path, corner + path.slice_stride, fu, fv);
        lerp(lower, upper, fs)
    }
}

impl Kernel for March {
    #[inline(always)]
    fn part<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32, from: f32, to: f32) -> L {
        self.sample::<L, F>(field, path, cell as f32 + 0.5 * (from + to)) * (to - from)
    }

    #[inline(always)]
    fn whole<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32) -> L {
        self.sample(field, path, cell as f32 + 0.5)
    }
}

/// Exact lengths through voxels. Within one slice of the driving axis a ray crosses at most one plane of each other
/// axis, so it meets at most three voxels: every ray takes the same steps, without a branch on its direction.
pub(super) struct Siddon;

impl Siddon {
    /// The voxel that holds x, and the place 0 … `length` where the ray crosses into the voxel that holds `x_end`.
    #[inline(always)]
    fn crossing(path: &Path, t: usize, x: f32, x_end: f32, length: f32) -> (isize, isize, f32) {
        let voxel = |x: f32| {
            let (index, centre) = nearest(limit(x, path.low[t], path.high[t]));
            // Voxels are half-open, [i−½, i+½); the tie may have gone to the lower one.
            index + isize::from(x - centre >= 0.5 && centre < path.high[t])
        };
        let begin = voxel(x);
        // Rounding at the two faces must not skip a voxel.
        let end = voxel(x_end).clamp(begin - 1, begin + 1);
        let plane = begin.max(end) as f32 - 0.5;
        let at = limit((plane - x) * path.inverse_slope[t], 0.0, length);
        (begin, end, if begin == end { length } else { at })
    }
}

impl Kernel for Siddon {
    #[inline(always)]
    fn part<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, slice: u32, from: f32, to: f32) -> L {
        let face = slice as f32 - 0.5;
        let ([u, v], [u_end, v_end]) = (path.at(face + from), path.at(face + to));
        let length = to - from;
        let (iu, ju, cross_u) = Self::crossing(path, 0, u, u_end, length);
        let (iv, jv, cross_v) = Self::crossing(path, 1, v, v_end, length);
        let origin = path.origin + slice as isize * path.slice_stride;
        let voxel =
            |u: isize, v: isize| field.at((origin + u * path.stride[0] + v * path.stride[1]).cast_unsigned());
        let (first, second) = (cross_u.min(cross_v), cross_u.max(cross_v));
        let middle = if cross_u < cross_v { voxel(ju, iv) } else { voxel(iu, jv) };
        voxel(iu, iv) * first + middle * (second - first) + voxel(ju, jv) * (length - second)
    }

    #[inline(always)]
    fn whole<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, slice: u32) -> L {
        self.part(field, path, slice, 0.0, 1.0)
    }
}
