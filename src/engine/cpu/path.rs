//! A clipped ray as the float32 loops need it.

use crate::engine::cpu::width::Widths;
use crate::raycast::{Footprint, Ray, Span, ray::TRANSVERSE};

/// A clipped ray, in cells of the driving axis: cell k is [−½ + k·step, −½ + (k+1)·step]. All positions are relative to
/// the reference voxel, which is near the middle of the ray's part inside the box, and to the cell there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Path {
    /// Flat index of the reference voxel. Index arithmetic is modulo 2³²; a volume has no more voxels.
    origin: u32,
    /// Flat-index steps along the driving axis; 0 where the volume is one voxel thick.
    pub slice_stride: u32,
    /// Flat-index steps across it; 0 where the volume is one voxel thick.
    pub stride: [u32; 2],
    /// The cell in the middle.
    middle: i32,
    /// The coordinate along the driving axis, from the middle cell's centre on.
    along: Course,
    /// The transverse coordinates, from the middle cell's centre on.
    courses: [Course; 2],
    /// Cells per transverse voxel.
    pub inverse_slope: [f32; 2],
    /// What limits the coordinate along the driving axis.
    pub slices: Limits,
    /// What limits the transverse coordinates.
    pub across: [Limits; 2],
    /// First and last cell that the ray touches.
    pub cells: [u32; 2],
    /// The cells that are walked, first to one past the last; the others hold nothing.
    pub walked: [u32; 2],
    /// The cells, first to one past the last, in which no coordinate can need a limit: the ray is more than `MARGIN`
    /// inside the outermost voxel centres.
    pub inner: [u32; 2],
    /// Where in the first cell the ray enters, 0 … 1.
    pub enter: f32,
    /// How much of the first and of the last cell is inside; of the only one, if it is one, the first.
    pub lengths: [f32; 2],
    /// Of the pixel.
    pub widths: Widths,
    /// World length of one cell, cm.
    pub cm_per_cell: f64,
    /// Position in the order of work: by driving axis, then by the signs of the slopes.
    pub bin: u8,
}

/// A coordinate in two parts, because an error of position that all samples share adds up along an interface: float32
/// alone would displace a ray in 1000 voxels by 3e-5 of one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Position {
    /// A multiple of a power of two, free of rounding at half-integer cells.
    coarse: f32,
    /// What is left, small.
    rest: f32,
}

impl Position {
    /// The coordinate, rounded.
    #[inline(always)]
    pub(super) fn value(self) -> f32 {
        self.coarse + self.rest
    }

    /// Distance from a voxel near it.
    #[inline(always)]
    pub(super) fn from(self, voxel: f32) -> f32 {
        (self.coarse - voxel) + self.rest
    }
}

/// A coordinate that changes evenly from cell to cell.
#[derive(Debug, Clone, Copy)]
struct Course {
    base: Position,
    /// Change per cell.
    slope: Position,
}

impl Course {
    /// For at most `reach` cells either way.
    fn new(base: f64, slope: f64, reach: f64) -> Self {
        // float32 holds multiples of `unit`/2, at half-integer cells, up to the largest coordinate.
        let largest = base.abs() + slope.abs() * reach + 2.0;
        let unit = 2_f64.powi(largest.log2().ceil() as i32 - 22);
        let split = |x: f64| {
            let coarse = (x / unit).round() * unit;
            Position { coarse: coarse as f32, rest: (x - coarse) as f32 }
        };
        Self { base: split(base), slope: split(slope) }
    }

    #[inline(always)]
    fn at(&self, t: f32) -> Position {
        Position {
            coarse: self.base.coarse + self.slope.coarse * t,
            rest: self.base.rest + self.slope.rest * t,
        }
    }
}

/// The range of a coordinate, relative to the reference voxel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// First voxel.
    pub low: f32,
    /// Last voxel.
    pub high: f32,
    /// Lower corner of the last cell of interpolation.
    pub last_cell: f32,
}

impl Limits {
    /// For an axis of `size` voxels when the reference is voxel `reference`.
    fn new(size: usize, reference: f64) -> Self {
        let relative = |voxel: usize| (voxel as f64 - reference) as f32;
        Self { low: relative(0), high: relative(size - 1), last_cell: relative(size.saturating_sub(2)) }
    }
}

/// Distance from the outermost voxel centres, voxels, beyond which float32 rounding cannot matter.
const MARGIN: f64 = 1.0 / 128.0;

impl Path {
    /// The ray's part inside the box, in cells of `step` slices.
    pub(super) fn new(ray: &Ray, span: Span, dimensions: [usize; 3], step: f64) -> Self {
        let strides = [1, dimensions[0], dimensions[0] * dimensions[1]];
        let stride = |axis: usize| if dimensions[axis] > 1 { strides[axis] as u32 } else { 0 };
        let across = TRANSVERSE[ray.axis];
        let cell_count = (dimensions[ray.axis] as f64 / step).ceil();
        let cell_of = |s: f64| (s + 0.5) / step;
        let (enter, leave) = (cell_of(span.enter), cell_of(span.leave));
        let first = enter.floor().clamp(0.0, cell_count - 1.0);
        let last = (leave.ceil() - 1.0).clamp(first, cell_count - 1.0);
        let [inner_from, inner_to] = inner_span(ray, span, dimensions).map(cell_of);
        let inner = [inner_from.ceil().max(0.0), inner_to.floor().max(0.0)];

        let middle = (0.5 * (first + last)).floor();
        let s = (middle + 0.5) * step - 0.5;
        let voxel = |x: f64, axis: usize| (x + 0.5).floor().clamp(0.0, dimensions[axis] as f64 - 1.0);
        let slice = voxel(s, ray.axis);
        let base = ray.point(s);
        let reach = last - first + 1.0;
        let reference = across.map(|axis| voxel(base[axis], axis));
        let origin = reference[0] as usize * strides[across[0]]
            + reference[1] as usize * strides[across[1]]
            + slice as usize * strides[ray.axis];
        Self {
            origin: origin as u32,
            slice_stride: stride(ray.axis),
            stride: across.map(stride),
            middle: middle as i32,
            along: Course::new(s - slice, step, reach),
            courses: [0, 1].map(|t| Course::new(base[across[t]] - reference[t], ray.slope[t] * step, reach)),
            inverse_slope: ray.slope.map(|slope| (1.0 / (slope * step)) as f32),
            slices: Limits::new(dimensions[ray.axis], slice),
            across: [0, 1].map(|t| Limits::new(dimensions[across[t]], reference[t])),
            cells: [first as u32, last as u32],
            walked: [first as u32, last as u32 + 1],
            inner: [inner[0] as u32, inner[1].max(inner[0]) as u32],
            enter: (enter - first) as f32,
            lengths: [(leave.min(first + 1.0) - enter) as f32, (leave - last) as f32],
            widths: Widths::POINT,
            cm_per_cell: 0.1 * ray.mm_per_slice * step,
            bin: 4 * ray.axis as u8 + 2 * u8::from(ray.slope[0] < 0.0) + u8::from(ray.slope[1] < 0.0),
        }
    }

    /// The same path in cells of `step` slices, of which only those that touch `met` are walked, and one more at either end: a
    /// compensated sum comes to rest at the first sample of 0.
    pub(super) fn within(self, met: Span, step: f64) -> Self {
        let [first, past] = self.walked.map(f64::from);
        let from = ((met.enter + 0.5) / step).floor() - 1.0;
        let to = ((met.leave + 0.5) / step).ceil() + 1.0;
        Self { walked: [from.clamp(first, past) as u32, to.clamp(first, past) as u32], ..self }
    }

    /// The same path of one slice per cell, of a pixel with this footprint whose ray it is.
    pub(super) fn of_pixel(self, footprint: &Footprint, ray: &Ray) -> Self {
        let from_centre = f64::from(self.middle) - ray.centre;
        let cells = self.cells.map(|cell| f64::from(self.cells_to(cell)));
        Self { widths: Widths::new(footprint, from_centre, cells), ..self }
    }

    /// The driving axis.
    pub(super) fn axis(&self) -> usize {
        usize::from(self.bin / 4)
    }

    /// Flat index of the voxel this many slices and transverse voxels from the reference voxel (all modulo 2³²).
    #[inline(always)]
    pub(super) fn index(&self, slices: u32, [u, v]: [u32; 2]) -> u32 {
        self.origin
            .wrapping_add(slices.wrapping_mul(self.slice_stride))
            .wrapping_add(u.wrapping_mul(self.stride[0]))
            .wrapping_add(v.wrapping_mul(self.stride[1]))
    }

    /// Cells from the middle one to `cell`, negative before it.
    #[inline(always)]
    pub(super) fn cells_to(&self, cell: u32) -> i32 {
        cell.cast_signed() - self.middle
    }

    /// Transverse coordinates `t` cells from the centre of the middle cell.
    #[inline(always)]
    pub(super) fn at(&self, t: f32) -> [Position; 2] {
        [self.courses[0].at(t), self.courses[1].at(t)]
    }

    /// Coordinate along the driving axis `t` cells from the centre of the middle cell.
    #[inline(always)]
    pub(super) fn slice_at(&self, t: f32) -> Position {
        self.along.at(t)
    }
}

/// The interval of s in which all three coordinates are at least `MARGIN` inside the outermost voxel centres.
fn inner_span(ray: &Ray, span: Span, dimensions: [usize; 3]) -> [f64; 2] {
    let last = |axis: usize| dimensions[axis] as f64 - 1.0 - MARGIN;
    let mut from = span.enter.max(MARGIN);
    let mut to = span.leave.min(last(ray.axis));
    for (t, &axis) in TRANSVERSE[ray.axis].iter().enumerate() {
        let [a, b] = [MARGIN, last(axis)].map(|bound| bound - ray.base[t]);
        if ray.slope[t] == 0.0 {
            if a > 0.0 || b < 0.0 {
                to = f64::NEG_INFINITY;
            }
        } else {
            let [a, b] = [a, b].map(|offset| ray.centre + offset / ray.slope[t]);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
    }
    // A span that starts after it ends is empty; the ends must not be NaN or swapped.
    if last(TRANSVERSE[ray.axis][0]) < MARGIN || last(TRANSVERSE[ray.axis][1]) < MARGIN || !(to > from) {
        return [span.leave, span.leave];
    }
    [from, to]
}

/// 1.5·2²³: adding it to |x| < 2²² leaves round(x) in the low mantissa bits.
pub(super) const ROUND: f32 = 12_582_912.0;

/// The integer nearest to x (modulo 2³²), and the same as a float; ties go to the even one. |x| < 2²².
#[inline(always)]
pub(super) fn nearest(x: f32) -> (u32, f32) {
    let shifted = x + ROUND;
    (shifted.to_bits().wrapping_sub(ROUND.to_bits()), shifted - ROUND)
}

/// x limited to `low … high`. Unlike `f32::clamp` and `max`/`min` this is two instructions; a NaN, which no path has,
/// would become `low`.
#[inline(always)]
pub(super) fn limit(x: f32, low: f32, high: f32) -> f32 {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

/// The cell of interpolation that holds x: its lower corner, and how far x is across it. Outside the limits the edge
/// holds. Without `LIMIT`, x must be well inside them.
#[inline(always)]
pub(super) fn cell<const LIMIT: bool>(x: Position, limits: Limits) -> (u32, f32) {
    let (rough_index, rough) = nearest(x.value() - 0.5);
    // x.value() is rounded, and next to a voxel's centre that may have led to the neighbouring cell.
    let fraction = x.from(rough);
    let (index_step, step) = nearest(fraction - 0.5);
    if LIMIT {
        let corner = limit(rough + step, limits.low, limits.last_cell);
        (nearest(corner).0, limit(x.from(corner), 0.0, 1.0))
    } else {
        (rough_index.wrapping_add(index_step), fraction - step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { low: -3.0, high: 5.0, last_cell: 4.0 };

    fn at(x: f32) -> Position {
        Position { coarse: x, rest: 0.0 }
    }

    fn signed((index, fraction): (u32, f32)) -> (i32, f32) {
        (index.cast_signed(), fraction)
    }

    #[test]
    fn cells_hold_their_points_and_edges_hold_outside() {
        for (x, lower, fraction) in
            [(-7.0, -3, 0.0), (-3.0, -3, 0.0), (-2.75, -3, 0.25), (3.5, 3, 0.5), (9.0, 4, 1.0)]
        {
            assert_eq!(signed(cell::<true>(at(x), LIMITS)), (lower, fraction), "x = {x}");
        }
        for k in -2..=4 {
            let (lower, fraction) = signed(cell::<true>(at(k as f32), LIMITS));
            assert_eq!(lower as f32 + fraction, k as f32);
        }
    }

    #[test]
    fn positions_are_good_to_a_hundred_millionth_of_a_voxel() {
        for (base, slope, reach) in
            [(0.3, 0.7, 1000.0), (-0.49, -1.0, 350.0), (0.1, 1e-6, 16_384.0), (0.2, 0.37 / 3.0, 4000.0)]
        {
            let course = Course::new(base, slope, reach);
            for k in -20..=20 {
                let t = (f64::from(k) / 20.0 * reach).round() + 0.5 * f64::from(k % 2);
                let Position { coarse, rest } = course.at(t as f32);
                let error = f64::from(coarse) + f64::from(rest) - (base + slope * t);
                assert!(error.abs() < 1e-8 * (1.0 + reach / 1000.0), "{base} + {slope} * {t}: {error:e}");
            }
        }
    }
}
