//! The document's sum over equal steps, ray by ray: the plain twin of what is fast.

use glam::DVec3;

use crate::parallel::ParallelGeometry;
use crate::parallel::cpu::field::{Field, Limits};
use crate::parallel::cpu::ray_sum::RaySum;
use crate::parallel::frame::Frame;
use crate::real::Real;

/// Samples whose sums are taken in the field's own width; blocks are added in float64.
pub(super) const BLOCK: usize = 64;

/// The ray through pixel (u, v) between these y, mm.
pub(super) fn integrate<T: Real>(
    field: &Field<T>,
    geometry: &ParallelGeometry,
    frame: &Frame,
    [u, v]: [usize; 2],
    length: [f64; 2],
) -> RaySum {
    let base = frame.at(u, v);
    let middle = 0.5 * (geometry.steps as f64 - 1.0);
    let mut sum = RaySum::default();
    let inside = steps_inside(field.limits(), geometry, frame, [base, base]);
    let steps: Vec<usize> = inside.collect();
    for block in steps.chunks(BLOCK) {
        let mut part = [T::default(); 7];
        for &step in block {
            let k = step as f64 - middle;
            let weight = T::of(weight(geometry, step, length));
            let sample = field.at((base + k * frame.step).to_array());
            part[0] += weight * sample.value;
            for axis in 0..3 {
                let slope = weight * sample.slope[axis];
                part[1 + axis] += slope;
                part[4 + axis] += T::of(k) * slope;
            }
        }
        let wide = part.map(Into::<f64>::into);
        sum.value += wide[0];
        for axis in 0..3 {
            sum.slope[axis] += wide[1 + axis];
            sum.moment[axis] += wide[4 + axis];
        }
    }
    sum
}

/// The samples of the ray within the limits: k from the middle step, the point, and its weight, mm.
pub(super) fn visit(
    limits: Limits,
    geometry: &ParallelGeometry,
    frame: &Frame,
    [u, v]: [usize; 2],
    length: [f64; 2],
    mut sample: impl FnMut(f64, DVec3, f64),
) {
    let base = frame.at(u, v);
    let middle = 0.5 * (geometry.steps as f64 - 1.0);
    for step in steps_inside(limits, geometry, frame, [base, base]) {
        let k = step as f64 - middle;
        sample(k, base + k * frame.step, weight(geometry, step, length));
    }
}

/// How much of a step lies between two y, mm.
pub(in crate::parallel) fn weight(geometry: &ParallelGeometry, step: usize, [from, to]: [f64; 2]) -> f64 {
    let ends = [-0.5, 0.5].map(|half| geometry.step_position(step as f64 + half));
    if from <= ends[0] && ends[1] <= to {
        return geometry.step;
    }
    (ends[1].min(to) - ends[0].max(from)).max(0.0)
}

/// The steps at which rays whose points at the middle step lie in this box, corner to corner, can be within the
/// limits, and perhaps one more at either end.
pub(super) fn steps_inside(
    limits: Limits,
    geometry: &ParallelGeometry,
    frame: &Frame,
    base: [DVec3; 2],
) -> std::ops::Range<usize> {
    let middle = 0.5 * (geometry.steps as f64 - 1.0);
    let (mut first, mut last) = (0.0_f64, geometry.steps as f64 - 1.0);
    for (axis, [low, high]) in limits.0.into_iter().enumerate() {
        let ends = [base[0][axis].min(base[1][axis]), base[0][axis].max(base[1][axis])];
        let slope = frame.step[axis];
        if slope == 0.0 {
            if !(ends[1] >= low && ends[0] <= high) {
                return 0..0;
            }
        } else {
            let [a, b] = [(low - ends[1]) / slope + middle, (high - ends[0]) / slope + middle];
            first = first.max(a.min(b).floor());
            last = last.min(a.max(b).ceil());
        }
    }
    if first <= last { first as usize..last as usize + 1 } else { 0..0 }
}
