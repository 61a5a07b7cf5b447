//! What is to be reconstructed.

use std::ops::ControlFlow;

use crate::allocation::{collected, filled, reserved};
use crate::error::{Error, Result};
use crate::linear_operator::LinearOperator;
use crate::real::Real;
use crate::reconstruction::{Iteration, Reconstruction, Report};
use crate::values::{check_count, check_each, check_finite};
use crate::vector::dot;

/// Most iterations.
const MAX_ITERATIONS: usize = 1_000_000;

/// The volume x is wanted whose images A x fit `images` best.
#[derive(Clone, Copy)]
pub struct Problem<'a, T> {
    /// A, with its transpose.
    pub operator: &'a dyn LinearOperator<T>,
    /// b, one value per pixel of all images.
    pub images: &'a [T],
    /// How much pixels count in the sum of squared residuals, at least 0, one per pixel: the inverse of the noise's variance,
    /// and 0 where a pixel is to be left out. `None`: all the same.
    pub weights: Option<&'a [T]>,
    /// Where to start, one value per voxel; `None`: from 0.
    pub start: Option<&'a [T]>,
}

/// Refuses none, and more than a million.
pub(crate) fn check_iterations(iterations: usize) -> Result<()> {
    if (1..=MAX_ITERATIONS).contains(&iterations) {
        Ok(())
    } else {
        Err(Error::invalid("iterations", iterations, format!("1 … {MAX_ITERATIONS}")))
    }
}

/// A volume on its way, and how well it fits.
pub(super) struct State<'a, T> {
    problem: Problem<'a, T>,
    pub volume: Vec<T>,
    /// b − A x.
    pub residual: Vec<T>,
    residuals: Vec<f64>,
    /// ‖b‖; 1 where that is 0.
    scale: f64,
}

impl<'a, T: Real> Problem<'a, T> {
    /// Checks the numbers of values, that all are finite, and that weights are not negative.
    pub fn validate(&self) -> Result<()> {
        let (pixels, voxels) = (self.operator.range(), self.operator.domain());
        check_count("images", self.images.len(), pixels, "pixel")?;
        check_finite("images", self.images)?;
        if let Some(weights) = self.weights {
            check_count("weights", weights.len(), pixels, "pixel")?;
            let good = |_, weight: f64| weight.is_finite() && weight >= 0.0;
            check_each("weights", weights, good, "finite numbers, at least 0")?;
        }
        if let Some(start) = self.start {
            check_count("start", start.len(), voxels, "voxel")?;
            check_finite("start", start)?;
        }
        Ok(())
    }

    /// The start, with its residual.
    pub(super) fn begin(&self, iterations: usize) -> Result<State<'a, T>> {
        check_iterations(iterations)?;
        self.validate()?;
        let copy = |values: &[T], what| collected(values.iter().copied(), what);
        let (volume, residual) = if let Some(start) = self.start {
            (copy(start, "the volume")?, self.residual(start)?)
        } else {
            let zero = filled(self.operator.domain(), T::default(), "the volume")?;
            (zero, copy(self.images, "the residual")?)
        };
        self.check_range(&residual)?;
        let norm = self.norm(self.images);
        let scale = if norm > 0.0 { norm } else { 1.0 };
        let mut residuals = reserved(iterations + 1, "the residuals")?;
        residuals.push(self.norm(&residual) / scale);
        Ok(State { problem: *self, volume, residual, residuals, scale })
    }

    /// b − A x.
    pub(super) fn residual(&self, volume: &[T]) -> Result<Vec<T>> {
        let mut residual = self.operator.forward(volume)?;
        for (value, measured) in residual.iter_mut().zip(self.images) {
            *value = *measured - *value;
        }
        Ok(residual)
    }

    /// Refuses images for which values on the way are not numbers of this precision.
    pub(super) fn check_range(&self, values: &[T]) -> Result<()> {
        if values.iter().all(|value| Into::<f64>::into(*value).is_finite()) {
            return Ok(());
        }
        let size = |value: &T| Into::<f64>::into(*value).abs();
        let largest = self.images.iter().map(size).fold(0.0, f64::max);
        let bits = 8 * size_of::<T>();
        let valid = format!("so much less that sums over rays and voxels are not too large for float{bits}");
        Err(Error::invalid("images' largest value", largest, valid))
    }

    /// Multiplies images by the weights.
    pub(super) fn weigh(&self, images: &mut [T]) {
        for (value, weight) in images.iter_mut().zip(self.weights.unwrap_or_default()) {
            *value = *value * *weight;
        }
    }

    /// The norm of images in which weights count.
    pub(super) fn norm(&self, images: &[T]) -> f64 {
        self.squared(images).sqrt()
    }

    /// Its square.
    pub(super) fn squared(&self, images: &[T]) -> f64 {
        let Some(weights) = self.weights else { return dot(images, images) };
        let term = |(value, weight): (&T, &T)| (*weight).into() * (*value).into() * (*value).into();
        images.iter().zip(weights).map(term).sum()
    }
}

impl<T: Real> State<'_, T> {
    /// Notes the residual after an iteration and reports it.
    pub(super) fn finished(&mut self, report: Report<'_, T>) -> ControlFlow<()> {
        let number = self.residuals.len();
        let residual = self.problem.norm(&self.residual) / self.scale;
        self.residuals.push(residual);
        report(&Iteration { number, residual, volume: &self.volume })
    }

    /// The volume and its history.
    pub(super) fn end(self) -> Reconstruction<T> {
        Reconstruction { volume: self.volume, residuals: self.residuals }
    }
}
