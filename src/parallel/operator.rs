//! A parallel beam's views as a linear map.

use std::marker::PhantomData;

use crate::allocation::collected;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::linear_operator::LinearOperator;
use crate::parallel::projector::back_project;
use crate::parallel::{ParallelGeometry, ParallelProjector, Quadrature, ViewParameters, check_views};
use crate::real::Real;

/// The map from a volume to the images of some views, and its adjoint, which is exact for either quadrature. Each volume is
/// given to the context's engine anew; the adjoint is taken on its CPU threads.
pub struct ParallelOperator<T> {
    context: Context,
    geometry: ParallelGeometry,
    quadrature: Quadrature,
    views: Vec<ViewParameters>,
    real: PhantomData<T>,
}

impl<T: Real> ParallelOperator<T> {
    /// Of these views, in their order.
    ///
    /// # Errors
    /// `InvalidArgument` without views, for a geometry or parameters that are not valid; `OutOfMemory`.
    pub fn new(
        context: &Context,
        geometry: ParallelGeometry,
        quadrature: Quadrature,
        views: &[ViewParameters],
    ) -> Result<Self> {
        geometry.validate()?;
        if views.is_empty() {
            return Err(Error::invalid("number of views", 0, "at least 1"));
        }
        check_views(views)?;
        let views = collected(views.iter().copied(), "the views")?;
        Ok(Self { context: context.clone(), geometry, quadrature, views, real: PhantomData })
    }

    /// The views.
    pub fn views(&self) -> &[ViewParameters] {
        &self.views
    }
}

impl<T: Real> LinearOperator<T> for ParallelOperator<T> {
    fn domain(&self) -> usize {
        self.geometry.dimensions.iter().product()
    }

    fn range(&self) -> usize {
        self.geometry.pixels() * self.views.len()
    }

    fn forward(&self, volume: &[T]) -> Result<Vec<T>> {
        let projector = ParallelProjector::new(&self.context, self.geometry, self.quadrature, volume)?;
        projector.batch_forward_project(&self.views)
    }

    fn adjoint(&self, images: &[T]) -> Result<Vec<T>> {
        back_project(&self.context, &self.geometry, self.quadrature, &self.views, images)
    }
}

#[cfg(test)]
mod tests;
