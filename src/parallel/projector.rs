//! Projects a volume in a parallel beam, with derivatives.

use crate::allocation::{collected, filled};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::normal_equations::NormalEquations;
use crate::parallel::cpu::Cpu;
use crate::parallel::engine::{Engine, ViewRays};
use crate::parallel::frame::Frame;
use crate::parallel::{ParallelGeometry, Quadrature, RaySelection, ViewParameters};
use crate::real::Real;

/// One volume in one geometry: float32, or its twin in float64. Immutable: may be used from many threads at once.
pub struct ParallelProjector<T> {
    context: Context,
    geometry: ParallelGeometry,
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
    /// `OutOfMemory`.
    pub fn new(
        context: &Context,
        geometry: ParallelGeometry,
        quadrature: Quadrature,
        volume: &[T],
    ) -> Result<Self> {
        geometry.validate()?;
        let engine = context.install(|| Cpu::new(geometry, quadrature, volume))?;
        Ok(Self { context: context.clone(), geometry, engine: Box::new(engine) })
    }

    /// The geometry.
    pub fn geometry(&self) -> &ParallelGeometry {
        &self.geometry
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

    fn images(&self, views: &[ViewParameters], rays: RaySelection<'_>) -> Result<Vec<T>> {
        for (k, view) in views.iter().enumerate() {
            view.validate().map_err(|error| error.of(&format!("views[{k}]")))?;
        }
        let geometry = &self.geometry;
        let mut images = filled(geometry.pixels() * views.len(), T::default(), "the images")?;
        let frames =
            views.iter().map(|view| (Frame::new(geometry, view), Frame::derivatives(geometry, view)));
        let frames = collected(frames, "the views")?;
        let views = frames.iter().map(|(frame, derivatives)| ViewRays { frame, derivatives, rays });
        let views = collected(views, "the views")?;
        self.context.install(|| self.engine.project(&views, &mut images))?;
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

    fn check_measured(&self, measured: &[T], rays: RaySelection<'_>) -> Result<()> {
        let pixels = self.geometry.pixels();
        if measured.len() != pixels {
            let valid = format!("{pixels}, one per pixel");
            return Err(Error::invalid("measured's length", measured.len(), valid));
        }
        let bad = |pixel: &usize| rays.counts(*pixel) && !Into::<f64>::into(measured[*pixel]).is_finite();
        if let Some(pixel) = (0..pixels).find(bad) {
            let value: f64 = measured[pixel].into();
            return Err(Error::invalid(
                format!("measured[{pixel}]"),
                value,
                "finite values where rays count",
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
