//! How the line integral changes with the areal densities.

use crate::physics::SpectralModel;

impl SpectralModel {
    /// The line integral p behind one areal density (g/cm²) per material, to the last bit that of
    /// [`SpectralModel::line_integral`], and `∂p/∂A_m` into `gradient`, cm²/g.
    ///
    /// With `p = −ln Σ_k w_k exp(−τ_k)` and `τ_k = Σ_m (μ/ρ)_m(E_k) A_m`,
    /// `∂p/∂A_m = Σ_k (μ/ρ)_m(E_k) w_k exp(−τ_k) / Σ_k w_k exp(−τ_k)`: the mean coefficient of what passes. It is taken
    /// relative to the least attenuated energy and stays finite where the intensity underflows. The intensity's derivative
    /// is `∂I/∂A_m = −I ∂p/∂A_m`. Behind an infinite depth it is the least coefficient.
    ///
    /// # Panics
    /// When there is not one areal density, or not one entry of `gradient`, per material.
    pub fn gradient(&self, areal_density: &[f64], gradient: &mut [f64]) -> f64 {
        assert_eq!(gradient.len(), self.materials(), "one derivative per material");
        gradient.copy_from_slice(&self.least);
        if self.is_opaque(areal_density) {
            return f64::INFINITY;
        }
        let taus = || (0..self.bins()).map(|k| self.tau(k, areal_density));
        let least = taus().fold(f64::INFINITY, f64::min);
        // `min` passes over NaN, so each τ is infinite or NaN here, and one says it for all.
        if least.is_infinite() {
            return self.tau(0, areal_density);
        }
        gradient.fill(0.0);
        // Compensated as the line integral's own sum is.
        let (mut passing, mut lost) = (0.0, 0.0);
        for (k, (tau, weight)) in taus().zip(&self.weights).enumerate() {
            let part = weight * (least - tau).exp();
            let term: f64 = part - lost;
            let next = passing + term;
            lost = (next - passing) - term;
            passing = next;
            for (m, sum) in gradient.iter_mut().enumerate() {
                *sum += part * self.coefficients[m * self.bins() + k];
            }
        }
        for sum in gradient {
            *sum /= passing;
        }
        least - (passing / self.weight_sum).ln()
    }
}

#[cfg(test)]
mod tests {
    use crate::physics::{DetectorResponse, EnergyGrid, MassAttenuation, SpectralModel, Spectrum};

    fn model() -> SpectralModel {
        let grid = EnergyGrid::SPECIFICATION;
        let detector = DetectorResponse::named("bottom_energy", grid).expect("known");
        let spectrum =
            Spectrum::named("W120_2p5Al", grid).expect("known").folded(&detector).expect("one grid");
        let materials = MassAttenuation::named(&MassAttenuation::SPECIFICATION, grid).expect("known");
        SpectralModel::new(&spectrum, &materials).expect("one grid")
    }

    #[test]
    fn it_is_the_difference_of_line_integrals() {
        let model = model();
        for path in [[0.0; 4], [0.02, 3.0, 21.2, 5.0], [0.0, 0.0, 300.0, 80.0]] {
            let mut gradient = [0.0; 4];
            assert_eq!(model.gradient(&path, &mut gradient), model.line_integral(&path));
            for (m, derivative) in gradient.into_iter().enumerate() {
                let h = 1e-4 * (1.0 + path[m]);
                let moved = |by: f64| {
                    let mut moved = path;
                    moved[m] += by;
                    model.line_integral(&moved)
                };
                // One-sided and of third order: areal densities are not negative.
                let ahead = [0.0, h, 2.0 * h, 3.0 * h].map(moved);
                let difference =
                    (-11.0 * ahead[0] + 18.0 * ahead[1] - 9.0 * ahead[2] + 2.0 * ahead[3]) / (6.0 * h);
                assert!(
                    (difference / derivative - 1.0).abs() < 1e-8,
                    "{path:?}, {m}: {difference} {derivative}"
                );
            }
        }
    }

    #[test]
    fn it_is_finite_behind_paths_that_nothing_passes() {
        let model = model();
        for depth in [1e7, f64::MAX, f64::INFINITY] {
            let path = [0.0, 0.0, depth, 0.0];
            let mut gradient = [f64::NAN; 4];
            model.gradient(&path, &mut gradient);
            assert_eq!(model.intensity(&path), 0.0);
            // Only the least attenuated energy is left.
            let least = model.least_attenuation(2);
            assert!((gradient[2] / least - 1.0).abs() < 1e-12, "{depth:e}: {gradient:?}");
        }
    }

    #[test]
    fn one_energy_has_its_coefficients() {
        let spectrum = Spectrum::monoenergetic(60.0).expect("valid");
        let materials = MassAttenuation::named(&["water", "bone_cortical"], *spectrum.grid()).expect("known");
        let model = SpectralModel::new(&spectrum, &materials).expect("one grid");
        let mut gradient = [0.0; 2];
        model.gradient(&[3.0, 1.0], &mut gradient);
        assert_eq!(gradient, [model.coefficients(0)[0], model.coefficients(1)[0]]);
    }
}
