//! Iterative reconstruction: the volume whose images fit the measured ones best.
//!
//! A [`Problem`] is a [`LinearOperator`] A, for instance a [`RayTransform`](crate::RayTransform), and images b: line
//! integrals, −ln(I/I0). Wanted is x with A x ≈ b. Two methods:
//!
//! - [`sirt`] corrects all voxels by the back-projected residual, over and over. Slow and robust; values can be kept from
//!   turning negative.
//! - [`cgls`], conjugate gradients, reaches the same residual in far fewer iterations; stopping early keeps noise out.
//!
//! Both need Aᵀ to be the transpose of A. Both report every iteration to a function of the caller's, which may end them.
//!
//! ```
//! use std::ops::ControlFlow;
//!
//! use drr::engine::Backend;
//! use drr::geometry::{DetectorPose, Grid, View};
//! use drr::reconstruction::{Cgls, Problem, cgls};
//! use drr::{Algorithm, Context, LinearOperator, RayTransform};
//!
//! // A cube in a cube, seen from 30 sides.
//! let grid = Grid::centred([12, 12, 12], glam::DVec3::ONE)?;
//! let inner = |n: &usize| [n % 12, n / 12 % 12, n / 144].iter().all(|i| (3..9).contains(i));
//! let object: Vec<f32> = (0..grid.voxel_count()).map(|n| if inner(&n) { 0.02 } else { 0.0 }).collect();
//! let view = |n: u8| DetectorPose::c_arm(grid.centre(), 12.0 * f64::from(n), 100.0, 150.0, 1.0, [32, 32]);
//! let views: Vec<_> = (0..30).map(|n| View::Pose(view(n))).collect();
//! let context = Context::new(Backend::Cpu, 0)?;
//! let transform = RayTransform::new(&context, grid, &views, [32, 32], Algorithm::Joseph)?;
//! let images = transform.forward(&object)?;
//!
//! let problem = Problem { operator: &transform, images: &images, weights: None, start: None };
//! let found = cgls(&problem, &Cgls { iterations: 15 }, &mut |iteration| {
//!     println!("{}: {:.2e}", iteration.number, iteration.residual);
//!     ControlFlow::Continue(())
//! })?;
//! assert!(found.volume.iter().zip(&object).all(|(found, true_value)| (found - true_value).abs() < 1e-3));
//! # drr::Result::Ok(())
//! ```

mod cgls;
mod problem;
mod sirt;

pub use cgls::{Cgls, cgls};
pub use problem::Problem;
pub use sirt::{Sirt, sirt};

pub(crate) use problem::check_iterations;

use std::ops::ControlFlow;

#[cfg(doc)]
use crate::linear_operator::LinearOperator;

/// What is known after an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration<'a, T> {
    /// 1 for the first.
    pub number: usize,
    /// ‖b − A x‖/‖b‖, with the problem's weights; where b is 0, ‖b − A x‖.
    pub residual: f64,
    /// The volume so far.
    pub volume: &'a [T],
}

/// What hears of every iteration; `Break` makes it the last.
pub type Report<'a, T> = &'a mut dyn FnMut(&Iteration<'_, T>) -> ControlFlow<()>;

/// A reconstructed volume.
#[derive(Debug, Clone, PartialEq)]
pub struct Reconstruction<T> {
    /// One value per voxel, x fastest.
    pub volume: Vec<T>,
    /// The residual of the start, and after every iteration; see [`Iteration::residual`].
    pub residuals: Vec<f64>,
}

#[cfg(test)]
mod tests;
