//! The exact integral of the field along a ray, and of its slope.

use glam::DVec3;

use crate::parallel::ParallelGeometry;
use crate::parallel::cpu::field::{Field, Limits};
use crate::parallel::cpu::ray_sum::RaySum;
use crate::parallel::frame::Frame;
use crate::real::Real;

/// The ray through pixel (u, v) between these y, mm. In a cell value and slope times k are at most cubic in k, which two
/// Gauss–Legendre nodes integrate exactly; where cells meet the field is continuous, so moving planes add nothing to
/// derivatives.
pub(super) fn integrate<T: Real>(
    field: &Field<T>,
    geometry: &ParallelGeometry,
    frame: &Frame,
    pixel: [usize; 2],
    length: [f64; 2],
) -> RaySum {
    let mut sum = RaySum::default();
    visit(field.limits(), geometry, frame, pixel, length, |k, point, weight| {
        let sample = field.at(point.to_array());
        sum.value += weight * sample.value.into();
        for axis in 0..3 {
            let slope = weight * sample.slope[axis].into();
            sum.slope[axis] += slope;
            sum.moment[axis] += k * slope;
        }
    });
    sum
}

/// The nodes of the ray within the limits: k from the middle step, the point, and its weight, mm.
pub(super) fn visit(
    limits: Limits,
    geometry: &ParallelGeometry,
    frame: &Frame,
    [u, v]: [usize; 2],
    length: [f64; 2],
    mut node: impl FnMut(f64, DVec3, f64),
) {
    let base = frame.at(u, v);
    for pair in crossings(limits, geometry, frame, base.to_array(), length).windows(2) {
        let [half, middle] = [0.5 * (pair[1] - pair[0]), 0.5 * (pair[0] + pair[1])];
        for sign in [-1.0, 1.0] {
            let k = middle + sign * half / 3.0_f64.sqrt();
            node(k, base + k * frame.step, half * geometry.step);
        }
    }
}

/// Where the ray crosses planes through voxel centres within the limits, ascending, in steps from the middle one; its ends
/// there too.
fn crossings(
    limits: Limits,
    geometry: &ParallelGeometry,
    frame: &Frame,
    base: [f64; 3],
    length: [f64; 2],
) -> Vec<f64> {
    let [mut from, mut to] = length.map(|y| (y - geometry.centre.y) / geometry.step);
    for axis in 0..3 {
        let (base, slope) = (base[axis], frame.step[axis]);
        let [low, high] = limits.0[axis];
        if slope == 0.0 {
            if !(base >= low && base <= high) {
                return Vec::new();
            }
        } else {
            let [a, b] = [(low - base) / slope, (high - base) / slope];
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
    }
    if !(from < to) {
        return Vec::new();
    }
    let mut cuts = vec![from, to];
    for axis in 0..3 {
        let (base, slope) = (base[axis], frame.step[axis]);
        if slope != 0.0 {
            let [a, b] = [base + from * slope, base + to * slope];
            let planes = a.min(b).ceil() as i64..=a.max(b).floor() as i64;
            cuts.extend(planes.map(|plane| (plane as f64 - base) / slope));
        }
    }
    cuts.retain(|k| (from..=to).contains(k));
    cuts.sort_by(f64::total_cmp);
    cuts
}
