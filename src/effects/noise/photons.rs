//! Line integrals as a detector that counts photons measures them.

use rayon::prelude::*;

use crate::effects::noise::poisson::poisson_quantile;
use crate::effects::noise::{MOST_PHOTONS, RowRandom};
use crate::error::{Error, Result};
use crate::real::Real;

/// Poisson noise of one energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotonNoise {
    /// Photons that reach a pixel where nothing is in the way: above 0, at most 1e12.
    pub photons: f64,
    /// Other seeds give other noise.
    pub seed: u64,
}

impl PhotonNoise {
    /// # Errors
    /// `InvalidArgument` for another dose.
    pub fn validate(&self) -> Result<()> {
        if self.photons > 0.0 && self.photons <= MOST_PHOTONS {
            Ok(())
        } else {
            Err(Error::invalid("photons", self.photons, format!("above 0, up to {MOST_PHOTONS:e} per pixel")))
        }
    }

    /// `−ln((N + ½)/N0)` for N, a Poisson number of mean `N0 exp(−p)`, in the place of each p of an image with `width`
    /// columns. The half takes the first term of the logarithm's bias, `1/(2 N)`, away and makes no photon a finite number
    /// (Anscombe, Biometrika 43(3/4), 461, 1956). The same for any number of threads.
    pub fn apply<T: Real>(&self, view: usize, width: usize, line_integrals: &mut [T]) {
        line_integrals.par_chunks_mut(width.max(1)).enumerate().for_each(|(row, values)| {
            let mut random = RowRandom::new(self.seed, view, 0, row);
            for value in values {
                let p: f64 = (*value).into();
                let [u, ..] = random.draws();
                let counted = poisson_quantile(u, self.photons * (-p).exp());
                *value = T::of(-((counted + 0.5) / self.photons).ln());
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_variance_are_those_of_photons() {
        for p in [0.0, 2.0, 5.0] {
            let mut image = vec![p; 100 * 1000];
            PhotonNoise { photons: 1e4, seed: 3 }.apply(0, 100, &mut image);
            let count = image.len() as f64;
            let mean = image.iter().sum::<f64>() / count;
            let variance = image.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
            // exp(p)/N0, and its next term; the mean of 1e5 numbers is that sure.
            let expected = p.exp() / 1e4;
            assert!((variance / expected - 1.0).abs() < 0.02 + expected, "p {p}: {variance} {expected}");
            assert!(
                (mean - p).abs() < 4.0 * (expected / count).sqrt() + expected * expected,
                "p {p}: {mean}"
            );
        }
    }

    #[test]
    fn no_photon_is_finite_and_seeds_and_views_differ() {
        let noisy = |seed, view, p: f32| {
            let mut image = vec![p; 6];
            PhotonNoise { photons: 10.0, seed }.apply(view, 3, &mut image);
            image
        };
        assert_eq!(noisy(1, 0, 50.0), [(20_f64).ln() as f32; 6]);
        assert_eq!(noisy(1, 0, 1.0), noisy(1, 0, 1.0));
        assert!(noisy(1, 0, 1.0) != noisy(2, 0, 1.0) && noisy(1, 0, 1.0) != noisy(1, 1, 1.0));
        assert!(PhotonNoise { photons: f64::NAN, seed: 0 }.validate().is_err());
    }
}
