//! Views and volume found together: where each view really is, and what all of them show.

mod linearised;
mod problem;
mod smoothed;
mod state;
#[cfg(test)]
mod tests;

pub use problem::JointProblem;

use std::ops::ControlFlow;

use crate::alignment::without_common_motion;
use crate::allocation::{collected, reserved};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::parallel::{ParallelGeometry, ViewParameters};
use crate::real::Real;
use crate::reconstruction::check_iterations;
use smoothed::smoothed;
use state::State;

/// Most rounds of either kind.
const MAX_ROUNDS: usize = 10_000;

/// How views and volume are found together.
///
/// Images are smoothed first: of an object that is blurred by an isotropic Gaussian, projections are the projections
/// blurred by the same one, and a volume whose details are larger than its voxels has no errors of discretisation for views
/// to be drawn to. Then two kinds of rounds follow:
///
/// - *alignments*: each view is shifted to where it fits the volume best, then iterations of CGLS. This finds large errors of
///   translations; of a volume of views that do not fit, angles say little, and what views and volume agree upon changes
///   only slowly.
/// - *joint rounds*: a step of Gauss and Newton in both, `min ‖b − A x − A δx − J δθ‖`, by iterations of CGLS on A and J side by
///   side, from 0. It is halved until the residual of A falls; where it does not, the rounds end.
///
/// Alternation and its slow convergence: van Leeuwen, Maretzke & Batenburg, Inverse Problems 34(2), 024004, 2018.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointAlignment {
    /// Rounds of the first kind.
    pub alignments: usize,
    /// Rounds of the second kind.
    pub rounds: usize,
    /// Iterations of CGLS of a round.
    pub iterations: usize,
    /// Standard deviation of the smoothing, mm; about a voxel.
    pub smoothing_mm: f64,
}

/// After a round.
#[derive(Debug, Clone, Copy)]
pub struct JointRound<'a, T> {
    /// 0 for the start, before any view has moved.
    pub number: usize,
    /// ‖b − A x‖/‖b‖ of the smoothed images; where b is 0, ‖b − A x‖.
    pub residual: f64,
    /// Where the views were found; they and the volume may have moved together.
    pub views: &'a [ViewParameters],
    /// The volume so far, smoothed, x fastest.
    pub volume: &'a [T],
}

/// Views and volume.
#[derive(Debug, Clone, PartialEq)]
pub struct JointSolution<T> {
    /// Where the views were found. A motion of the object that all views have in common cannot be seen; none is left
    /// against where they were thought to be ([`without_common_motion`]).
    pub views: Vec<ViewParameters>,
    /// The smoothed volume that they were found with; of the images themselves a sharper one can be reconstructed.
    pub volume: Vec<T>,
    /// Of the start and each round that was gone; see [`JointRound::residual`].
    pub residuals: Vec<f64>,
}

/// What hears of every round; `Break` makes it the last.
pub type JointReport<'a, T> = &'a mut dyn FnMut(&JointRound<'_, T>) -> ControlFlow<()>;

impl JointAlignment {
    /// Two alignments and eight joint rounds of ten iterations, smoothed by a voxel.
    pub fn of(geometry: &ParallelGeometry) -> Self {
        Self { alignments: 2, rounds: 8, iterations: 10, smoothing_mm: geometry.spacing.max_element() }
    }

    /// # Errors
    /// `InvalidArgument` with the field that is not valid.
    pub fn validate(&self) -> Result<()> {
        for (name, rounds) in [("alignments", self.alignments), ("rounds", self.rounds)] {
            if rounds > MAX_ROUNDS {
                return Err(Error::invalid(name, rounds, format!("0 … {MAX_ROUNDS}")));
            }
        }
        check_iterations(self.iterations)?;
        if !(0.0..=1e6).contains(&self.smoothing_mm) {
            return Err(Error::invalid("smoothing_mm", self.smoothing_mm, "0 … 1e6 mm"));
        }
        Ok(())
    }

    /// Finds views and volume.
    ///
    /// # Errors
    /// `InvalidArgument` for fields that are not valid, no views, views or a geometry that are not valid, another number of
    /// pixels than the views have, and values that are not finite; `OutOfMemory`.
    pub fn solve<T: Real>(
        &self,
        context: &Context,
        problem: &JointProblem<'_, T>,
        report: JointReport<'_, T>,
    ) -> Result<JointSolution<T>> {
        self.validate()?;
        problem.validate()?;
        let images = context.install(|| smoothed(problem.images, problem.geometry, self.smoothing_mm))?;
        let mut state = State {
            context,
            geometry: problem.geometry,
            images,
            start: problem.views,
            views: collected(problem.views.iter().copied(), "the views")?,
            volume: Vec::new(),
            residuals: reserved(1 + self.alignments + self.rounds, "the residuals")?,
        };
        state.reconstruct(self.iterations, None)?;
        let mut flow = state.report(report);
        for round in 0..self.alignments + self.rounds {
            if flow.is_break() {
                break;
            }
            if round < self.alignments {
                state.align(self.iterations)?;
            } else if !state.step(self.iterations)? {
                break;
            }
            flow = state.report(report);
        }
        let views = without_common_motion(&state.views, state.start)?;
        Ok(JointSolution { views, volume: state.volume, residuals: state.residuals })
    }
}
