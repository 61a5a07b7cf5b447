//! The interpolated field integrated exactly, with slopes.

use crate::pose_gradient::field::FieldAlong;
use crate::pose_gradient::path_sums::{BLOCK, ENDS, PathSums};
use crate::raycast::{Span, crossings};
use crate::real::Real;

/// Between planes through voxel centres the field and its slope across the driving axis times s are cubic in s, which two
/// Gauss–Legendre nodes integrate exactly. The field is continuous where cells meet: planes that move add nothing.
pub(super) fn integrate<T: Real>(field: &FieldAlong<'_, T>, span: Span) -> PathSums<f64> {
    let (mut sums, mut block) = (PathSums::default(), PathSums::default());
    for (n, pair) in crossings(field.ray, span, 0.0).windows(2).enumerate() {
        let [half, middle] = [0.5 * (pair[1] - pair[0]), 0.5 * (pair[0] + pair[1])];
        for node in [-1.0, 1.0] {
            field.add(middle + node * half / 3.0_f64.sqrt(), T::of(half), &mut block);
        }
        if n % BLOCK == BLOCK - 1 {
            sums.take(&mut block);
        }
    }
    sums.take(&mut block);
    for ((end, s), sign) in ENDS.into_iter().zip([span.enter, span.leave]).zip([-1.0, 1.0]) {
        for (sums, [value, _]) in sums.of.iter_mut().zip(field.at(s)) {
            sums[end] = sign * value;
        }
    }
    sums
}
