//! The least-squares problem of one view on one level.

use crate::alignment::pyramid::Measured;
use crate::allocation::collected;
use crate::error::Result;
use crate::levenberg_marquardt::{Level, Solution};
use crate::normal_equations::NormalEquations;
use crate::parallel::{Jacobian, ViewParameters};
use crate::real::Real;

const COUNT: usize = ViewParameters::COUNT;

/// A measured image, and how much each of its pixels counts.
pub(super) struct Weighted<'a, T> {
    measured: &'a Measured<'a, T>,
    photons: bool,
    /// The roots of the weights, whose mean over the pixels that count is 1; `None`: all are 1.
    roots: Option<Vec<f64>>,
}

impl<'a, T: Real> Weighted<'a, T> {
    /// With `photons`, by those that pass in the projection that the level starts from: exp(−p).
    pub(super) fn new(measured: &'a Measured<'a, T>, photons: bool) -> Self {
        Self { measured, photons, roots: None }
    }

    /// The roots of the diagonal of `(JᵀJ)⁻¹ Jᵀ diag(r²) J (JᵀJ)⁻¹`; `None` where the image does not tell all parameters.
    pub(super) fn standard_deviations(&self, solution: &Solution<COUNT>) -> Result<Option<[f64; COUNT]>> {
        let known = |rows: &[[f64; COUNT]; COUNT]| rows.as_flattened().iter().all(|x| x.is_finite());
        let Some(inverse) = solution.inverse().filter(known) else { return Ok(None) };
        let view = ViewParameters::from_array(solution.parameters);
        let jacobian = self.measured.projector.view_jacobian(&view, self.measured.rays())?;
        let mut squares = [0.0; COUNT];
        self.each(&jacobian, |residual, row| {
            for (square, inverse) in squares.iter_mut().zip(&inverse) {
                let moved: f64 = inverse.iter().zip(row).map(|(a, b)| a * b).sum();
                *square += (residual * moved).powi(2);
            }
        });
        Ok(Some(squares.map(f64::sqrt)))
    }

    /// Each residual that counts with its derivatives, in the image's order.
    fn each(&self, jacobian: &Jacobian<T>, mut take: impl FnMut(f64, &[f64; COUNT])) {
        let image = self.measured.image();
        for pixel in (0..image.len()).filter(|&pixel| self.measured.counts(pixel)) {
            let root = self.roots.as_ref().map_or(1.0, |roots| roots[pixel]);
            let (projected, measured): (f64, f64) = (jacobian.image[pixel].into(), image[pixel].into());
            let row = std::array::from_fn(|k| root * jacobian.derivatives[k][pixel].into());
            take(root * (projected - measured), &row);
        }
    }
}

impl<T: Real> Level<COUNT> for Weighted<'_, T> {
    fn begin(&mut self, start: &[f64; COUNT]) -> Result<()> {
        if !self.photons {
            return Ok(());
        }
        let start = ViewParameters::from_array(*start);
        let image = self.measured.projector.forward_project_view(&start, self.measured.rays())?;
        let path = |pixel: usize| -> f64 { image[pixel].into() };
        let counting = || (0..image.len()).filter(|&pixel| self.measured.counts(pixel));
        // Relative to the thinnest path, of which exp(−p) may be beyond all numbers.
        let thinnest = counting().map(path).fold(f64::INFINITY, f64::min);
        let counts = |pixel: usize| self.measured.counts(pixel);
        let passed = |pixel: usize| if counts(pixel) { (thinnest - path(pixel)).exp() } else { 0.0 };
        let mean = counting().map(passed).sum::<f64>() / counting().count() as f64;
        let roots = collected((0..image.len()).map(|pixel| (passed(pixel) / mean).sqrt()), "the weights")?;
        self.roots = Some(roots);
        Ok(())
    }

    fn evaluate(&self, parameters: &[f64; COUNT]) -> Result<NormalEquations<COUNT>> {
        let view = ViewParameters::from_array(*parameters);
        let Measured { projector, .. } = self.measured;
        let (image, rays) = (self.measured.image(), self.measured.rays());
        if self.roots.is_none() {
            return projector.view_loss_value_and_grad(&view, image, rays);
        }
        let jacobian = projector.view_jacobian(&view, rays)?;
        let mut equations = NormalEquations::default();
        self.each(&jacobian, |residual, row| equations.add(residual, row));
        Ok(equations)
    }
}
