//! The weights of a convolution along one axis.

use std::f64::consts::PI;

use crate::allocation::{collected, reserved};
use crate::error::Result;

/// Standard deviation, samples, from which a Gaussian is sampled; below, its taps are made for what they must do. Here
/// the worst errors of both are the same, 0.023.
const SAMPLED_FROM: f64 = 0.873;
/// Standard deviations to either side beyond which a Gaussian has less than 1e-7 of its weight: erfc(5.33/√2) = 0.98e-7.
const REACH: f64 = 5.33;
/// Parts of the band up to half a cycle per sample in which responses are compared.
const BAND_PARTS: usize = 128;

/// A symmetric kernel of non-negative weights on samples, whose sum is 1: the centre has what its sides leave.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Taps {
    /// The weight at 1, 2, … samples to either side.
    side: Vec<f64>,
}

impl Taps {
    /// A Gaussian of the standard deviation `sigma`, at least 0, in samples.
    ///
    /// What it must do is respond with exp(−2π²σ²f²) up to the highest frequency of samples, f = 1/2. Samples of a
    /// Gaussian respond with the sum of that over f + n for all integers n (Poisson's summation formula), which is
    /// twice too much at f = 1/2. Below σ = 0.873, there are at most five taps: of variance σ² to rounding, hence right
    /// for all that is coarse, and where weights that are not negative can be so, right at f = 1/2.
    ///
    /// The response's largest error: 0.028 for σ = 0.1, 0.099 for 0.2, 0.23 for 0.43 (the worst: at f = 1/2, no
    /// non-negative taps of the variance σ² come nearer), 0.049 for 0.67, 0.023 for 0.873, 7.2e-3 for 1, 6e-5 for 1.4,
    /// below 3e-7 from 1.8 on.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn gaussian(sigma: f64) -> Result<Self> {
        if sigma >= SAMPLED_FROM {
            let reach = (REACH * sigma).ceil() as usize;
            let sample = |n: usize| (-0.5 * ((n + 1) as f64 / sigma).powi(2)).exp();
            return Ok(Self::normalised(collected((0..reach).map(sample), "a kernel")?, 1.0));
        }
        let variance = sigma * sigma;
        // Weight of both sides: all that is at odd distances is lacking twice at f = 1/2.
        let one = variance.min(0.5 * (1.0 - gaussian_response(sigma, 0.5)));
        let two = 0.25 * (variance - one);
        let mut side = reserved(2, "a kernel")?;
        side.extend([0.5 * one, 0.5 * two].into_iter().take_while(|weight| *weight > 0.0));
        Ok(Self { side })
    }

    /// The mean over a `width`, at least 0, in samples: each sample counts with the part of its cell, 1 wide, that is
    /// covered, the outermost with fractions. Up to a width of 1 that is the centre alone.
    ///
    /// Its variance from a width of 1 on is that of the uniform distribution, width²/12, and between −1/12 (odd widths)
    /// and 1/6 (even ones).
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn boxcar(width: f64) -> Result<Self> {
        let half = 0.5 * width;
        let reach = (half - 0.5).ceil().max(0.0) as usize;
        let covered = |n: usize| (half - (n as f64 + 0.5)).min(1.0);
        let side = collected((0..reach).map(covered), "a kernel")?;
        Ok(Self::normalised(side, width.min(1.0)))
    }

    /// Of weights relative to `centre`, its own.
    fn normalised(mut side: Vec<f64>, centre: f64) -> Self {
        let sum = centre + 2.0 * side.iter().rev().sum::<f64>();
        for weight in &mut side {
            *weight /= sum;
        }
        Self { side }
    }

    /// The weights at 1, 2, … samples to either side.
    pub(crate) fn side(&self) -> &[f64] {
        &self.side
    }

    /// Every weight with its distance from the centre, samples.
    pub(crate) fn weights(&self) -> Vec<(i32, f64)> {
        let centre = 1.0 - 2.0 * self.side.iter().sum::<f64>();
        let sides = (1..).zip(&self.side).flat_map(|(n, &weight)| [(n, weight), (-n, weight)]);
        std::iter::once((0, centre)).chain(sides).collect()
    }

    /// Whether nothing is changed by it.
    pub(crate) fn is_identity(&self) -> bool {
        self.side.is_empty()
    }

    /// The amplitude at which a sine of amplitude 1 is left; `frequency` in cycles per sample.
    pub(crate) fn response(&self, frequency: f64) -> f64 {
        // 1 − cos φ = 2 sin²(φ/2) keeps its digits.
        let lost = |(n, weight): (usize, &f64)| weight * (PI * frequency * (n + 1) as f64).sin().powi(2);
        1.0 - 4.0 * self.side.iter().enumerate().map(lost).sum::<f64>()
    }

    /// The largest difference between the response and the one `wanted`, from 0 up to half a cycle per sample.
    #[cfg(test)]
    pub(crate) fn worst_response_error(&self, wanted: impl Fn(f64) -> f64) -> f64 {
        worst_error(|frequency| self.response(frequency) - wanted(frequency))
    }
}

/// What a Gaussian of standard deviation `sigma` leaves of a sine at `frequency` cycles per the unit of `sigma`: its Fourier
/// transform.
pub(crate) fn gaussian_response(sigma: f64, frequency: f64) -> f64 {
    (-2.0 * (PI * sigma * frequency).powi(2)).exp()
}

/// The largest magnitude of an error from 0 up to half a cycle per sample.
pub(super) fn worst_error(error: impl Fn(f64) -> f64) -> f64 {
    let frequency = |k: usize| 0.5 * k as f64 / BAND_PARTS as f64;
    (0..=BAND_PARTS).map(|k| error(frequency(k)).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGMAS: [f64; 14] = [0.0, 1e-3, 0.1, 0.2, 0.43, 0.6, 0.66, 0.7, 0.8, 0.88, 1.0, 1.4, 4.0, 300.0];

    fn gaussian(sigma: f64) -> Taps {
        Taps::gaussian(sigma).expect("memory")
    }

    fn boxcar(width: f64) -> Taps {
        Taps::boxcar(width).expect("memory")
    }

    /// `Σ weight · distance^power` of both sides.
    fn moment(taps: &Taps, power: i32) -> f64 {
        taps.side().iter().enumerate().map(|(n, weight)| 2.0 * weight * ((n + 1) as f64).powi(power)).sum()
    }

    #[test]
    fn weights_are_positive_and_the_centre_has_the_most() {
        let kernels = SIGMAS.map(gaussian).into_iter().chain([0.0, 0.4, 1.0, 1.2, 2.9, 7.0, 1e4].map(boxcar));
        for taps in kernels {
            let centre = 1.0 - moment(&taps, 0);
            assert!(
                taps.side().iter().all(|weight| *weight > 0.0 && *weight < centre * (1.0 + 1e-9)),
                "{taps:?}"
            );
        }
    }

    #[test]
    fn a_gaussian_has_its_variance() {
        for sigma in SIGMAS {
            let (error, square) = (moment(&gaussian(sigma), 2) - sigma * sigma, sigma * sigma);
            // Samples of a Gaussian, from 0.873 on, are narrower: by 1e-4 there.
            let bound =
                if sigma < SAMPLED_FROM { 1e-15 } else { 4e-6_f64.max(2e-4 * (1.0 - sigma)) * square };
            assert!(error.abs() <= bound, "{sigma}: {error:e}");
        }
    }

    #[test]
    fn a_gaussian_s_response_is_as_near_as_its_documentation_says() {
        let documented = [
            (0.1, 0.029),
            (0.2, 0.1),
            (0.43, 0.229),
            (0.67, 0.0493),
            (0.873, 0.0234),
            (1.0, 7.3e-3),
            (1.4, 6.4e-5),
            (1.8, 3e-7),
            (40.0, 2e-7),
        ];
        for (sigma, bound) in documented {
            let error = gaussian(sigma).worst_response_error(|f| gaussian_response(sigma, f));
            assert!(error < bound && error > 0.2 * bound, "{sigma}: {error:e}");
        }
        let all = (0..600).map(|k| f64::from(k) / 200.0);
        let error = |sigma: f64| gaussian(sigma).worst_response_error(|f| gaussian_response(sigma, f));
        assert!(all.map(error).fold(0.0, f64::max) < 0.229);
    }

    #[test]
    fn both_ways_are_as_good_where_they_meet() {
        let errors = [SAMPLED_FROM - 1e-9, SAMPLED_FROM]
            .map(|sigma| gaussian(sigma).worst_response_error(|f| gaussian_response(sigma, f)));
        assert!((errors[0] / errors[1] - 1.0).abs() < 0.01, "{errors:?}");
    }

    #[test]
    fn a_boxcar_covers_its_width() {
        assert!(boxcar(0.7).is_identity() && boxcar(1.0).is_identity());
        let same = |taps: &Taps, side: &[f64]| {
            taps.side().len() == side.len()
                && taps.side().iter().zip(side).all(|(a, b)| (a - b).abs() < 1e-15)
        };
        assert!(same(&boxcar(1.5), &[0.25 / 1.5]));
        assert!(same(&boxcar(3.0), &[1.0 / 3.0]));
        assert!(same(&boxcar(4.0), &[0.25, 0.125]));
        assert!(same(&boxcar(4.2), &[1.0 / 4.2, 0.6 / 4.2]));
        for (width, more) in [(1.0, -1.0 / 12.0), (7.0, -1.0 / 12.0), (2.0, 1.0 / 6.0), (30.0, 1.0 / 6.0)] {
            assert!((moment(&boxcar(width), 2) - width * width / 12.0 - more).abs() < 1e-13, "{width}");
        }
    }

    #[test]
    fn a_boxcar_s_response_is_dirichlet_s_kernel() {
        for (width, f) in [(5.0, 0.03), (5.0, 0.31), (21.0, 0.2)] {
            let exact = (PI * f * width).sin() / (width * (PI * f).sin());
            assert!((boxcar(width).response(f) - exact).abs() < 1e-14, "{width}, {f}");
        }
    }
}
