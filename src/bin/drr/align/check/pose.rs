//! One pose: differences, and what is held against them.

use anyhow::Result;
use drr::Real;
use drr::parallel::{
    Jacobian, ParallelGeometry, ParallelProjector, Quadrature, RaySelection, ViewParameters,
};

use super::kinks::smooth_and_clear;

/// Half of a difference, radians and mm: the third derivative's part and float64's rounding are both below 1e-8.
const HALF: [f64; 2] = [1e-6, 1e-4];
/// From the pose to that of the image that the loss compares with, radians and mm.
const AWAY: [f64; 2] = [0.02, 3.0];

/// Where the volume is.
pub(super) struct Pose<'a> {
    geometry: &'a ParallelGeometry,
    quadrature: Quadrature,
    at: ViewParameters,
}

/// Central differences in float64.
pub(super) struct Differences {
    /// ∂image/∂parameter, one image per parameter.
    derivatives: Vec<Vec<f64>>,
    /// ∂loss/∂parameter, over the smooth rays and over the clear ones.
    slopes: [Vec<f64>; 2],
    /// What the loss compares with.
    measured: Vec<f64>,
    /// Rays without a kink.
    smooth: Vec<bool>,
    /// Those without one in float32 either.
    clear: Vec<bool>,
    /// The others, by number.
    pub(super) kinked: Vec<usize>,
}

fn half(parameter: usize) -> f64 {
    HALF[usize::from(parameter > 2)]
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| value.abs().max(largest))
}

fn select(mask: &[bool]) -> RaySelection<'_> {
    RaySelection { mask: Some(mask), lengths: None }
}

impl Differences {
    pub(super) fn new(pose: &Pose<'_>, projector: &ParallelProjector<f64>) -> Result<Self> {
        let image = |view: &ViewParameters| projector.forward_project_view(view, RaySelection::default());
        let derivative = |k: usize| -> Result<Vec<f64>> {
            let [before, after] = [image(&pose.moved(k, -half(k)))?, image(&pose.moved(k, half(k)))?];
            Ok(after.iter().zip(&before).map(|(after, before)| (after - before) / (2.0 * half(k))).collect())
        };
        let away = (0..5).fold(pose.at, |view, k| moved(&view, k, AWAY[usize::from(k > 2)]));
        let measured = image(&away)?;
        let [smooth, clear] = pose.smooth_and_clear();
        let loss = |view: &ViewParameters, mask: &[bool]| -> Result<f64> {
            Ok(projector.view_loss_value_and_grad(view, &measured, select(mask))?.loss)
        };
        let slopes = |mask: &[bool]| -> Result<Vec<f64>> {
            let slope = |k: usize| -> Result<f64> {
                let [before, after] =
                    [loss(&pose.moved(k, -half(k)), mask)?, loss(&pose.moved(k, half(k)), mask)?];
                Ok((after - before) / (2.0 * half(k)))
            };
            (0..5).map(slope).collect()
        };
        let slopes = [slopes(&smooth)?, slopes(&clear)?];
        let kinked = (0..smooth.len()).filter(|pixel| !smooth[*pixel]).collect();
        let derivatives = (0..5).map(derivative).collect::<Result<_>>()?;
        Ok(Self { derivatives, slopes, measured, smooth, clear, kinked })
    }

    /// Rays to compare.
    pub(super) fn rays(&self, double: bool) -> &[bool] {
        if double { &self.smooth } else { &self.clear }
    }
}

fn moved(view: &ViewParameters, k: usize, by: f64) -> ViewParameters {
    let mut values = view.to_array();
    values[k] += by;
    ViewParameters::from_array(values)
}

impl<'a> Pose<'a> {
    pub(super) fn new(geometry: &'a ParallelGeometry, quadrature: Quadrature, at: ViewParameters) -> Self {
        Self { geometry, quadrature, at }
    }

    fn moved(&self, k: usize, by: f64) -> ViewParameters {
        moved(&self.at, k, by)
    }

    /// The exact integral has no samples, and no kinks on rays that are not in a face.
    fn smooth_and_clear(&self) -> [Vec<bool>; 2] {
        if self.quadrature == Quadrature::Exact {
            return [vec![true; self.geometry.pixels()], vec![true; self.geometry.pixels()]];
        }
        let all: Vec<_> = (0..5).flat_map(|k| [-half(k), half(k)].map(|by| self.moved(k, by))).collect();
        smooth_and_clear(self.geometry, &self.at, &all)
    }

    /// Largest error of the image's derivatives, relative to the largest derivative with respect to the same parameter.
    pub(super) fn image_error<T: Real>(
        &self,
        differences: &Differences,
        projector: &ParallelProjector<T>,
        double: bool,
    ) -> Result<f64> {
        let rays = differences.rays(double);
        let jacobian = projector.view_jacobian(&self.at, RaySelection::default())?;
        let error = |(own, differences): (&Vec<T>, &Vec<f64>)| {
            let off = (0..rays.len()).filter(|pixel| rays[*pixel]).map(|pixel| {
                let own: f64 = own[pixel].into();
                own - differences[pixel]
            });
            largest(&off.collect::<Vec<_>>()) / largest(differences)
        };
        let errors = jacobian.derivatives.iter().zip(&differences.derivatives).map(error);
        Ok(largest(&errors.collect::<Vec<_>>()))
    }

    /// Largest errors of the loss's gradient, in parameters whose columns of J have length 1, relative to its largest
    /// entry; and of JᵀJ, likewise.
    pub(super) fn loss_errors<T: Real>(
        &self,
        differences: &Differences,
        projector: &ParallelProjector<T>,
        double: bool,
    ) -> Result<[f64; 2]> {
        let rays = differences.rays(double);
        let measured: Vec<T> = differences.measured.iter().map(|&value| T::of(value)).collect();
        let own = projector.view_loss_value_and_grad(&self.at, &measured, select(rays))?;
        let product = |k: usize, l: usize| -> f64 {
            let both = differences.derivatives[k].iter().zip(&differences.derivatives[l]);
            both.zip(rays).filter(|(_, counts)| **counts).map(|((a, b), _)| a * b).sum()
        };
        let lengths: [f64; 5] = std::array::from_fn(|k| product(k, k).sqrt());
        let slopes = &differences.slopes[usize::from(!double)];
        let scaled =
            |values: &dyn Fn(usize) -> f64| largest(&[0, 1, 2, 3, 4].map(|k| values(k) / lengths[k]));
        let gradient = scaled(&|k| own.gradient[k] - slopes[k]) / scaled(&|k| slopes[k]);
        let entry =
            |n: usize| (own.hessian[n / 5][n % 5] - product(n / 5, n % 5)) / lengths[n / 5] / lengths[n % 5];
        Ok([gradient, largest(&(0..25).map(entry).collect::<Vec<_>>())])
    }

    /// How far the differences of rays at a kink are beyond the derivatives on its sides, relative to the largest.
    pub(super) fn beyond_kinks<T: Real>(
        &self,
        differences: &Differences,
        projector: &ParallelProjector<T>,
    ) -> Result<f64> {
        let at = |view: &ViewParameters| projector.view_jacobian(view, RaySelection::default());
        let middle = at(&self.at)?;
        let mut worst = 0.0_f64;
        for (k, central) in differences.derivatives.iter().enumerate() {
            let sides = [at(&self.moved(k, -half(k)))?, at(&self.moved(k, half(k)))?];
            let [before, after] = &sides;
            let largest = largest(central);
            for &pixel in &differences.kinked {
                let value = |jacobian: &Jacobian<T>| -> f64 { jacobian.derivatives[k][pixel].into() };
                let [a, b, c] = [before, &middle, after].map(value);
                let (least, most) = (a.min(b).min(c), a.max(b).max(c));
                let beyond = (central[pixel] - most).max(least - central[pixel]).max(0.0);
                worst = worst.max(beyond / largest);
            }
        }
        Ok(worst)
    }
}
