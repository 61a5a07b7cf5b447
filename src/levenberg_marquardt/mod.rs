//! Nonlinear least squares in few unknowns, by the method of Levenberg and Marquardt.
//!
//! The problem is what a function says of it: [`NormalEquations`](crate::NormalEquations) at given parameters.

mod cholesky;
mod coarse_to_fine;
mod method;
mod solution;
#[cfg(test)]
mod tests;

pub use coarse_to_fine::{CoarseToFine, Levels, MAX_LEVELS};
pub use method::LevenbergMarquardt;
pub use solution::{Solution, Step, Stop};

pub(crate) use coarse_to_fine::{Level, check_levels};
