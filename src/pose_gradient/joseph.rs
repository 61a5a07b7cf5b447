//! Joseph's rule (IEEE TMI 1(3), 192, 1982), with slopes.

use crate::pose_gradient::field::FieldAlong;
use crate::pose_gradient::path_sums::{BLOCK, ENDS, PathSums};
use crate::raycast::Span;
use crate::real::Real;

/// One sample in every slice that the span touches, weighted by the part of [k−½, k+½] inside. Where the span's ends move, the
/// weights of the first and the last slice do.
pub(super) fn integrate<T: Real>(field: &FieldAlong<'_, T>, span: Span) -> PathSums<f64> {
    let last = field.sides[0] - 1;
    let first_slice = (span.enter + 0.5).floor().max(0.0) as usize;
    let (mut sums, mut block) = (PathSums::default(), PathSums::default());
    let mut ends = [first_slice; 2];
    for slice in first_slice..=last {
        let s = slice as f64;
        let weight = span.leave.min(s + 0.5) - span.enter.max(s - 0.5);
        if weight <= 0.0 {
            break;
        }
        field.add_slice(slice, T::of(weight), &mut block);
        ends[1] = slice;
        if (slice - first_slice) % BLOCK == BLOCK - 1 {
            sums.take(&mut block);
        }
    }
    sums.take(&mut block);
    for ((end, slice), sign) in ENDS.into_iter().zip(ends).zip([-1.0, 1.0]) {
        for (sums, [value, _]) in sums.of.iter_mut().zip(field.at(slice as f64)) {
            sums[end] = sign * value;
        }
    }
    sums
}
