//! Projects a volume in a parallel beam, with derivatives.

use crate::allocation::{collected, filled};
use crate::context::Context;
use crate::engine::Timings;
use crate::error::Result;
use crate::normal_equations::NormalEquations;
use crate::parallel::cpu::adjoint::adjoint;
use crate::parallel::engine::{Engine, ViewRays, engine};
use crate::parallel::frame::Frame;
use crate::parallel::{ParallelGeometry, Quadrature, RaySelection, ViewParameters, check_views};
use crate::real::Real;
use crate::values::{check_count, check_finite, check_finite_where};

/// One volume in one geometry: float32, or its twin in float64. May be used from many threads at once.
pub struct ParallelProjector<T> {
    context: Context,
    geometry: ParallelGeometry,
    quadrature: Quadrature,
    engine: Box<dyn Engine<T>>,
}

/// An image and its derivatives, `v*nu + u`.
#[derive(Debug, Clone, PartialEq)]
pub struct Jacobian<T> {
    /// The image.
    pub image: Vec<T>,
    /// ∂image/∂(α, β, φ, Δx, Δz), per radian and per mm.
    pub derivatives: [Vec<T>; 5],
}

impl<T: Real> ParallelProjector<T> {
    /// A projector of `volume`, one value per voxel with x fastest, for instance attenuation in 1/mm. It is copied.
    ///
    /// # Errors
    /// `InvalidArgument` for a geometry that is not valid, a volume of another size, values that are not finite;
    /// `Unsupported` for a width or a quadrature that the context's engine does not have: `reference` computes in float64,
    /// `cpu` in both, `host`, `cuda` and `metal` sums over steps in float32; `OutOfMemory`; `Device`.
    pub fn new(
        context: &Context,
        geometry: ParallelGeometry,
        quadrature: Quadrature,
        volume: &[T],
    ) -> Result<Self> {
        geometry.validate()?;
        let engine = context.install(|| engine(context, geometry, quadrature, volume))?;
        Ok(Self { context: context.clone(), geometry, quadrature, engine })
    }

    /// The geometry.
    pub fn geometry(&self) -> &ParallelGeometry {
        &self.geometry
    }

    /// What the engine's device measured of the last call that ended; `None` for engines of the CPU.
    pub fn timings(&self) -> Option<Timings> {
        self.engine.timings()
    }

    /// The image of one view: line integrals in mm times the volume's unit, `v*nu + u`.
    ///
    /// # Errors
    /// `InvalidArgument` for parameters that are not finite or rays that are not valid; `OutOfMemory`.
    pub fn forward_project_view(
        &self,
        parameters: &ViewParameters,
        rays: RaySelection<'_>,
    ) -> Result<Vec<T>> {
        rays.validate(&self.geometry)?;
        self.images(&[*parameters], rays).map_err(|error| error.called("views[0].", ""))
    }

    /// The images of several views, one after the other: `(view*nv + v)*nu + u`.
    ///
    /// # Errors
    /// As [`ParallelProjector::forward_project_view`].
    pub fn batch_forward_project(&self, views: &[ViewParameters]) -> Result<Vec<T>> {
        self.images(views, RaySelection::default())
    }

    /// Half the sum of squares of image − `measured`, its derivatives with respect to the five parameters, and `JᵀJ`, in one
    /// pass over the rays.
    ///
    /// # Errors
    /// As [`ParallelProjector::forward_project_view`]; also for a measured image of another size, or values of it, at rays
    /// that count, that are not finite.
    pub fn view_loss_value_and_grad(
        &self,
        parameters: &ViewParameters,
        measured: &[T],
        rays: RaySelection<'_>,
    ) -> Result<NormalEquations<5>> {
        self.check(parameters, rays)?;
        self.check_measured(measured, rays)?;
        self.with_view(parameters, rays, |view| self.engine.normal_equations(view, measured))
    }

    /// The image of one view and its derivatives.
    ///
    /// # Errors
    /// As [`ParallelProjector::forward_project_view`].
    pub fn view_jacobian(&self, parameters: &ViewParameters, rays: RaySelection<'_>) -> Result<Jacobian<T>> {
        self.check(parameters, rays)?;
        let plane = || filled(self.geometry.pixels(), T::default(), "the Jacobian");
        let derivatives = [plane()?, plane()?, plane()?, plane()?, plane()?];
        let mut jacobian = Jacobian { image: plane()?, derivatives };
        self.with_view(parameters, rays, |view| self.engine.jacobian(view, &mut jacobian))?;
        Ok(jacobian)
    }

    /// The transpose of [`ParallelProjector::batch_forward_project`]: of `images`, one per view one after the other, the
    /// volume, x fastest, for which ⟨A x, b⟩ = ⟨x, Aᵀ b⟩ for every x. It has the unit of the images times mm, and does not depend
    /// on the volume held. Computed on the context's CPU threads, whatever its engine.
    ///
    /// # Errors
    /// `InvalidArgument` for parameters that are not finite, another number of values than views have pixels, values that
    /// are not finite; `OutOfMemory`.
    pub fn adjoint(&self, views: &[ViewParameters], images: &[T]) -> Result<Vec<T>> {
        back_project(&self.context, &self.geometry, self.quadrature, views, images)
    }

    fn images(&self, views: &[ViewParameters], rays: RaySelection<'_>) -> Result<Vec<T>> {
        check_views(views)?;
        let mut images = filled(self.geometry.pixels() * views.len(), T::default(), "the images")?;
        with_views(&self.context, &self.geometry, views, rays, |views| {
            self.engine.project(views, &mut images)
        })?;
        Ok(images)
    }

    fn with_view<R: Send>(
        &self,
        parameters: &ViewParameters,
        rays: RaySelection<'_>,
        run: impl FnOnce(ViewRays<'_>) -> Result<R> + Send,
    ) -> Result<R> {
        let frame = Frame::new(&self.geometry, parameters);
        let derivatives = Frame::derivatives(&self.geometry, parameters);
        self.context.install(|| run(ViewRays { frame: &frame, derivatives: &derivatives, rays }))
    }

    fn check(&self, parameters: &ViewParameters, rays: RaySelection<'_>) -> Result<()> {
        parameters.validate()?;
        rays.validate(&self.geometry)
    }

    pub(crate) fn check_measured(&self, measured: &[T], rays: RaySelection<'_>) -> Result<()> {
        check_count("measured", measured.len(), self.geometry.pixels(), "pixel")?;
        check_finite_where("measured", measured, |pixel| rays.counts(pixel))
    }
}

/// [`ParallelProjector::adjoint`], which needs no volume.
pub(super) fn back_project<T: Real>(
    context: &Context,
    geometry: &ParallelGeometry,
    quadrature: Quadrature,
    views: &[ViewParameters],
    images: &[T],
) -> Result<Vec<T>> {
    check_views(views)?;
    check_count("images", images.len(), geometry.pixels() * views.len(), "pixel of each view")?;
    check_finite("images", images)?;
    let all = RaySelection::default();
    with_views(context, geometry, views, all, |views| adjoint(geometry, quadrature, views, images))
}

fn with_views<R: Send>(
    context: &Context,
    geometry: &ParallelGeometry,
    views: &[ViewParameters],
    rays: RaySelection<'_>,
    run: impl FnOnce(&[ViewRays<'_>]) -> Result<R> + Send,
) -> Result<R> {
    let frames = views.iter().map(|view| (Frame::new(geometry, view), Frame::derivatives(geometry, view)));
    let frames = collected(frames, "the views")?;
    let views = frames.iter().map(|(frame, derivatives)| ViewRays { frame, derivatives, rays });
    let views = collected(views, "the views")?;
    context.install(|| run(&views))
}

#[cfg(test)]
mod tests;
