//! Views and volume on their way.

use std::ops::ControlFlow;

use crate::alignment::joint::linearised::Linearised;
use crate::alignment::{JointReport, JointRound, without_common_motion};
use crate::allocation::collected;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::View;
use crate::levenberg_marquardt::LevenbergMarquardt;
use crate::linear_operator::LinearOperator;
use crate::method::Algorithm;
use crate::normal_equations::NormalEquations;
use crate::parallel::{
    ParallelGeometry, ParallelProjector, Quadrature, RaySelection, ViewParameters, check_views,
};
use crate::ray_transform::RayTransform;
use crate::real::Real;
use crate::reconstruction::{Cgls, Problem, cgls};
use crate::vector::{add, norm};

/// Most times that a step is halved: a thousandth of it is left.
const MOST_HALVINGS: i32 = 10;

/// Where all of it is.
pub(super) struct State<'a, T> {
    pub context: &'a Context,
    pub geometry: &'a ParallelGeometry,
    /// Smoothed.
    pub images: Vec<T>,
    pub start: &'a [ViewParameters],
    pub views: Vec<ViewParameters>,
    pub volume: Vec<T>,
    pub residuals: Vec<f64>,
}

impl<T: Real> State<'_, T> {
    /// Tells what the last round found.
    pub(super) fn report(&self, report: JointReport<'_, T>) -> ControlFlow<()> {
        report(&JointRound {
            number: self.residuals.len() - 1,
            residual: self.residuals.last().copied().unwrap_or(f64::NAN),
            views: &self.views,
            volume: &self.volume,
        })
    }

    fn transform(&self) -> Result<RayTransform<T>> {
        let views = self.views.iter().map(|view| View::Projection(self.geometry.projection(view)));
        let views = collected(views, "the views")?;
        RayTransform::new(
            self.context,
            self.geometry.grid()?,
            &views,
            self.geometry.detector,
            Algorithm::Joseph,
        )
    }

    /// Iterations of CGLS on the volume alone.
    pub(super) fn reconstruct(&mut self, iterations: usize, start: Option<&[T]>) -> Result<()> {
        let transform = self.transform()?;
        let problem = Problem { operator: &transform, images: &self.images, weights: None, start };
        let found = cgls(&problem, &Cgls { iterations }, &mut |_| ControlFlow::Continue(()))?;
        self.residuals.extend(found.residuals.last());
        self.volume = found.volume;
        Ok(())
    }

    /// Every view is shifted to where it fits the volume best, then the volume again.
    pub(super) fn align(&mut self, iterations: usize) -> Result<()> {
        let projector =
            ParallelProjector::new(self.context, *self.geometry, Quadrature::Steps, &self.volume)?;
        let method = LevenbergMarquardt { max_iterations: 3, ..LevenbergMarquardt::default() };
        let images = self.images.chunks_exact(self.geometry.pixels());
        for (view, image) in self.views.iter_mut().zip(images) {
            let own = *view;
            let moved = |shifts: &[f64; 2]| ViewParameters { dx: shifts[0], dz: shifts[1], ..own };
            let evaluate = |shifts: &[f64; 2]| {
                let rays = RaySelection::default();
                Ok(translations(&projector.view_loss_value_and_grad(&moved(shifts), image, rays)?))
            };
            let start = [view.dx, view.dz];
            let found = method.minimise(start, evaluate, &mut |_| ControlFlow::Continue(()))?;
            *view = moved(&found.parameters);
        }
        self.views = without_common_motion(&self.views, self.start)?;
        let volume = std::mem::take(&mut self.volume);
        self.reconstruct(iterations, Some(&volume))
    }

    /// A step of Gauss and Newton in the volume and all views, halved until the residual falls; whether it does.
    pub(super) fn step(&mut self, iterations: usize) -> Result<bool> {
        let transform = self.transform()?;
        let residual = self.residual(&transform)?;
        let projector =
            ParallelProjector::new(self.context, *self.geometry, Quadrature::Steps, &self.volume)?;
        let operator = Linearised::new(self.context, &transform, &projector, &self.views, &residual)?;
        let problem = Problem { operator: &operator, images: &residual, weights: None, start: None };
        let found = cgls(&problem, &Cgls { iterations }, &mut |_| ControlFlow::Continue(()))?;
        let own = collected(self.views.iter().copied(), "the views")?;
        let before = norm(&residual);
        let (volume, motions) = found.volume.split_at(self.volume.len());
        let kept = collected(self.volume.iter().copied(), "the volume")?;
        for halvings in 0..=MOST_HALVINGS {
            let part = 0.5_f64.powi(halvings);
            self.views.copy_from_slice(&own);
            operator.moved(&mut self.views, motions, part);
            if check_views(&self.views).is_err() {
                continue;
            }
            add(&mut self.volume, part, volume);
            let left = norm(&self.residual(&self.transform()?)?);
            if left < before {
                let scale = norm(&self.images);
                self.residuals.push(left / if scale > 0.0 { scale } else { 1.0 });
                return Ok(true);
            }
            self.volume.copy_from_slice(&kept);
        }
        self.views = own;
        Ok(false)
    }

    /// b − A x.
    fn residual(&self, transform: &RayTransform<T>) -> Result<Vec<T>> {
        let projected = transform.forward(&self.volume)?;
        let difference = self.images.iter().zip(&projected).map(|(image, own)| *image - *own);
        collected(difference, "the residual")
    }
}

/// The part of Δx and Δz.
fn translations(all: &NormalEquations<{ ViewParameters::COUNT }>) -> NormalEquations<2> {
    let [dx, dz] = [3, 4];
    NormalEquations {
        loss: all.loss,
        gradient: [all.gradient[dx], all.gradient[dz]],
        hessian: [[all.hessian[dx][dx], all.hessian[dx][dz]], [all.hessian[dz][dx], all.hessian[dz][dz]]],
        rays: all.rays,
    }
}
