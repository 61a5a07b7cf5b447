//! What computes a parallel projector's images.

use crate::error::Result;
use crate::normal_equations::NormalEquations;
use crate::parallel::frame::Frame;
use crate::parallel::{Jacobian, RaySelection};

/// One view's samples, how they move with the five parameters, and its rays that count.
#[derive(Clone, Copy)]
pub(super) struct ViewRays<'a> {
    pub frame: &'a Frame,
    pub derivatives: &'a [Frame; 5],
    pub rays: RaySelection<'a>,
}

/// An engine that holds one volume in one geometry. Whoever calls has checked all sizes; images are `v*nu + u`.
pub(super) trait Engine<T>: Send + Sync {
    /// The image of each view, into `images`, which are 0.
    fn project(&self, views: &[ViewRays<'_>], images: &mut [T]) -> Result<()>;

    /// Residuals image − measured of the rays that count, with their derivatives.
    fn normal_equations(&self, view: ViewRays<'_>, measured: &[T]) -> Result<NormalEquations<5>>;

    /// Image and derivatives, into planes that are 0.
    fn jacobian(&self, view: ViewRays<'_>, jacobian: &mut Jacobian<T>) -> Result<()>;
}
