//! Some slices of a volume, as they lie in memory.

use std::ops::Range;

use crate::raycast::{Ray, ray::TRANSVERSE};
use crate::real::Real;

/// The slices `slices` of a volume across one axis, packed x fastest. All of them are the volume itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Slab {
    /// The axis across the slices: the driving axis of the rays that are sent through.
    pub axis: usize,
    /// Which slices of the volume: the first, and the one after the last.
    pub first: i32,
    pub end: i32,
    /// Slices of the whole volume.
    pub count: usize,
    /// Voxels along u and v; see [`Ray`].
    across: [usize; 2],
    /// Voxels along x, y, z.
    shape: [usize; 3],
    /// Distances in memory of neighbours along u and v, and of slices.
    strides: [usize; 2],
    stride: usize,
}

/// The four voxels of one slice around a point, and where it lies between them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bilinear<T> {
    /// The lower voxel along both axes, counted from the beginning of its slice.
    voxel: usize,
    /// Distances in memory to the upper ones.
    steps: [usize; 2],
    fractions: [T; 2],
}

impl Slab {
    /// Slices of a volume of these dimensions.
    pub(super) fn new(dimensions: [usize; 3], axis: usize, slices: Range<usize>) -> Self {
        let across = TRANSVERSE[axis].map(|t| dimensions[t]);
        let mut shape = dimensions;
        shape[axis] = slices.len();
        let strides = [1, shape[0], shape[0] * shape[1]];
        Self {
            axis,
            first: slices.start as i32,
            end: slices.end as i32,
            count: dimensions[axis],
            across,
            shape,
            strides: TRANSVERSE[axis].map(|t| strides[t]),
            stride: strides[axis],
        }
    }

    /// All slices.
    pub(super) fn whole(dimensions: [usize; 3], axis: usize) -> Self {
        Self::new(dimensions, axis, 0..dimensions[axis])
    }

    /// Number of voxels.
    pub(super) fn voxels(&self) -> usize {
        self.shape.iter().product()
    }

    /// Voxels along u and v.
    #[inline(always)]
    pub(super) fn across(&self) -> [usize; 2] {
        self.across
    }

    /// Whether a slice of the volume is one of them.
    #[inline(always)]
    pub(super) fn contains(&self, slice: i32) -> bool {
        self.first <= slice && slice < self.end
    }

    /// Where a slice of the volume begins. It must be one of the slab's.
    #[inline(always)]
    pub(super) fn slice(&self, slice: i32) -> usize {
        (slice - self.first) as usize * self.stride
    }

    /// Distances in memory of neighbours along u and v.
    #[inline(always)]
    pub(super) fn strides(&self) -> [usize; 2] {
        self.strides
    }

    /// The neighbours of the ray's point at s, in any slice.
    #[inline(always)]
    pub(super) fn bilinear<T: Real>(&self, ray: &Ray, s: f64) -> Bilinear<T> {
        self.bilinear_in(ray, s, s)
    }

    /// As `bilinear`, between the voxels around the point at `middle`, which is in the same cell up to rounding.
    #[inline(always)]
    pub(super) fn bilinear_in<T: Real>(&self, ray: &Ray, middle: f64, s: f64) -> Bilinear<T> {
        let (strides, middle, point) = (self.strides, across(ray, middle), across(ray, s));
        let lower = [0, 1].map(|t| cell(middle[t], self.across[t]));
        Bilinear {
            voxel: lower[0] as usize * strides[0] + lower[1] as usize * strides[1],
            // A single voxel is its own neighbour.
            steps: [0, 1].map(|t| if self.across[t] > 1 { strides[t] } else { 0 }),
            fractions: [0, 1].map(|t| T::of(inside(point[t], self.across[t]) - f64::from(lower[t]))),
        }
    }

    /// Adds the slab's part of the volume's row (j, k), which is `row`.
    pub(super) fn add_row<T: Real>(&self, values: &[T], [j, k]: [usize; 2], row: &mut [T]) {
        let (mut at, slices) = ([0, j, k], self.first as usize..self.end as usize);
        if self.axis > 0 {
            if !slices.contains(&at[self.axis]) {
                return;
            }
            at[self.axis] -= slices.start;
        }
        let first = (at[2] * self.shape[1] + at[1]) * self.shape[0];
        let row = if self.axis == 0 { &mut row[slices] } else { row };
        for (sum, value) in row.iter_mut().zip(&values[first..first + self.shape[0]]) {
            *sum += *value;
        }
    }
}

impl<T: Real> Bilinear<T> {
    /// The voxels in the slice that begins at `slice`.
    #[inline(always)]
    pub(super) fn voxels(&self, slice: usize) -> [usize; 4] {
        let lower = slice + self.voxel;
        let upper = lower + self.steps[1];
        [lower, lower + self.steps[0], upper, upper + self.steps[0]]
    }

    /// Their shares of `weight`.
    #[inline(always)]
    pub(super) fn weights(&self, weight: T) -> [T; 4] {
        let [u, v] = self.fractions;
        let upper = weight * v;
        let lower = weight - upper;
        let (at_lower, at_upper) = (lower * u, upper * u);
        [lower - at_lower, at_lower, upper - at_upper, at_upper]
    }
}

/// (u, v) of the ray at s.
#[inline(always)]
pub(super) fn across(ray: &Ray, s: f64) -> [f64; 2] {
    [0, 1].map(|t| ray.base[t] + ray.slope[t] * (s - ray.centre))
}

/// Lower neighbour of a point among n voxels.
#[inline(always)]
pub(super) fn cell(x: f64, n: usize) -> i32 {
    // Not negative, so that cutting is rounding down.
    (inside(x, n) as i32).min((n as i32 - 2).max(0))
}

/// In the outer half voxel the edge value holds.
#[inline(always)]
pub(super) fn inside(x: f64, n: usize) -> f64 {
    let last = (n - 1) as f64;
    // Two instructions, where `max` and `min` look for NaN, which no ray has.
    let x = if x > 0.0 { x } else { 0.0 };
    if x < last { x } else { last }
}
