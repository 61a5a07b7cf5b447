//! Scattering by free electrons.

#[cfg(test)]
use std::f64::consts::PI;

use super::ELECTRON_REST_KEV;
#[cfg(test)]
use super::SQUARE_ELECTRON_RADIUS;

/// Incoherent (Compton) scattering of photons of one energy by free electrons at rest (Klein & Nishina, Z Phys 52, 853,
/// 1929).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Incoherent {
    kev: f64,
    /// Photon energy in units of the electron's rest energy.
    alpha: f64,
}

impl Incoherent {
    /// Of photons of `kev`.
    pub(crate) fn new(kev: f64) -> Self {
        Self { kev, alpha: kev / ELECTRON_REST_KEV }
    }

    /// Energy in keV of a photon scattered through the angle of that cosine (Compton, Phys Rev 21, 483, 1923).
    pub(crate) fn scattered_kev(&self, cosine: f64) -> f64 {
        self.kev * self.ratio(cosine)
    }

    fn ratio(&self, cosine: f64) -> f64 {
        1.0 / (1.0 + self.alpha * (1.0 - cosine))
    }

    /// Differential cross section in units of `r_e²`/2 per steradian; at most 2, forwards.
    fn shape(&self, cosine: f64) -> f64 {
        let ratio = self.ratio(cosine);
        ratio * ratio * (ratio + 1.0 / ratio - (1.0 - cosine * cosine))
    }

    /// Cross section of one electron, cm² (Klein & Nishina; Attix, Introduction to Radiological Physics, 1986, eq. 7.15).
    #[cfg(test)]
    pub(crate) fn cross_section(&self) -> f64 {
        let a = self.alpha;
        let (twice, log) = (1.0 + 2.0 * a, (2.0 * a).ln_1p());
        let head = (1.0 + a) / (a * a) * (2.0 * (1.0 + a) / twice - log / a);
        2.0 * PI * SQUARE_ELECTRON_RADIUS * (head + log / (2.0 * a) - (1.0 + 3.0 * a) / (twice * twice))
    }

    /// Probability per steradian of the direction with that cosine.
    #[cfg(test)]
    pub(crate) fn density(&self, cosine: f64) -> f64 {
        0.5 * SQUARE_ELECTRON_RADIUS * self.shape(cosine) / self.cross_section()
    }

    /// The cosine of a random scattering angle, from uniform numbers in [0, 1): von Neumann's rejection, about two of
    /// three tries succeed.
    pub(crate) fn sample(&self, mut uniform: impl FnMut() -> f64) -> f64 {
        loop {
            let cosine = 2.0 * uniform() - 1.0;
            if 2.0 * uniform() < self.shape(cosine) {
                return cosine;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{chi_square, over_directions, uniform};
    use super::*;

    const ENERGIES: [f64; 4] = [15.0, 42.5, 80.0, 150.0];

    #[test]
    fn the_density_integrates_to_one() {
        for kev in ENERGIES {
            let sum = over_directions(|cosine| Incoherent::new(kev).density(cosine));
            assert!((sum - 1.0).abs() < 1e-10, "{kev} keV: {sum}");
        }
    }

    #[test]
    fn slow_photons_see_thomsons_cross_section() {
        // 0.665 245 8705 barn; the first correction is −2α.
        let thomson = 8.0 / 3.0 * PI * SQUARE_ELECTRON_RADIUS;
        assert!((thomson / 0.665_245_870_5e-24 - 1.0).abs() < 1e-8);
        let slow = Incoherent::new(0.5);
        assert!((slow.cross_section() / thomson - (1.0 - 2.0 * slow.alpha)).abs() < 1e-5);
        // As tabulated by Hubbell et al., J Phys Chem Ref Data 4, 471 (1975).
        assert!((Incoherent::new(100.0).cross_section() / 0.4927e-24 - 1.0).abs() < 2e-4);
    }

    #[test]
    fn angles_are_as_dense_as_they_should_be() {
        for (seed, kev) in (0..).zip(ENERGIES) {
            let (photon, mut random) = (Incoherent::new(kev), uniform(seed));
            let chi = chi_square(|| photon.sample(&mut random), |cosine| photon.density(cosine));
            // 40 degrees of freedom: the standard deviation is 0.22.
            assert!(chi > 0.4 && chi < 1.7, "{kev} keV: χ² per degree {chi}");
        }
    }

    /// Closed form of the mean part of the energy that the photon keeps: `σ_s/σ`, with the energy-scattering cross section
    /// of Evans, The Atomic Nucleus (1955), ch. 23, eq. 5.13.
    #[test]
    fn the_mean_energy_is_that_of_the_closed_form() {
        for (seed, kev) in (10..).zip(ENERGIES) {
            let (photon, mut random) = (Incoherent::new(kev), uniform(seed));
            let a = photon.alpha;
            let twice = 1.0 + 2.0 * a;
            let scattered = PI
                * SQUARE_ELECTRON_RADIUS
                * ((2.0 * a).ln_1p() / a.powi(3)
                    + 2.0 * (1.0 + a) * (2.0 * a * a - 2.0 * a - 1.0) / (a * a * twice * twice)
                    + 8.0 * a * a / (3.0 * twice.powi(3)));
            let expected = scattered / photon.cross_section();
            let integral = over_directions(|cosine| photon.density(cosine) * photon.ratio(cosine));
            assert!((integral / expected - 1.0).abs() < 1e-8, "{kev} keV: {integral} for {expected}");
            let draws = 100_000;
            let sum: f64 = (0..draws).map(|_| photon.scattered_kev(photon.sample(&mut random)) / kev).sum();
            assert!((sum / f64::from(draws) - expected).abs() < 2e-3 * (1.0 - expected) + 3e-4, "{kev} keV");
        }
    }
}
