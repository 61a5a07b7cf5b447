//! The simultaneous iterative reconstruction technique.

use crate::allocation::filled;
use crate::error::{Error, Result};
use crate::real::Real;
use crate::reconstruction::{Problem, Reconstruction, Report};

/// How [`sirt`] works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sirt {
    /// Number of iterations, 1 … 1 000 000.
    pub iterations: usize,
    /// ω, above 0 and below 2.
    pub relaxation: f64,
    /// Whether values below 0 become 0 in every iteration.
    pub non_negative: bool,
}

impl Default for Sirt {
    fn default() -> Self {
        Self { iterations: 100, relaxation: 1.0, non_negative: false }
    }
}

impl Sirt {
    /// Checks the relaxation; iterations are checked with the problem.
    pub fn validate(&self) -> Result<()> {
        if !(self.relaxation > 0.0 && self.relaxation < 2.0) {
            return Err(Error::invalid("relaxation", self.relaxation, "above 0, below 2"));
        }
        Ok(())
    }
}

/// `x += ω C Aᵀ W R (b − A x)` with the inverse row sums R = 1/(A 1) and column sums `C = 1/(AᵀW 1)`: Gregor & Benson, IEEE TMI
/// 27(7), 918, 2008, with weights W beside. No element of A may be negative. A row or column whose sum is 0 gets 0: a ray that
/// misses the volume does not count, a voxel that no ray meets stays.
///
/// `C AᵀWR A` has eigenvalues in [0, 1], because its rows sum to 1, so that every iteration lessens the sum of w r²/(row's
/// sum) over pixels, unless values are kept from being negative; that sum is least in the end. One application of A
/// and one of Aᵀ per iteration, and one each before.
///
/// # Errors
/// `InvalidArgument` for a problem that is not valid (see [`Problem::validate`]) and options out of range, and images so large that
/// values on the way overflow; `OutOfMemory`; those of the operator.
pub fn sirt<T: Real>(
    problem: &Problem<'_, T>,
    options: &Sirt,
    report: Report<'_, T>,
) -> Result<Reconstruction<T>> {
    options.validate()?;
    let mut state = problem.begin(options.iterations)?;
    let [per_row, per_column] = scales(problem, options.relaxation)?;
    for _ in 0..options.iterations {
        multiply(&mut state.residual, &per_row);
        problem.check_range(&state.residual)?;
        let change = problem.operator.adjoint(&state.residual)?;
        for ((value, change), scale) in state.volume.iter_mut().zip(change).zip(&per_column) {
            *value += *scale * change;
            if options.non_negative && *value < T::default() {
                *value = T::default();
            }
        }
        problem.check_range(&state.volume)?;
        state.residual = problem.residual(&state.volume)?;
        problem.check_range(&state.residual)?;
        if state.finished(report).is_break() {
            break;
        }
    }
    Ok(state.end())
}

/// The diagonals of W R and of ω C.
fn scales<T: Real>(problem: &Problem<'_, T>, relaxation: f64) -> Result<[Vec<T>; 2]> {
    let ones = |count, what| filled(count, T::of(1.0), what);
    let operator = problem.operator;
    let mut per_row = operator.forward(&ones(operator.domain(), "the volume")?)?;
    let mut weights = ones(operator.range(), "the weights")?;
    problem.weigh(&mut weights);
    let mut per_column = operator.adjoint(&weights)?;
    invert(&mut per_row, 1.0);
    problem.weigh(&mut per_row);
    invert(&mut per_column, relaxation);
    Ok([per_row, per_column])
}

/// `factor` divided by each value; 0 where that is 0, or so small that there is no such number.
fn invert<T: Real>(values: &mut [T], factor: f64) {
    for value in values {
        let inverse = T::of(factor / (*value).into());
        *value = if inverse.into().is_finite() { inverse } else { T::default() };
    }
}

fn multiply<T: Real>(values: &mut [T], factors: &[T]) {
    for (value, factor) in values.iter_mut().zip(factors) {
        *value = *value * *factor;
    }
}
