//! The method of Levenberg and Marquardt.

use std::ops::ControlFlow;

use crate::error::{Error, Result};
use crate::levenberg_marquardt::cholesky::Cholesky;
use crate::levenberg_marquardt::solution::{Scaled, Solution, Step, Stop, without_influence};
use crate::normal_equations::NormalEquations;

/// Most iterations that may be asked for.
const MOST_STEPS: usize = 100_000;
/// Least λ that is gone on with: beside a diagonal of 1, less changes nothing in float64.
const LEAST_DAMPING: f64 = 1e-15;
/// Where no step lowers the loss, it is at a minimum if the whole step is at most so many standard deviations long.
const WITHIN_DEVIATIONS: f64 = 0.1;

/// The method of Levenberg and Marquardt: `(JᵀJ + λ diag JᵀJ) h = −Jᵀr` (Marquardt, J. SIAM 11(2), 431, 1963), with λ by
/// the gain ratio (Nielsen, IMM-REP-1999-05; Madsen, Nielsen & Tingleff, Methods for Non-Linear Least Squares Problems,
/// 2004, algorithm 3.16). Neither units of parameters nor of residuals change its path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevenbergMarquardt {
    /// Most steps that are tried.
    pub max_iterations: usize,
    /// λ of the first step.
    pub damping: f64,
    /// It ends where the cosine of the angle between residuals and each column of J is at most this.
    pub gradient_tolerance: f64,
    /// It ends where a step changes the image, to first order, by at most this part of what the parameters do.
    pub step_tolerance: f64,
    /// It ends where a step's predicted reduction of the loss is at most this part of it. A step of d standard deviations
    /// from m residuals reduces it by d²/m.
    pub reduction_tolerance: f64,
    /// A parameter whose column of J is at most this part of the longest counts as without influence, and stays: what is
    /// left of its derivatives is rounding.
    pub negligible: f64,
}

impl Default for LevenbergMarquardt {
    fn default() -> Self {
        Self {
            max_iterations: 100,
            damping: 1e-3,
            gradient_tolerance: 1e-10,
            step_tolerance: 1e-10,
            reduction_tolerance: 1e-12,
            negligible: 1e-9,
        }
    }
}

/// Where the method is: the parameters that were best, and λ with its next factor.
struct State<const N: usize> {
    parameters: [f64; N],
    equations: NormalEquations<N>,
    damping: f64,
    raise: f64,
    /// Whether a step from here was not accepted.
    rejected: bool,
    negligible: f64,
}

/// A step that was computed, in parameters of their own units.
struct Proposal<const N: usize> {
    step: [f64; N],
    /// Its length in scaled parameters.
    length: f64,
    /// By how much the loss should fall.
    reduction: f64,
}

impl LevenbergMarquardt {
    /// # Errors
    /// `InvalidArgument` with the field that is not valid.
    pub fn validate(&self) -> Result<()> {
        if self.max_iterations == 0 || self.max_iterations > MOST_STEPS {
            let valid = format!("1 … {MOST_STEPS}");
            return Err(Error::invalid("max_iterations", self.max_iterations, valid));
        }
        if !(self.damping > 0.0 && self.damping.is_finite()) {
            return Err(Error::invalid("damping", self.damping, "finite and above 0"));
        }
        let tolerances = [
            ("gradient_tolerance", self.gradient_tolerance),
            ("step_tolerance", self.step_tolerance),
            ("reduction_tolerance", self.reduction_tolerance),
            ("negligible", self.negligible),
        ];
        match tolerances.into_iter().find(|(_, tolerance)| !(0.0..1.0).contains(tolerance)) {
            Some((name, tolerance)) => Err(Error::invalid(name, tolerance, "at least 0, below 1")),
            None => Ok(()),
        }
    }

    /// The parameters, from `start`, at which the loss is least. `evaluate` computes residuals' sums; a loss that is not
    /// finite, and parameters beyond the start that `evaluate` refuses as `InvalidArgument`, count as a loss that is too
    /// large. `report` is called after the start and after each step that was tried.
    ///
    /// # Errors
    /// `InvalidArgument` for fields that are not valid, and a start that is not finite or whose loss is not; what
    /// `evaluate` returns at the start, and later but for `InvalidArgument`.
    pub fn minimise<const N: usize>(
        &self,
        start: [f64; N],
        mut evaluate: impl FnMut(&[f64; N]) -> Result<NormalEquations<N>>,
        report: &mut dyn FnMut(&Step<N>) -> ControlFlow<()>,
    ) -> Result<Solution<N>> {
        self.validate()?;
        let mut state = self.begin(start, &mut evaluate)?;
        let mut steps = Vec::new();
        let mut flow = record(&mut steps, state.step(0, true), report);
        let stop = loop {
            let scaled = state.scaled();
            if flow.is_break() {
                break Stop::Cancelled;
            }
            if scaled.gradient(state.equations.loss) <= self.gradient_tolerance {
                break Stop::Gradient;
            }
            let Some(proposal) = State::propose(&scaled, state.damping) else {
                state.raise_damping();
                if !state.damping.is_finite() {
                    break Stop::Iterations;
                }
                continue;
            };
            if let Some(stop) = self.reached(&state, &scaled, &proposal) {
                break stop;
            }
            if steps.len() > self.max_iterations {
                break Stop::Iterations;
            }
            let parameters = std::array::from_fn(|k| state.parameters[k] + proposal.step[k]);
            let equations = match evaluate(&parameters) {
                // A step that leaves the valid range is too long.
                Err(Error::InvalidArgument { .. }) => {
                    NormalEquations { loss: f64::INFINITY, ..NormalEquations::default() }
                }
                equations => equations?,
            };
            let tried = state.attempt(parameters, equations, &proposal, steps.len());
            flow = record(&mut steps, tried, report);
        };
        let State { parameters, equations, negligible, .. } = state;
        let without_influence = without_influence(&equations, negligible);
        Ok(Solution { parameters, equations, steps, stop, without_influence })
    }

    fn begin<const N: usize>(
        &self,
        start: [f64; N],
        evaluate: &mut impl FnMut(&[f64; N]) -> Result<NormalEquations<N>>,
    ) -> Result<State<N>> {
        if let Some(k) = (0..N).find(|&k| !start[k].is_finite()) {
            return Err(Error::invalid(format!("start[{k}]"), start[k], "finite numbers"));
        }
        let equations = evaluate(&start)?;
        if !finite(&equations) {
            return Err(Error::invalid(
                "the loss at the start",
                equations.loss,
                "finite, with its derivatives",
            ));
        }
        Ok(State {
            parameters: start,
            equations,
            damping: self.damping,
            raise: 2.0,
            rejected: false,
            negligible: self.negligible,
        })
    }

    /// Damping makes steps short anywhere: at a minimum, the step without it is negligible too.
    fn reached<const N: usize>(
        &self,
        state: &State<N>,
        scaled: &Scaled<N>,
        proposal: &Proposal<N>,
    ) -> Option<Stop> {
        let damped = self.negligible_step(state, scaled, proposal)?;
        // Where the equations without damping have no solution, the damped step is all there is to judge by.
        let free = State::propose(scaled, LEAST_DAMPING);
        let Some(free) = free else { return Some(if state.rejected { Stop::Stalled } else { damped }) };
        let NormalEquations { loss, rays, .. } = state.equations;
        if let Some(stop) = self.negligible_step(state, scaled, &free) {
            Some(stop)
        } else if state.rejected {
            // The loss's own rounding and kinks may hide what is left to gain.
            let within = free.reduction * rays as f64 <= WITHIN_DEVIATIONS.powi(2) * loss;
            Some(if within { damped } else { Stop::Stalled })
        } else {
            None
        }
    }

    fn negligible_step<const N: usize>(
        &self,
        state: &State<N>,
        scaled: &Scaled<N>,
        proposal: &Proposal<N>,
    ) -> Option<Stop> {
        let parameters = norm(std::array::from_fn::<f64, N, _>(|k| state.parameters[k] * scaled.lengths[k]));
        if proposal.length <= self.step_tolerance * parameters {
            Some(Stop::Step)
        } else if proposal.reduction <= self.reduction_tolerance * state.equations.loss {
            Some(Stop::Reduction)
        } else {
            None
        }
    }
}

impl<const N: usize> State<N> {
    fn scaled(&self) -> Scaled<N> {
        Scaled::new(&self.equations, without_influence(&self.equations, self.negligible))
    }

    fn propose(scaled: &Scaled<N>, damping: f64) -> Option<Proposal<N>> {
        let step = Cholesky::new(&scaled.damped(damping))?.solve(scaled.right);
        let reduction = (0..N).map(|k| 0.5 * step[k] * (damping * step[k] + scaled.right[k])).sum();
        let length = norm(step);
        Some(Proposal { step: std::array::from_fn(|k| step[k] / scaled.lengths[k]), length, reduction })
    }

    /// Takes the step if the loss falls, and sets λ for the next one.
    fn attempt(
        &mut self,
        parameters: [f64; N],
        equations: NormalEquations<N>,
        proposal: &Proposal<N>,
        iteration: usize,
    ) -> Step<N> {
        let gain = (self.equations.loss - equations.loss) / proposal.reduction;
        let accepted = finite(&equations) && gain > 0.0;
        let tried = Self { parameters, equations, ..*self };
        let step = tried.step(iteration, accepted);
        if accepted {
            let factor = (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0);
            let damping = (self.damping * factor).max(LEAST_DAMPING);
            *self = Self { damping, raise: 2.0, rejected: false, ..tried };
        } else {
            self.rejected = true;
            self.raise_damping();
        }
        step
    }

    fn raise_damping(&mut self) {
        self.damping = (self.damping * self.raise).max(LEAST_DAMPING);
        self.raise *= 2.0;
    }

    fn step(&self, iteration: usize, accepted: bool) -> Step<N> {
        let loss = self.equations.loss;
        Step {
            iteration,
            parameters: self.parameters,
            loss,
            gradient: self.scaled().gradient(loss),
            damping: self.damping,
            accepted,
        }
    }
}

fn record<const N: usize>(
    steps: &mut Vec<Step<N>>,
    step: Step<N>,
    report: &mut dyn FnMut(&Step<N>) -> ControlFlow<()>,
) -> ControlFlow<()> {
    steps.push(step);
    report(&step)
}

fn finite<const N: usize>(equations: &NormalEquations<N>) -> bool {
    let derivatives = equations.gradient.iter().chain(equations.hessian.iter().flatten());
    equations.loss.is_finite() && derivatives.copied().all(f64::is_finite)
}

fn norm<const N: usize>(vector: [f64; N]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}
