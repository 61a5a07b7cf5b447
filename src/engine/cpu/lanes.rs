//! One float32 per material, side by side: what a voxel holds and what a ray accumulates.

use std::ops::{Add, Mul, Sub};

use glam::Vec4;

/// A small vector of materials. Operations are lane by lane.
pub(super) trait Lanes:
    Copy + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self> + 'static
{
    /// All zero.
    const ZERO: Self;
    /// `density` in one lane, 0 in the others; all 0 when the voxel's material has no lane.
    fn single(lane: Option<usize>, density: f32) -> Self;
    /// Adds each lane to `sum`.
    fn add_to(self, sum: &mut [f64]);
}

/// (1−t) a + t b.
#[inline(always)]
pub(super) fn lerp<L: Lanes>(a: L, b: L, t: f32) -> L {
    a + (b - a) * t
}

impl Lanes for f32 {
    const ZERO: Self = 0.0;

    fn single(lane: Option<usize>, density: f32) -> Self {
        if lane.is_some() { density } else { 0.0 }
    }

    fn add_to(self, sum: &mut [f64]) {
        sum[0] += f64::from(self);
    }
}

impl Lanes for Vec4 {
    const ZERO: Self = Vec4::ZERO;

    fn single(lane: Option<usize>, density: f32) -> Self {
        let mut lanes = [0.0; 4];
        if let Some(lane) = lane {
            lanes[lane] = density;
        }
        Self::from_array(lanes)
    }

    fn add_to(self, sum: &mut [f64]) {
        sum.iter_mut().zip(self.to_array()).for_each(|(s, x)| *s += f64::from(x));
    }
}

/// Up to eight materials.
#[derive(Clone, Copy)]
pub(super) struct Eight(Vec4, Vec4);

impl Add for Eight {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }
}

impl Sub for Eight {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1)
    }
}

impl Mul<f32> for Eight {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        Self(self.0 * factor, self.1 * factor)
    }
}

impl Lanes for Eight {
    const ZERO: Self = Self(Vec4::ZERO, Vec4::ZERO);

    fn single(lane: Option<usize>, density: f32) -> Self {
        Self(
            Vec4::single(lane.filter(|&l| l < 4), density),
            Vec4::single(lane.filter(|&l| l >= 4).map(|l| l - 4), density),
        )
    }

    fn add_to(self, sum: &mut [f64]) {
        let (low, high) = sum.split_at_mut(4);
        self.0.add_to(low);
        self.1.add_to(high);
    }
}
