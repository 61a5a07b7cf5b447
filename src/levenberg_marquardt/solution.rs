//! What a least-squares fit found, and how it got there.

use std::fmt;

use crate::levenberg_marquardt::cholesky::Cholesky;
use crate::normal_equations::NormalEquations;

/// One step of the method: what was tried, whether it was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<const N: usize> {
    /// 0 is the start, which counts as accepted.
    pub iteration: usize,
    /// The parameters that were tried.
    pub parameters: [f64; N],
    /// ½ Σ r² there.
    pub loss: f64,
    /// The largest cosine of the angle between residuals and a column of J there, 0 … 1: no unit, 0 at a minimum.
    pub gradient: f64,
    /// Marquardt's λ that this step was computed with.
    pub damping: f64,
    /// Whether the loss fell, so that the method went on from here.
    pub accepted: bool,
}

/// Why the method ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// Residuals are at right angles to all derivatives, within the tolerance.
    Gradient,
    /// The next step is shorter than the tolerance.
    Step,
    /// The next step promises less than the tolerance's part of the loss.
    Reduction,
    /// No step lowers the loss, however short, although one of more than a tenth of a standard deviation promised to:
    /// derivatives are not those of the loss, or its rounding or kinks are as large as what is left to gain.
    Stalled,
    /// As many iterations as allowed; or damping beyond all numbers, where the equations are not those of any residuals.
    Iterations,
    /// The report was answered with `Break`.
    Cancelled,
}

impl Stop {
    /// Whether a minimum was reached; whether it tells all parameters is said by [`Solution::converged`].
    pub fn converged(self) -> bool {
        matches!(self, Self::Gradient | Self::Step | Self::Reduction)
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gradient => "at a minimum: residuals are at right angles to all derivatives",
            Self::Step => "at a minimum: the next step is negligible",
            Self::Reduction => "at a minimum: the next step promises a negligible reduction",
            Self::Stalled => "not at a minimum: no step lowers the loss",
            Self::Iterations => "not at a minimum: as many iterations as allowed",
            Self::Cancelled => "cancelled",
        })
    }
}

/// Where a fit ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution<const N: usize> {
    /// The best parameters found.
    pub parameters: [f64; N],
    /// Loss, gradient and `JᵀJ` there.
    pub equations: NormalEquations<N>,
    /// All steps from the start, those that were not accepted too.
    pub steps: Vec<Step<N>>,
    /// Why it ended.
    pub stop: Stop,
    /// Whether residuals did not depend on a parameter at the end, which then did not move.
    pub without_influence: [bool; N],
}

impl<const N: usize> Solution<N> {
    /// Whether a minimum was reached that tells all parameters: each has influence, and there is a covariance.
    pub fn converged(&self) -> bool {
        self.stop.converged() && !self.without_influence.contains(&true) && self.covariance().is_some()
    }

    /// What is wrong with the end, in words that call parameters by `names`; `None` where it converged, and where no step
    /// lowers the loss although the derivatives promise it: losses with kinks and rounding have their minima there.
    pub fn doubt(&self, names: [&str; N]) -> Option<String> {
        let without = names.iter().zip(self.without_influence).filter(|(_, fixed)| *fixed);
        let without: Vec<&str> = without.map(|(name, _)| *name).collect();
        if !without.is_empty() {
            Some(format!("not determined: nothing depends on {}", without.join(", ")))
        } else if self.covariance().is_none() {
            Some("not determined: a combination of parameters changes nothing, or values are too few".into())
        } else {
            Some(self.stop.to_string()).filter(|_| !self.stop.converged() && self.stop != Stop::Stalled)
        }
    }

    /// `(JᵀJ)⁻¹`. Parameters without influence have ∞ on its diagonal and 0 beside it. `None` where a combination of
    /// parameters changes nothing.
    pub fn inverse(&self) -> Option<[[f64; N]; N]> {
        let fixed = self.without_influence;
        let scaled = Scaled::new(&self.equations, fixed);
        let inverse = Cholesky::new(&scaled.damped(0.0))?.inverse();
        let entry = |k: usize, l: usize| match (fixed[k] || fixed[l], k == l) {
            (true, true) => f64::INFINITY,
            (true, false) => 0.0,
            _ => inverse[k][l] / (scaled.lengths[k] * scaled.lengths[l]),
        };
        Some(std::array::from_fn(|k| std::array::from_fn(|l| entry(k, l))))
    }

    /// `σ² (JᵀJ)⁻¹` with `σ² = Σ r² / (rays − parameters)`: the parameters' covariance where residuals are independent and of
    /// one variance (Seber & Wild, Nonlinear Regression, 1989, §2.1.2). Parameters without influence have a variance of ∞
    /// and do not count. `None` as of the inverse, and where rays are too few.
    pub fn covariance(&self) -> Option<[[f64; N]; N]> {
        let unknowns = self.without_influence.iter().filter(|fixed| !**fixed).count();
        let freedom = self.equations.rays.checked_sub(unknowns).filter(|freedom| *freedom > 0)?;
        let variance = 2.0 * self.equations.loss / freedom as f64;
        let scaled = |entry: f64| if entry.is_finite() { variance * entry } else { entry };
        self.inverse().map(|rows| rows.map(|row| row.map(scaled)))
    }

    /// The parameters' standard deviations, which are the roots of the covariance's diagonal.
    pub fn standard_deviations(&self) -> Option<[f64; N]> {
        self.covariance().map(|covariance| std::array::from_fn(|k| covariance[k][k].sqrt()))
    }
}

/// Which columns of J are at most `negligible` times as long as the longest.
pub(super) fn without_influence<const N: usize>(
    equations: &NormalEquations<N>,
    negligible: f64,
) -> [bool; N] {
    let lengths: [f64; N] = std::array::from_fn(|k| equations.hessian[k][k].sqrt());
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    lengths.map(|length| !(length > negligible * longest))
}

/// The equations in parameters that are scaled to derivatives of length 1: Marquardt's scaling by the diagonal of `JᵀJ`
/// (J. SIAM 11(2), 431, 1963). A parameter without influence has the row of the unit matrix, so that it stays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scaled<const N: usize> {
    matrix: [[f64; N]; N],
    /// Minus the loss's slope.
    pub right: [f64; N],
    /// Lengths of the columns of J, 1 of those without influence.
    pub lengths: [f64; N],
}

impl<const N: usize> Scaled<N> {
    pub(super) fn new(equations: &NormalEquations<N>, fixed: [bool; N]) -> Self {
        let hessian = &equations.hessian;
        let lengths: [f64; N] = std::array::from_fn(|k| if fixed[k] { 1.0 } else { hessian[k][k].sqrt() });
        let entry = |k: usize, l: usize| match (k == l, fixed[k] || fixed[l]) {
            (true, _) => 1.0,
            (false, true) => 0.0,
            (false, false) => hessian[k][l] / lengths[k] / lengths[l],
        };
        let right = |k: usize| if fixed[k] { 0.0 } else { -equations.gradient[k] / lengths[k] };
        Self {
            matrix: std::array::from_fn(|k| std::array::from_fn(|l| entry(k, l))),
            right: std::array::from_fn(right),
            lengths,
        }
    }

    /// With λ added to the diagonal.
    pub(super) fn damped(&self, damping: f64) -> [[f64; N]; N] {
        let mut matrix = self.matrix;
        (0..N).for_each(|k| matrix[k][k] += damping);
        matrix
    }

    /// The largest cosine of the angle between residuals and a column; 0 where there are no residuals.
    pub(super) fn gradient(&self, loss: f64) -> f64 {
        let largest = self.right.iter().fold(0.0, |largest: f64, slope| largest.max(slope.abs()));
        if largest == 0.0 { 0.0 } else { largest / (2.0 * loss).sqrt() }
    }
}
