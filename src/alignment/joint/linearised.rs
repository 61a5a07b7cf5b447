//! How images change with the volume and with the views' parameters, to first order.

use rayon::prelude::*;

use crate::allocation::{refused, reserved};
use crate::context::Context;
use crate::error::Result;
use crate::linear_operator::LinearOperator;
use crate::parallel::{ParallelProjector, RaySelection, ViewParameters};
use crate::ray_transform::RayTransform;
use crate::real::Real;
use crate::vector::{dot, norm};

const COUNT: usize = ViewParameters::COUNT;

/// (δx, δθ) ↦ A δx + J δθ: one value per voxel, then the five parameters of each view, in units in which each parameter
/// changes the images by as much as the volume that changes them most: conjugate gradients then find it among the first.
///
/// A is the ray transform by Joseph's rule, J the derivative of the sum over equal steps, which has one with respect to the
/// motion of a parallel beam. Both are discretisations of the same line integrals and differ by their errors, which are small
/// for volumes as smooth as the voxels are large, and J is a direction only: the residual that is made small is always that
/// of A, taken anew where the views have moved to. An error dJ of J moves the end by the order of `dJᵀ r`, with r the
/// residual that is left there.
pub(super) struct Linearised<'a, T> {
    context: &'a Context,
    transform: &'a RayTransform<T>,
    /// Of each view's image, per unit of its parameters.
    derivatives: Vec<[Vec<T>; COUNT]>,
    /// The parameters' units, radians and mm; 0 for one without influence.
    pub(super) units: Vec<[f64; COUNT]>,
    pixels: usize,
}

impl<'a, T: Real> Linearised<'a, T> {
    /// About the volume of `projector` and these views. `images` are any that the transform's adjoint does not turn to 0.
    ///
    /// # Errors
    /// As [`ParallelProjector::view_jacobian`].
    pub(super) fn new(
        context: &'a Context,
        transform: &'a RayTransform<T>,
        projector: &ParallelProjector<T>,
        views: &[ViewParameters],
        images: &[T],
    ) -> Result<Self> {
        let back = transform.adjoint(images)?;
        // A step of the power method: about the largest singular value.
        let largest = norm(&transform.forward(&back)?) / norm(&back);
        let largest = if largest.is_finite() { largest } else { 0.0 };
        let mut derivatives = reserved(views.len(), "the derivatives")?;
        let mut units = reserved(views.len(), "the parameters' units")?;
        for view in views {
            let jacobian = projector.view_jacobian(view, RaySelection::default())?;
            units.push(jacobian.derivatives.each_ref().map(|plane| match norm(plane) {
                0.0 => 0.0,
                length => largest / length,
            }));
            let mut planes = jacobian.derivatives;
            for (plane, unit) in planes.iter_mut().zip(units[units.len() - 1]) {
                for value in plane {
                    *value = *value * T::of(unit);
                }
            }
            derivatives.push(planes);
        }
        Ok(Self { context, transform, derivatives, units, pixels: projector.geometry().pixels() })
    }

    /// Moves views by a part of what a solution says of them.
    pub(super) fn moved(&self, views: &mut [ViewParameters], motions: &[T], part: f64) {
        for ((view, motion), units) in views.iter_mut().zip(motions.chunks_exact(COUNT)).zip(&self.units) {
            let mut parameters = view.to_array();
            for ((parameter, step), unit) in parameters.iter_mut().zip(motion).zip(units) {
                let step: f64 = (*step).into();
                *parameter += part * unit * step;
            }
            *view = ViewParameters::from_array(parameters);
        }
    }
}

impl<T: Real> LinearOperator<T> for Linearised<'_, T> {
    fn domain(&self) -> usize {
        self.transform.domain() + COUNT * self.derivatives.len()
    }

    fn range(&self) -> usize {
        self.transform.range()
    }

    fn forward(&self, volume: &[T]) -> Result<Vec<T>> {
        let (voxels, motions) = volume.split_at(self.transform.domain());
        let mut images = self.transform.forward(voxels)?;
        self.context.install(|| {
            let views = images.par_chunks_exact_mut(self.pixels).zip(&self.derivatives);
            views.zip(motions.par_chunks_exact(COUNT)).for_each(|((image, planes), motion)| {
                for (plane, step) in planes.iter().zip(motion) {
                    image.iter_mut().zip(plane).for_each(|(value, derivative)| *value += *step * *derivative);
                }
            });
        });
        Ok(images)
    }

    fn adjoint(&self, images: &[T]) -> Result<Vec<T>> {
        let mut volume = self.transform.adjoint(images)?;
        let motions = COUNT * self.derivatives.len();
        volume.try_reserve_exact(motions).map_err(refused::<T>(motions, "the views' parameters"))?;
        for (image, planes) in images.chunks_exact(self.pixels).zip(&self.derivatives) {
            volume.extend(planes.each_ref().map(|plane| T::of(dot(plane, image))));
        }
        Ok(volume)
    }
}
