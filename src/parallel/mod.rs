//! The differentiable parallel-beam projector of the third source document: beam along +y, the object moves.
//!
//! A world point w = (x, y, z) shows the object's point `q = Rᵀ (w − t)` with `R = R_y(β) R_x(α) R_z(φ)` and
//! `t = (Δx, 0, Δz)`; a pixel is the integral of the trilinear field along y. Outside the outermost voxel centres the field
//! falls to 0 within one voxel, so it is continuous everywhere.
//!
//! Along a ray q is affine in y, so derivatives with respect to any parameter are `∂o·Σ∇f + ∂s·Σ k∇f`, with
//! `q = o + k·s` at step k: six sums beside the value's one are all that a ray needs, whatever the number of its steps and
//! of parameters. There is no tape.

mod cpu;
#[cfg_attr(
    not(any(feature = "cuda", feature = "host", target_vendor = "apple")),
    allow(dead_code, reason = "none of its engines is built")
)]
mod device;
mod engine;
mod frame;
mod geometry;
mod operator;
mod parameters;
mod projector;
mod rays;

pub use geometry::{MAX_STEPS, ParallelGeometry};
pub use operator::ParallelOperator;
pub use parameters::ViewParameters;
pub use projector::{Jacobian, ParallelProjector};
pub use rays::RaySelection;

pub(crate) use parameters::check_views;

/// How the integral along a ray is taken.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Quadrature {
    /// The document's: samples at equal steps, times the step.
    #[default]
    Steps,
    /// The field integrated exactly, between the planes through voxel centres: there a cubic polynomial, for which two
    /// Gauss–Legendre nodes are exact. Needs no step. On engines of the CPU.
    Exact,
}
