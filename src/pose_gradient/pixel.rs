//! The signal of one pixel, and its derivatives.

use crate::method::Algorithm;
use crate::physics::{MAX_MATERIALS, SpectralModel};
use crate::pose_gradient::field::Field;
use crate::pose_gradient::moving_beam::MovingBeam;
use crate::pose_gradient::moving_ray::{MovingRay, PARAMETERS};
use crate::pose_gradient::path_sums::VALUE;
use crate::pose_gradient::{Signal, exact, joseph, march, siddon};
use crate::real::Real;

/// A signal and its derivatives with respect to α, β, φ and t.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct PixelSignal {
    pub value: f64,
    pub derivatives: [f64; PARAMETERS],
}

/// What makes pixels of rays.
pub(super) struct PixelModel<T> {
    pub field: Field<T>,
    pub algorithm: Algorithm,
    pub spectral: SpectralModel,
    /// Rays per pixel and side.
    pub supersampling: usize,
}

impl<T: Real> PixelModel<T> {
    /// The signal of pixel (column, row).
    pub(super) fn signal(&self, beam: &MovingBeam, [column, row]: [usize; 2], signal: Signal) -> PixelSignal {
        let n = self.supersampling;
        let offset = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
        let mut mean = MeanIntensity::default();
        for k in 0..n * n {
            mean.add(&self.ray(&beam.ray(column as f64 + offset(k % n), row as f64 + offset(k / n))));
        }
        let line_integral = mean.line_integral();
        match signal {
            Signal::LineIntegral => line_integral,
            Signal::Intensity => {
                let value = self.spectral.i0() * (-line_integral.value).exp();
                PixelSignal { value, derivatives: line_integral.derivatives.map(|by| -value * by) }
            }
        }
    }

    /// The line integral of one ray.
    fn ray(&self, moving: &MovingRay) -> PixelSignal {
        let dimensions = self.field.volume().grid().dimensions();
        let Some(span) = moving.ray.clip(dimensions) else { return PixelSignal::default() };
        let field = self.field.along(&moving.ray);
        let sums = match self.algorithm {
            Algorithm::Joseph => joseph::integrate(&field, span),
            Algorithm::March { step } => march::integrate(&field, span, step),
            Algorithm::Siddon => siddon::integrate(&field, span),
            Algorithm::Exact => exact::integrate(&field, span),
            Algorithm::DistanceDriven => unreachable!("refused when the projector is made"),
        };
        // mm to cm: densities are per cm³.
        let areal_density = sums.lane(VALUE).map(|sum| 0.1 * moving.ray.mm_per_slice * sum);
        let (materials, mut gradient) = (self.spectral.materials(), [0.0; MAX_MATERIALS]);
        let gradient = &mut gradient[..materials];
        let value = self.spectral.gradient(&areal_density[..materials], gradient);
        let sums = sums.weighted(gradient);
        PixelSignal { value, derivatives: moving.derivatives(&sums, span, dimensions).map(|by| 0.1 * by) }
    }
}

/// The mean of the intensities of a pixel's rays, relative to that of the least attenuated one: it cannot underflow.
struct MeanIntensity {
    /// Least line integral.
    least: f64,
    /// Σ exp(least − p).
    passing: f64,
    /// Σ exp(least − p) ∂p.
    derivatives: [f64; PARAMETERS],
    rays: usize,
}

impl Default for MeanIntensity {
    fn default() -> Self {
        Self { least: f64::INFINITY, passing: 0.0, derivatives: [0.0; PARAMETERS], rays: 0 }
    }
}

impl MeanIntensity {
    fn add(&mut self, ray: &PixelSignal) {
        if ray.value < self.least {
            let scale = (ray.value - self.least).exp();
            self.passing *= scale;
            self.derivatives = self.derivatives.map(|by| scale * by);
            self.least = ray.value;
        }
        let passing = (self.least - ray.value).exp();
        self.passing += passing;
        for (sum, by) in self.derivatives.iter_mut().zip(ray.derivatives) {
            *sum += passing * by;
        }
        self.rays += 1;
    }

    /// p of the mean.
    fn line_integral(&self) -> PixelSignal {
        PixelSignal {
            value: self.least - (self.passing / self.rays as f64).ln(),
            derivatives: self.derivatives.map(|by| by / self.passing),
        }
    }
}
