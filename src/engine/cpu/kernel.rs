//! The algorithms, cell by cell of the driving axis: what they share, and those of them that sample points or lengths.

use crate::engine::cpu::field::Field;
use crate::engine::cpu::lanes::{Lanes, lerp};
use crate::engine::cpu::path::{Limits, Path, Position, cell, limit, nearest};
use crate::engine::cpu::sum::Sum;

/// Cells that the rays of a tile walk through before they wait for each other. Where sums are blocked, these go to float64:
/// error stops growing with the ray's length.
pub(super) const BLOCK: u32 = 64;

/// Cells whose positions are computed side by side.
pub(super) const WIDTH: usize = 8;

/// An algorithm. Cells are those of [`Path`].
pub(super) trait Kernel: Sync {
    /// The integral over the part of a cell that begins at `from` (0 … 1) and has this length, in units of the cell.
    fn part<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32, from: f32, length: f32) -> L;

    /// The integral over a whole cell; without `LIMIT`, one of the path's inner cells.
    fn whole<const LIMIT: bool, L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32) -> L;

    /// As `part`, where the volume's border may be near. Called, unlike what inner cells need: they are the most, and for
    /// all sums this is the same code.
    #[inline(never)]
    fn end<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32, from: f32, length: f32) -> L {
        self.part(field, path, cell, from, length)
    }

    /// As `whole` with `LIMIT`, called for the same reason.
    #[inline(never)]
    fn outer<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32) -> L {
        self.whole::<true, L, F>(field, path, cell)
    }

    /// Adds the integral over `WIDTH` inner cells.
    #[inline(always)]
    fn run<L: Lanes, F: Field<L>, S: Sum<L>>(&self, field: &F, path: &Path, first: u32, sum: S) -> S {
        let cells = first..first + WIDTH as u32;
        sum.plus_all(cells.map(|cell| self.whole::<false, L, F>(field, path, cell)))
    }

    /// Adds the integral over some of the path's inner cells, as far as they are walked: of the same eights as if all were,
    /// because those may be summed on their own.
    #[inline(always)]
    fn inner<L: Lanes, F: Field<L>, S: Sum<L>>(
        &self,
        field: &F,
        path: &Path,
        cells: std::ops::Range<u32>,
        mut sum: S,
    ) -> S {
        let [from, to] = path.walked;
        let mut first = cells.start + from.saturating_sub(cells.start) / WIDTH as u32 * WIDTH as u32;
        let last_run = cells.end.min(to + WIDTH as u32 - 1);
        while first + WIDTH as u32 <= last_run {
            sum = self.run(field, path, first, sum);
            first += WIDTH as u32;
        }
        (first.max(from)..cells.end.min(to))
            .fold(sum, |sum, cell| sum.plus(self.whole::<false, L, F>(field, path, cell)))
    }

    /// The blocks that hold the path's cells, as far as they are walked.
    fn blocks(path: &Path) -> std::ops::RangeInclusive<u32> {
        path.walked[0] / BLOCK..=(path.walked[1] - 1) / BLOCK
    }

    /// Adds the integral over the cells of one block, as far as they are walked.
    #[inline(always)]
    fn block<L: Lanes, F: Field<L>, S: Sum<L>>(&self, field: &F, path: &Path, block: u32, mut sum: S) -> S {
        let [first, last] = path.cells;
        let mut begin = first.max(block * BLOCK);
        let mut end = (last + 1).min((block + 1) * BLOCK);
        if begin >= end {
            return sum;
        }
        let [from, to] = path.walked;
        if begin == first {
            if from == first {
                sum = sum.plus(self.end(field, path, first, path.enter, path.lengths[0]));
            }
            begin += 1;
        }
        let leaves_here = end == last + 1 && last > first;
        if leaves_here {
            end = last;
        }
        let inner = path.inner.map(|cell| cell.clamp(begin, end.max(begin)));
        for cell in begin.max(from)..inner[0].min(to) {
            sum = sum.plus(self.outer(field, path, cell));
        }
        sum = self.inner(field, path, inner[0]..inner[1], sum);
        for cell in inner[1].max(from)..end.min(to) {
            sum = sum.plus(self.outer(field, path, cell));
        }
        if leaves_here && to > last {
            sum = sum.plus(self.end(field, path, last, 0.0, path.lengths[1]));
        }
        sum
    }
}

/// One bilinear sample per slice.
pub(super) struct Joseph;

impl Joseph {
    /// Corner and fractions of the sample `t` slices from the middle one.
    #[inline(always)]
    fn position<const LIMIT: bool>(path: &Path, t: i32) -> (u32, f32, f32) {
        let [u, v] = path.at(t as f32);
        let (iu, fu) = cell::<LIMIT>(u, path.across[0]);
        let (iv, fv) = cell::<LIMIT>(v, path.across[1]);
        (path.index(t.cast_unsigned(), [iu, iv]), fu, fv)
    }
}

impl Kernel for Joseph {
    #[inline(always)]
    fn part<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32, _: f32, length: f32) -> L {
        self.whole::<true, L, F>(field, path, cell) * length
    }

    #[inline(always)]
    fn whole<const LIMIT: bool, L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32) -> L {
        let (corner, fu, fv) = Self::position::<LIMIT>(path, path.cells_to(cell));
        bilinear(field, path, corner, fu, fv)
    }

    /// All positions first: the compiler makes vectors of them.
    #[inline(always)]
    fn run<L: Lanes, F: Field<L>, S: Sum<L>>(&self, field: &F, path: &Path, first: u32, sum: S) -> S {
        let (mut corner, mut fu, mut fv) = ([0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
        let t = path.cells_to(first);
        for i in 0..WIDTH {
            (corner[i], fu[i], fv[i]) = Self::position::<false>(path, t + i as i32);
        }
        sum.plus_all((0..WIDTH).map(|i| bilinear(field, path, corner[i], fu[i], fv[i])))
    }
}

/// The field in one slice, between four voxels.
#[inline(always)]
pub(super) fn bilinear<L: Lanes, F: Field<L>>(field: &F, path: &Path, corner: u32, fu: f32, fv: f32) -> L {
    let [du, dv] = path.stride;
    let across = corner.wrapping_add(dv);
    let lower = lerp(field.at(corner), field.at(corner.wrapping_add(du)), fu);
    let upper = lerp(field.at(across), field.at(across.wrapping_add(du)), fu);
    lerp(lower, upper, fv)
}

/// One trilinear sample per cell.
pub(super) struct March;

impl March {
    /// The field `t` cells from the middle of the middle cell.
    #[inline(always)]
    fn sample<const LIMIT: bool, L: Lanes, F: Field<L>>(field: &F, path: &Path, t: f32) -> L {
        let [u, v] = path.at(t);
        let (is, fs) = cell::<LIMIT>(path.slice_at(t), path.slices);
        let (iu, fu) = cell::<LIMIT>(u, path.across[0]);
        let (iv, fv) = cell::<LIMIT>(v, path.across[1]);
        let corner = path.index(is, [iu, iv]);
        let lower = bilinear(field, path, corner, fu, fv);
        let upper = bilinear(field, path, corner.wrapping_add(path.slice_stride), fu, fv);
        lerp(lower, upper, fs)
    }
}

impl Kernel for March {
    #[inline(always)]
    fn part<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32, from: f32, length: f32) -> L {
        let middle_of_part = from + 0.5 * length - 0.5;
        Self::sample::<true, L, F>(field, path, path.cells_to(cell) as f32 + middle_of_part) * length
    }

    #[inline(always)]
    fn whole<const LIMIT: bool, L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32) -> L {
        Self::sample::<LIMIT, L, F>(field, path, path.cells_to(cell) as f32)
    }
}

/// Exact lengths through voxels. Within one slice of the driving axis a ray crosses at most one plane of each other
/// axis, so it meets at most three voxels: every ray takes the same steps, without a branch on its direction.
pub(super) struct Siddon;

impl Siddon {
    /// Along one transverse axis: the voxels that hold x and `x_end`, and the place 0 … `length` where the ray crosses
    /// from the one into the other.
    #[inline(always)]
    fn crossing<const LIMIT: bool>(
        path: &Path,
        t: usize,
        x: Position,
        x_end: Position,
        length: f32,
    ) -> [f32; 3] {
        let voxel = |x: Position| {
            let Limits { low, high, .. } = path.across[t];
            let rounded = x.value();
            let centre = nearest(if LIMIT { limit(rounded, low, high) } else { rounded }).1;
            // Voxels are half-open, [i−½, i+½); next to a face rounding may have led to the neighbour.
            let off = x.from(centre);
            let step = if off >= 0.5 { 1.0 } else { 0.0 } - if off < -0.5 { 1.0 } else { 0.0 };
            if LIMIT { limit(centre + step, low, high) } else { centre + step }
        };
        let begin = voxel(x);
        // Rounding at the two faces must not skip a voxel.
        let end = limit(voxel(x_end), begin - 1.0, begin + 1.0);
        let plane = if begin > end { begin - 0.5 } else { end - 0.5 };
        let at = limit(-x.from(plane) * path.inverse_slope[t], 0.0, length);
        [begin, end, if begin == end { length } else { at }]
    }

    #[inline(always)]
    fn slab<const LIMIT: bool, L: Lanes, F: Field<L>>(
        field: &F,
        path: &Path,
        cell: u32,
        from: f32,
        length: f32,
    ) -> L {
        let slices = path.cells_to(cell);
        let face = slices as f32 - 0.5 + from;
        let ([u, v], [u_end, v_end]) = (path.at(face), path.at(face + length));
        let [u_first, u_last, cross_u] = Self::crossing::<LIMIT>(path, 0, u, u_end, length);
        let [v_first, v_last, cross_v] = Self::crossing::<LIMIT>(path, 1, v, v_end, length);
        let u_leads = cross_u < cross_v;
        let (first, second) = if u_leads { (cross_u, cross_v) } else { (cross_v, cross_u) };
        let (u_middle, v_middle) = if u_leads { (u_last, v_first) } else { (u_first, v_last) };
        let voxel =
            |u: f32, v: f32| field.at(path.index(slices.cast_unsigned(), [nearest(u).0, nearest(v).0]));
        voxel(u_first, v_first) * first
            + voxel(u_middle, v_middle) * (second - first)
            + voxel(u_last, v_last) * (length - second)
    }
}

impl Kernel for Siddon {
    #[inline(always)]
    fn part<L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32, from: f32, length: f32) -> L {
        Self::slab::<true, L, F>(field, path, cell, from, length)
    }

    #[inline(always)]
    fn whole<const LIMIT: bool, L: Lanes, F: Field<L>>(&self, field: &F, path: &Path, cell: u32) -> L {
        Self::slab::<LIMIT, L, F>(field, path, cell, 0.0, 1.0)
    }
}
