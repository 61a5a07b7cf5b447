//! Vectors of voxels or pixels, whose sums are taken in float64.

use crate::real::Real;

/// The inner product.
pub(crate) fn dot<T: Real>(a: &[T], b: &[T]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (*a).into() * (*b).into()).sum()
}

/// The Euclidean norm.
pub(crate) fn norm<T: Real>(a: &[T]) -> f64 {
    dot(a, a).sqrt()
}

/// Adds `factor` times `b` to `a`.
pub(crate) fn add<T: Real>(a: &mut [T], factor: f64, b: &[T]) {
    let factor = T::of(factor);
    for (a, b) in a.iter_mut().zip(b) {
        *a += factor * *b;
    }
}
