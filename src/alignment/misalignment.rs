//! Errors of views' parameters, to be found again.

use crate::effects::RowRandom;
use crate::error::{Error, Result};
use crate::parallel::ViewParameters;

/// What keeps these numbers apart from those of a view's noise.
const LAYER: usize = 1;

/// How far views are from where they are thought to be: uniform, each parameter and view on its own, the same everywhere
/// for the same seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misalignment {
    /// Largest error of each angle, degrees.
    pub degrees: f64,
    /// Largest error of each translation, mm.
    pub mm: f64,
    /// Other seeds give other errors.
    pub seed: u64,
}

impl Misalignment {
    /// # Errors
    /// `InvalidArgument` for errors below 0 or not finite, angles beyond 180° and translations beyond 1e6 mm.
    pub fn validate(&self) -> Result<()> {
        if !(0.0..=180.0).contains(&self.degrees) {
            return Err(Error::invalid("degrees", self.degrees, "0 … 180"));
        }
        if !(0.0..=1e6).contains(&self.mm) {
            return Err(Error::invalid("mm", self.mm, "0 … 1e6"));
        }
        Ok(())
    }

    /// Where the view of an index really is.
    pub fn applied(&self, view: usize, nominal: &ViewParameters) -> ViewParameters {
        let mut random = RowRandom::new(self.seed, view, LAYER, 0);
        let [alpha, beta, phi] = random.draws().map(|u| (2.0 * u - 1.0) * self.degrees.to_radians());
        let [dx, dz, _] = random.draws().map(|u| (2.0 * u - 1.0) * self.mm);
        ViewParameters {
            alpha: nominal.alpha + alpha,
            beta: nominal.beta + beta,
            phi: nominal.phi + phi,
            dx: nominal.dx + dx,
            dz: nominal.dz + dz,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_fill_their_range_and_are_the_same_again() {
        let misalignment = Misalignment { degrees: 3.0, mm: 5.0, seed: 7 };
        let nominal = ViewParameters { phi: 1.0, ..ViewParameters::default() };
        let views: Vec<_> = (0..2000).map(|view| misalignment.applied(view, &nominal).to_array()).collect();
        for (k, half) in
            [3_f64.to_radians(), 3_f64.to_radians(), 3_f64.to_radians(), 5.0, 5.0].into_iter().enumerate()
        {
            let nominal = nominal.to_array()[k];
            let errors: Vec<f64> = views.iter().map(|view| (view[k] - nominal) / half).collect();
            assert!(errors.iter().all(|error| error.abs() <= 1.0), "parameter {k}");
            // Mean 0 ± 0.013, mean of squares 1/3 ± 0.0067.
            let mean = errors.iter().sum::<f64>() / 2000.0;
            let square = errors.iter().map(|error| error * error).sum::<f64>() / 2000.0;
            assert!(mean.abs() < 0.05 && (square - 1.0 / 3.0).abs() < 0.03, "parameter {k}: {mean} {square}");
        }
        assert_eq!(misalignment.applied(3, &nominal).to_array(), views[3]);
        assert_ne!(Misalignment { seed: 8, ..misalignment }.applied(3, &nominal).to_array(), views[3]);
    }

    #[test]
    fn bad_ranges_are_named() {
        let refused =
            |degrees, mm| Misalignment { degrees, mm, seed: 0 }.validate().expect_err("refused").to_string();
        assert_eq!(refused(f64::NAN, 0.0), "degrees is NaN; valid: 0 … 180");
        assert_eq!(refused(0.0, -1.0), "mm is -1; valid: 0 … 1e6");
        assert_eq!(Misalignment { degrees: 0.0, mm: 0.0, seed: 0 }.validate(), Ok(()));
    }
}
