//! A clipped ray as the float32 loops need it.

use crate::raycast::{Ray, Span, ray::TRANSVERSE};

/// A clipped ray. Transverse coordinates are relative to the voxel nearest to where the ray crosses the volume's middle
/// slice, so float32 resolves them to 1e-7 of the ray's own transverse excursion, wherever the ray is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Path {
    /// Flat index of the reference voxel in slice 0. Index arithmetic is modulo 2³²; a volume has no more voxels.
    pub origin: u32,
    /// Flat-index steps along the driving axis; 0 where the volume is one voxel thick.
    pub slice_stride: u32,
    /// Flat-index steps across it; 0 where the volume is one voxel thick.
    pub stride: [u32; 2],
    /// The volume's middle along the driving axis.
    pub centre: f32,
    /// Where the ray crosses the middle slice.
    pub base: [f32; 2],
    /// Change per slice.
    pub slope: [f32; 2],
    /// 1/slope.
    pub inverse_slope: [f32; 2],
    /// First voxel across.
    pub low: [f32; 2],
    /// Last voxel across.
    pub high: [f32; 2],
    /// Lower corner of the last cell across.
    pub last_cell: [f32; 2],
    /// Last slice, and lower corner of the last cell, along the driving axis.
    pub last_slice: [f32; 2],
    /// First and last cell of the driving axis that the ray touches; cells are the algorithm's, of `step` slices.
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

/// Distance from the outermost voxel centres, voxels, beyond which float32 rounding cannot matter.
const MARGIN: f64 = 1.0 / 128.0;

impl Path {
    /// The ray's part inside the box, in cells of `step` slices.
    pub(super) fn new(ray: &Ray, span: Span, dimensions: [usize; 3], step: f64) -> Self {
        let strides = [1, dimensions[0], dimensions[0] * dimensions[1]].map(|s| s as u32);
        let across = TRANSVERSE[ray.axis];
        let size = across.map(|axis| dimensions[axis] as f64);
        let nearest = [0, 1].map(|t| (ray.base[t] + 0.5).floor().clamp(0.0, size[t] - 1.0));
        let cell_count = (dimensions[ray.axis] as f64 / step).ceil();
        let enter = (span.enter + 0.5) / step;
        let leave = (span.leave + 0.5) / step;
        let first = enter.floor().clamp(0.0, cell_count - 1.0);
        let last = (leave.ceil() - 1.0).clamp(first, cell_count - 1.0);
        let [inner_from, inner_to] = inner_span(ray, span, dimensions);
        let inner = [((inner_from + 0.5) / step).ceil(), ((inner_to + 0.5) / step).floor()];
        Self {
            origin: (0..2)
                .map(|t| (nearest[t] as u32).wrapping_mul(strides[across[t]]))
                .fold(0, u32::wrapping_add),
            slice_stride: if dimensions[ray.axis] > 1 { strides[ray.axis] } else { 0 },
            stride: across.map(|axis| if dimensions[axis] > 1 { strides[axis] } else { 0 }),
            centre: ray.centre as f32,
            base: [0, 1].map(|t| (ray.base[t] - nearest[t]) as f32),
            slope: ray.slope.map(|slope| slope as f32),
            inverse_slope: ray.slope.map(|slope| (1.0 / slope) as f32),
            low: nearest.map(|n| -n as f32),
            high: [0, 1].map(|t| (size[t] - 1.0 - nearest[t]) as f32),
            last_cell: [0, 1].map(|t| ((size[t] - 2.0).max(0.0) - nearest[t]) as f32),
            last_slice: [1, 2].map(|n| dimensions[ray.axis].saturating_sub(n) as f32),
            cells: [first as u32, last as u32],
            inner: [inner[0].max(0.0) as u32, inner[1].max(inner[0]).max(0.0) as u32],
            ends: [(enter - first) as f32, (leave - last) as f32],
            cm_per_cell: 0.1 * ray.mm_per_slice * step,
            bin: 4 * ray.axis as u8 + 2 * u8::from(ray.slope[0] < 0.0) + u8::from(ray.slope[1] < 0.0),
        }
    }

    /// The driving axis.
    pub(super) fn axis(&self) -> usize {
        usize::from(self.bin / 4)
    }

    /// Flat index of the voxel in slice `slice`, `u` and `v` voxels from the reference voxel (modulo 2³²).
    #[inline(always)]
    pub(super) fn index(&self, slice: u32, [u, v]: [u32; 2]) -> u32 {
        self.origin
            .wrapping_add(slice.wrapping_mul(self.slice_stride))
            .wrapping_add(u.wrapping_mul(self.stride[0]))
            .wrapping_add(v.wrapping_mul(self.stride[1]))
    }

    /// Transverse coordinates, relative to the reference voxel, at slice `s`.
    #[inline(always)]
    pub(super) fn at(&self, s: f32) -> [f32; 2] {
        let ds = s - self.centre;
        [self.base[0] + self.slope[0] * ds, self.base[1] + self.slope[1] * ds]
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

/// The cell of interpolation that holds x: its lower corner, and how far x is across it. Outside `low … high` the
/// edge holds; `last` is the lower corner of the last cell. Without `LIMIT`, x must be well inside.
#[inline(always)]
pub(super) fn cell<const LIMIT: bool>(x: f32, low: f32, high: f32, last: f32) -> (u32, f32) {
    let x = if LIMIT { limit(x, low, high) } else { x };
    // At a voxel's centre the tie may go either way: fraction 1 of the lower cell is fraction 0 of the upper one.
    let (index, corner) = nearest(if LIMIT { limit(x - 0.5, low, last) } else { x - 0.5 });
    (index, x - corner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signed((index, fraction): (u32, f32)) -> (i32, f32) {
        (index.cast_signed(), fraction)
    }

    #[test]
    fn cells_hold_their_points_and_edges_hold_outside() {
        for (x, lower, fraction) in
            [(-7.0, -3, 0.0), (-3.0, -3, 0.0), (-2.75, -3, 0.25), (3.5, 3, 0.5), (9.0, 4, 1.0)]
        {
            assert_eq!(signed(cell::<true>(x, -3.0, 5.0, 4.0)), (lower, fraction), "x = {x}");
        }
        for k in -2..=4 {
            let (lower, fraction) = signed(cell::<true>(k as f32, -3.0, 5.0, 4.0));
            assert_eq!(lower as f32 + fraction, k as f32);
        }
    }
}
