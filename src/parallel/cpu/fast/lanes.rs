//! Many samples at once: interpolation and sums.

use pulp::Simd;

use crate::parallel::cpu::ray_sum::RaySum;

/// Most lanes of a vector.
pub(super) const MAX_LANES: usize = 16;

/// Sums of samples, one ray or one part of a ray per lane. Without DERIVATIVES, only of values.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd, const DERIVATIVES: bool> {
    pub value: S::f32s,
    pub slope: [S::f32s; 3],
    pub moment: [S::f32s; 3],
}

/// As many values as a vector has lanes.
#[inline(always)]
pub(super) fn load<S: Simd>(values: &[f32]) -> S::f32s {
    S::as_simd_f32s(&values[..S::F32_LANES]).0[0]
}

/// The field between the corners of cells, and its slope. Corners: z, of (x, y) = (0, 0), (0, 1), (1, 0), (1, 1).
#[inline(always)]
pub(super) fn interpolate<S: Simd, const DERIVATIVES: bool>(
    simd: S,
    corners: [[S::f32s; 2]; 4],
    [fx, fy, fz]: [S::f32s; 3],
) -> (S::f32s, [S::f32s; 3]) {
    let [a, b, c, d] = corners;
    let [az, bz, cz, dz] = [
        simd.sub_f32s(a[1], a[0]),
        simd.sub_f32s(b[1], b[0]),
        simd.sub_f32s(c[1], c[0]),
        simd.sub_f32s(d[1], d[0]),
    ];
    let [a, b, c, d] = [
        simd.mul_add_e_f32s(fz, az, a[0]),
        simd.mul_add_e_f32s(fz, bz, b[0]),
        simd.mul_add_e_f32s(fz, cz, c[0]),
        simd.mul_add_e_f32s(fz, dz, d[0]),
    ];
    let [ay, cy] = [simd.sub_f32s(b, a), simd.sub_f32s(d, c)];
    let [a, c] = [simd.mul_add_e_f32s(fy, ay, a), simd.mul_add_e_f32s(fy, cy, c)];
    let x = simd.sub_f32s(c, a);
    let value = simd.mul_add_e_f32s(fx, x, a);
    if !DERIVATIVES {
        return (value, [value; 3]);
    }
    let y = simd.mul_add_e_f32s(fx, simd.sub_f32s(cy, ay), ay);
    let az = simd.mul_add_e_f32s(fy, simd.sub_f32s(bz, az), az);
    let cz = simd.mul_add_e_f32s(fy, simd.sub_f32s(dz, cz), cz);
    let z = simd.mul_add_e_f32s(fx, simd.sub_f32s(cz, az), az);
    (value, [x, y, z])
}

impl<S: Simd, const DERIVATIVES: bool> Lanes<S, DERIVATIVES> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        let zero = simd.splat_f32s(0.0);
        Self { value: zero, slope: [zero; 3], moment: [zero; 3] }
    }

    /// One sample more in each lane, at step `k`.
    #[inline(always)]
    pub(super) fn add(&mut self, simd: S, k: S::f32s, value: S::f32s, slope: [S::f32s; 3]) {
        self.value = simd.add_f32s(self.value, value);
        if DERIVATIVES {
            for (axis, slope) in slope.into_iter().enumerate() {
                self.slope[axis] = simd.add_f32s(self.slope[axis], slope);
                self.moment[axis] = simd.mul_add_e_f32s(k, slope, self.moment[axis]);
            }
        }
    }

    /// As [`Self::add`], weighted.
    #[inline(always)]
    pub(super) fn add_weighted(
        &mut self,
        simd: S,
        weight: S::f32s,
        k: S::f32s,
        value: S::f32s,
        slope: [S::f32s; 3],
    ) {
        self.value = simd.mul_add_e_f32s(weight, value, self.value);
        if DERIVATIVES {
            for (axis, slope) in slope.into_iter().enumerate() {
                let slope = simd.mul_f32s(weight, slope);
                self.slope[axis] = simd.add_f32s(self.slope[axis], slope);
                self.moment[axis] = simd.mul_add_e_f32s(k, slope, self.moment[axis]);
            }
        }
    }

    /// Those of `other` too.
    #[inline(always)]
    pub(super) fn merge(&mut self, simd: S, other: &Self) {
        self.value = simd.add_f32s(self.value, other.value);
        if DERIVATIVES {
            for axis in 0..3 {
                self.slope[axis] = simd.add_f32s(self.slope[axis], other.slope[axis]);
                self.moment[axis] = simd.add_f32s(self.moment[axis], other.moment[axis]);
            }
        }
    }

    /// Adds each lane to its ray: steps counted here are from `middle`, those there from the middle one.
    #[inline(always)]
    pub(super) fn add_to(&self, sums: &mut [RaySum], middle: f64) {
        let lane = |vector: &S::f32s, lane: usize| f64::from(lanes_of::<S>(vector)[lane]);
        for (n, sum) in sums.iter_mut().enumerate().take(S::F32_LANES) {
            sum.value += lane(&self.value, n);
            if DERIVATIVES {
                for axis in 0..3 {
                    let slope = lane(&self.slope[axis], n);
                    sum.slope[axis] += slope;
                    sum.moment[axis] += lane(&self.moment[axis], n) + middle * slope;
                }
            }
        }
    }

    /// Adds all lanes, in a fixed order, to one ray.
    #[inline(always)]
    pub(super) fn reduce_to(&self, simd: S, sum: &mut RaySum, middle: f64) {
        let all = |vector: S::f32s| f64::from(simd.reduce_sum_f32s(vector));
        sum.value += all(self.value);
        if DERIVATIVES {
            for axis in 0..3 {
                let slope = all(self.slope[axis]);
                sum.slope[axis] += slope;
                sum.moment[axis] += all(self.moment[axis]) + middle * slope;
            }
        }
    }
}

/// A vector's lanes.
#[inline(always)]
fn lanes_of<S: Simd>(vector: &S::f32s) -> &[f32] {
    pulp::bytemuck::cast_slice(std::slice::from_ref(vector))
}
