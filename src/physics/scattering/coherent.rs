//! Scattering by whole atoms.

use std::f64::consts::PI;

use super::{AVOGADRO, SQUARE_ELECTRON_RADIUS};

/// Coherent (Rayleigh) scattering: Thomson's `(1 + cos²θ)/2` times the squared form factor `Z² / (1 + (x/x0)²)²` with
/// x = sin(θ/2)/λ, that of electrons as dense as `exp(−r/R)/r` (the exponentially screened atom of Wentzel, Z Phys 40,
/// 590, 1927). The energy of the photon stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coherent {
    /// (x/x0)² of backward scattering, where x = 1/λ.
    peak: f64,
}

impl Coherent {
    /// The one whose form factor leaves `part` in 0 … 1, exclusive, of what point charges would scatter; a narrower peak
    /// than 1e8 is not looked for.
    pub(crate) fn of_part(part: f64) -> Self {
        let (mut low, mut high) = (1e-4_f64.ln(), 1e8_f64.ln());
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            // The part falls as the peak narrows.
            if (Self { peak: middle.exp() }).solid_angle() > part * 8.0 / 3.0 * PI {
                low = middle;
            } else {
                high = middle;
            }
        }
        Self { peak: (0.5 * (low + high)).exp() }
    }

    /// The one with that (x/x0)² of backward scattering.
    pub(crate) fn of_peak(peak: f64) -> Self {
        Self { peak }
    }

    /// (x/x0)² of backward scattering.
    pub(crate) fn peak(self) -> f64 {
        self.peak
    }

    /// Mass coefficient in cm²/g of point charges: `8π/3 · r_e² · N_A · Σ w Z²/A` over mass fractions w, atomic numbers Z
    /// and molar masses A, g/mol.
    pub(crate) fn of_point_charges(composition: impl Iterator<Item = (u8, f64, f64)>) -> f64 {
        let charges: f64 =
            composition.map(|(z, fraction, molar)| fraction * f64::from(z).powi(2) / molar).sum();
        8.0 / 3.0 * PI * SQUARE_ELECTRON_RADIUS * AVOGADRO * charges
    }

    /// `∫ (1 + cos²θ)/2 · F²/Z² dΩ`: with t = (1 − cosθ)/2 and b the peak, `4π ∫ (1 − 2t + 2t²)/(1 + bt)² dt`.
    fn solid_angle(self) -> f64 {
        let b = self.peak;
        let integral = if b < 0.05 {
            // The closed form loses its digits: b⁰ … b³ of the series Σ (n+1)(−bt)ⁿ.
            let moment = |n: f64| 1.0 / (n + 1.0) - 2.0 / (n + 2.0) + 2.0 / (n + 3.0);
            (0..12).rev().fold(0.0, |sum, n| moment(f64::from(n)) * f64::from(n + 1) * (-b).powi(n) + sum)
        } else {
            let (all, log) = (1.0 + b, b.ln_1p());
            1.0 / all - 2.0 * (log - b / all) / (b * b) + 2.0 * (all - 2.0 * log - 1.0 / all) / b.powi(3)
        };
        4.0 * PI * integral
    }

    #[cfg(test)]
    fn shape(self, cosine: f64) -> f64 {
        0.5 * (1.0 + cosine * cosine) / (1.0 + self.peak * 0.5 * (1.0 - cosine)).powi(2)
    }

    /// Probability per steradian of the direction with that cosine.
    #[cfg(test)]
    pub(crate) fn density(self, cosine: f64) -> f64 {
        self.shape(cosine) / self.solid_angle()
    }

    /// The cosine of a random scattering angle, from uniform numbers in [0, 1): the form factor by inversion, Thomson's
    /// factor by rejection.
    pub(crate) fn sample(self, mut uniform: impl FnMut() -> f64) -> f64 {
        loop {
            let part = uniform();
            // ∫₀ᵗ dt/(1+bt)² = t/(1+bt) is the part of its value at 1.
            let t = part / (1.0 + self.peak * (1.0 - part));
            let cosine = 1.0 - 2.0 * t;
            if uniform() < 0.5 * (1.0 + cosine * cosine) {
                return cosine;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{chi_square, over_directions, uniform};
    use super::*;

    const PEAKS: [f64; 5] = [0.01, 0.6, 20.0, 300.0, 5000.0];

    #[test]
    fn the_density_integrates_to_one() {
        for peak in PEAKS {
            let sum = over_directions(|cosine| Coherent::of_peak(peak).density(cosine));
            assert!((sum - 1.0).abs() < 1e-7, "{peak}: {sum}");
        }
    }

    #[test]
    fn the_peak_is_found_from_what_is_left() {
        for peak in PEAKS {
            let part = Coherent::of_peak(peak).solid_angle() / (8.0 / 3.0 * PI);
            assert!((Coherent::of_part(part).peak() / peak - 1.0).abs() < 1e-6, "{peak}: {part}");
        }
    }

    #[test]
    fn angles_are_as_dense_as_they_should_be() {
        for (seed, peak) in (20..).zip(PEAKS) {
            let (photon, mut random) = (Coherent::of_peak(peak), uniform(seed));
            let chi = chi_square(|| photon.sample(&mut random), |cosine| photon.density(cosine));
            assert!(chi > 0.4 && chi < 1.7, "{peak}: χ² per degree {chi}");
        }
    }
}
