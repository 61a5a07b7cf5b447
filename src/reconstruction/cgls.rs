//! Conjugate gradients for least squares.

use crate::allocation::collected;
use crate::error::Result;
use crate::real::Real;
use crate::reconstruction::{Problem, Reconstruction, Report};
use crate::vector::{add, dot};

/// How [`cgls`] works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cgls {
    /// Most iterations, 1 … 1 000 000.
    pub iterations: usize,
}

impl Default for Cgls {
    fn default() -> Self {
        Self { iterations: 20 }
    }
}

/// Minimises `‖b − A x‖²`, weighted, by conjugate gradients on the normal equations, which are never formed: Hestenes &
/// Stiefel, J Res NBS 49(6), 409, 1952, in the form of Björck, Numerical Methods for Least Squares Problems, 1996,
/// algorithm 7.4.1. Weights W are in the inner product of images: `Aᵀ` becomes `AᵀW`. One application of A and one of Aᵀ per
/// iteration; inner products are float64.
///
/// The residuals are those of the recurrence, which fall in every iteration; they may differ from b − A x by rounding.
/// It ends early where `AᵀW(b − A x)` is 0: nothing is better.
///
/// # Errors
/// `InvalidArgument` for a problem that is not valid (see [`Problem::validate`]) and iterations out of range;
/// images so large that values on the way overflow; `OutOfMemory`; those of the operator.
pub fn cgls<T: Real>(
    problem: &Problem<'_, T>,
    options: &Cgls,
    report: Report<'_, T>,
) -> Result<Reconstruction<T>> {
    let mut state = problem.begin(options.iterations)?;
    let mut gradient = back_projected(problem, &state.residual)?;
    let mut direction = collected(gradient.iter().copied(), "the direction")?;
    problem.check_range(&gradient)?;
    let mut square = dot(&gradient, &gradient);
    for _ in 0..options.iterations {
        if square == 0.0 {
            break;
        }
        let images = problem.operator.forward(&direction)?;
        problem.check_range(&images)?;
        let step = square / problem.squared(&images);
        if !step.is_finite() {
            break;
        }
        add(&mut state.volume, step, &direction);
        add(&mut state.residual, -step, &images);
        problem.check_range(&state.volume)?;
        problem.check_range(&state.residual)?;
        if state.finished(report).is_break() {
            break;
        }
        gradient = back_projected(problem, &state.residual)?;
        let before = square;
        square = dot(&gradient, &gradient);
        let factor = T::of(square / before);
        for (direction, gradient) in direction.iter_mut().zip(&gradient) {
            *direction = *gradient + factor * *direction;
        }
        problem.check_range(&direction)?;
    }
    Ok(state.end())
}

/// `AᵀW` times images.
fn back_projected<T: Real>(problem: &Problem<'_, T>, images: &[T]) -> Result<Vec<T>> {
    if problem.weights.is_none() {
        return problem.operator.adjoint(images);
    }
    let mut images = collected(images.iter().copied(), "the residual")?;
    problem.weigh(&mut images);
    problem.operator.adjoint(&images)
}
