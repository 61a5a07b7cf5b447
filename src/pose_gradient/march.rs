//! The trilinear march, with slopes.

use crate::pose_gradient::field::FieldAlong;
use crate::pose_gradient::path_sums::{BLOCK, ENDS, PathSums};
use crate::raycast::Span;
use crate::real::Real;

/// One sample in the middle of each cell's part inside the span, weighted by that part's length. Where the span's ends move,
/// length and middle of the first and the last part do.
pub(super) fn integrate<T: Real>(field: &FieldAlong<'_, T>, span: Span, step: f64) -> PathSums<f64> {
    let first_cell = ((span.enter + 0.5) / step).floor();
    let cells = ((span.leave - span.enter) / step).ceil() as usize + 2;
    let (mut sums, mut block) = (PathSums::default(), PathSums::default());
    let mut ends = [None; 2];
    for cell in 0..cells {
        let lower = -0.5 + (first_cell + cell as f64) * step;
        let upper = -0.5 + (first_cell + (cell + 1) as f64) * step;
        let (from, to) = (lower.max(span.enter), upper.min(span.leave));
        if to <= from {
            continue;
        }
        field.add(0.5 * (from + to), T::of(to - from), &mut block);
        ends = [ends[0].or(Some((from, to))), Some((from, to))];
        if cell % BLOCK == BLOCK - 1 {
            sums.take(&mut block);
        }
    }
    sums.take(&mut block);
    for ((end, part), sign) in ENDS.into_iter().zip(ends).zip([-1.0, 1.0]) {
        let Some((from, to)) = part else { continue };
        // The weight changes by ±1, the middle by ½.
        for (sums, [value, slope]) in sums.of.iter_mut().zip(field.at(0.5 * (from + to))) {
            sums[end] = sign * value + 0.5 * (to - from) * slope;
        }
    }
    sums
}
