//! Siddon's exact lengths (Med Phys 12(2), 252, 1985), and how they change.

use crate::pose_gradient::field::FieldAlong;
use crate::pose_gradient::path_sums::{ENDS, MOMENT, PathSums, SLOPE, VALUE};
use crate::raycast::{Span, crossings};
use crate::real::Real;

/// Lengths times densities. Voxels are constant: a sum changes only where the ray crosses into a voxel of another density
/// at a face across (u, v), by the jump there times the distance that the crossing moves,
/// `−(d base + d slope·(s − centre))/slope`.
pub(super) fn integrate<T: Real>(field: &FieldAlong<'_, T>, span: Span) -> PathSums<f64> {
    let mut sums = PathSums::default();
    for pair in crossings(field.ray, span, 0.5).windows(2) {
        let (density, label) = field.nearest(field.point(0.5 * (pair[0] + pair[1])));
        sums.of[label][VALUE] += (pair[1] - pair[0]) * density;
    }
    for t in 0..2 {
        add_jumps(field, span, t, &mut sums);
    }
    for ((end, s), sign) in ENDS.into_iter().zip([span.enter, span.leave]).zip([-1.0, 1.0]) {
        let (density, label) = field.nearest(field.point(s));
        sums.of[label][end] = sign * density;
    }
    sums
}

/// The jumps at faces across u (t = 0) or v (t = 1).
fn add_jumps<T: Real>(field: &FieldAlong<'_, T>, span: Span, t: usize, sums: &mut PathSums<f64>) {
    let (base, slope, centre) = (field.ray.base[t], field.ray.slope[t], field.ray.centre);
    if slope == 0.0 {
        return;
    }
    let [from, to] = [span.enter, span.leave].map(|s| field.point(s)[1 + t]);
    let first = (from.min(to) + 0.5).ceil().max(1.0) as usize;
    let last = (from.max(to) + 0.5).floor().min(field.sides[1 + t] as f64 - 1.0) as usize;
    for upper in first..=last {
        let s = centre + (upper as f64 - 0.5 - base) / slope;
        let mut point = field.point(s);
        for (side, sign) in [(upper as f64, 1.0), (upper as f64 - 1.0, -1.0)] {
            point[1 + t] = side;
            let (density, label) = field.nearest(point);
            let jump = sign * density / slope.abs();
            sums.of[label][SLOPE[t]] += jump;
            sums.of[label][MOMENT[t]] += (s - centre) * jump;
        }
    }
}

impl<T: Real> FieldAlong<'_, T> {
    /// Density and label of the voxel at (s, u, v).
    fn nearest(&self, point: [f64; 3]) -> (f64, usize) {
        let index = |axis: usize| {
            let last = (self.sides[axis] - 1) as f64;
            (point[axis] + 0.5).floor().clamp(0.0, last) as usize * self.strides[axis]
        };
        let (density, label) = self.field.voxel(index(0) + index(1) + index(2));
        (density.into(), label)
    }
}
