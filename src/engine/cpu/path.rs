//! A clipped ray as the float32 loops need it.

use crate::raycast::{Ray, Span, ray::TRANSVERSE};

/// A clipped ray, in cells of the driving axis: cell k is [−½ + k·step, −½ + (k+1)·step]. All positions are relative to
/// the reference voxel, which is near the middle of the ray's part inside the box, and to the cell there: float32
/// resolves them to 1e-7 of that part's own extent, wherever in a volume of any size it is.
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
    /// Its centre, along the driving axis.
    slice: f32,
    /// Slices per cell.
    step: f32,
    /// Transverse coordinates at the middle cell's centre.
    base: [f32; 2],
    /// Their change per cell.
    slope: [f32; 2],
    /// Cells per transverse voxel.
    pub inverse_slope: [f32; 2],
    /// What limits the coordinate along the driving axis.
    pub slices: Limits,
    /// What limits the transverse coordinates.
    pub across: [Limits; 2],
    /// First and last cell that the ray touches.
    pub cells: [u32; 2],
    /// The cells, first to one past the last, in which no coordinate can need a limit: the ray is more than `MARGIN`
    /// inside the outermost voxel centres.
    pub inner: [u32; 2],
    /// Where in the first cell the ray enters, and where in the last it leaves, 0 … 1.
    pub ends: [f32; 2],
    /// World length of one cell, cm.
    pub cm_per_cell: f64,
    /// Position in the order of work: by driving axis, then by the signs of the slopes.
    pub bin: u8,
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
        let reference = across.map(|axis| voxel(base[axis], axis));
        let origin = reference[0] as usize * strides[across[0]]
            + reference[1] as usize * strides[across[1]]
            + slice as usize * strides[ray.axis];
        Self {
            origin: origin as u32,
            slice_stride: stride(ray.axis),
            stride: across.map(stride),
            middle: middle as i32,
            slice: (s - slice) as f32,
            step: step as f32,
            base: [0, 1].map(|t| (base[across[t]] - reference[t]) as f32),
            slope: ray.slope.map(|slope| (slope * step) as f32),
            inverse_slope: ray.slope.map(|slope| (1.0 / (slope * step)) as f32),
            slices: Limits::new(dimensions[ray.axis], slice),
            across: [0, 1].map(|t| Limits::new(dimensions[across[t]], reference[t])),
            cells: [first as u32, last as u32],
            inner: [inner[0] as u32, inner[1].max(inner[0]) as u32],
            ends: [(enter - first) as f32, (leave - last) as f32],
            cm_per_cell: 0.1 * ray.mm_per_slice * step,
            bin: 4 * ray.axis as u8 + 2 * u8::from(ray.slope[0] < 0.0) + u8::from(ray.slope[1] < 0.0),
        }
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
    pub(super) fn at(&self, t: f32) -> [f32; 2] {
        [self.base[0] + self.slope[0] * t, self.base[1] + self.slope[1] * t]
    }

    /// Coordinate along the driving axis `t` cells from the centre of the middle cell.
    #[inline(always)]
    pub(super) fn slice_at(&self, t: f32) -> f32 {
        self.slice + self.step * t
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
const ROUND: f32 = 12_582_912.0;

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
pub(super) fn cell<const LIMIT: bool>(x: f32, limits: Limits) -> (u32, f32) {
    let x = if LIMIT { limit(x, limits.low, limits.high) } else { x };
    // At a voxel's centre the tie may go either way: fraction 1 of the lower cell is fraction 0 of the upper one.
    let (index, corner) = nearest(if LIMIT { limit(x - 0.5, limits.low, limits.last_cell) } else { x - 0.5 });
    (index, x - corner)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { low: -3.0, high: 5.0, last_cell: 4.0 };

    fn signed((index, fraction): (u32, f32)) -> (i32, f32) {
        (index.cast_signed(), fraction)
    }

    #[test]
    fn cells_hold_their_points_and_edges_hold_outside() {
        for (x, lower, fraction) in
            [(-7.0, -3, 0.0), (-3.0, -3, 0.0), (-2.75, -3, 0.25), (3.5, 3, 0.5), (9.0, 4, 1.0)]
        {
            assert_eq!(signed(cell::<true>(x, LIMITS)), (lower, fraction), "x = {x}");
        }
        for k in -2..=4 {
            let (lower, fraction) = signed(cell::<true>(k as f32, LIMITS));
            assert_eq!(lower as f32 + fraction, k as f32);
        }
    }
}
