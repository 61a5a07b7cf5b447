//! From areal densities to the signal of a pixel.

mod gradient;

use crate::allocation::reserved;
use crate::error::Result;
use crate::physics::{MassAttenuation, Spectrum};

/// What this module allocates.
const WHAT: &str = "a spectral model";

/// The signal behind a path, given the areal density `A_m` (g/cm²) of each material on it:
/// `I = I0 · Σ_k w_k exp(−τ_k)`, with `τ_k = Σ_m (μ/ρ)_m(E_k) · A_m`.
///
/// Bins without weight are dropped, so k counts the bins that can matter. All arithmetic is float64. Areal densities
/// are at least 0; an infinite one is opaque; NaN gives NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralModel {
    i0: f64,
    /// keV.
    energies: Vec<f64>,
    weights: Vec<f64>,
    /// Rounded sum of `weights`: dividing by it makes an empty path exact.
    weight_sum: f64,
    /// `coefficients[m*bins + k]`, cm²/g.
    coefficients: Vec<f64>,
    least: Vec<f64>,
}

impl SpectralModel {
    /// A model of `spectrum`, already folded with the detector's response, and the materials of `attenuation`.
    ///
    /// # Errors
    /// `InvalidArgument` when their energies differ.
    pub fn new(spectrum: &Spectrum, attenuation: &MassAttenuation) -> Result<Self> {
        attenuation.grid().check_same("mass attenuation", spectrum.grid())?;
        let i0 = spectrum.total();
        let (count, materials) = (spectrum.grid().count(), attenuation.names().len());
        let [mut energies, mut weights] = [reserved(count, WHAT)?, reserved(count, WHAT)?];
        let mut kept = reserved(count, WHAT)?;
        // A weight that underflows when normalised is no weight either.
        for (k, weight) in spectrum.weights().iter().map(|w| w / i0).enumerate().filter(|(_, w)| *w > 0.0) {
            kept.push(k);
            weights.push(weight);
            energies.push(spectrum.grid().energy(k));
        }
        let mut coefficients: Vec<f64> = reserved(kept.len() * materials, WHAT)?;
        let rows = (0..materials).map(|m| attenuation.coefficients(m));
        coefficients.extend(rows.flat_map(|row| kept.iter().map(|&k: &usize| row[k])));
        let least = least(&coefficients, kept.len());
        Ok(Self {
            i0,
            energies,
            weight_sum: compensated(weights.iter().copied()),
            weights,
            coefficients,
            least,
        })
    }

    /// The sum over `bins` with weights of their own. Stopping early still keeps its promise for the sum over all bins.
    pub(super) fn of_bins(&self, bins: &[usize], weights: Vec<f64>) -> Self {
        let rows = (0..self.materials()).map(|m| self.coefficients(m));
        let coefficients = rows.flat_map(|row| bins.iter().map(|&k| row[k])).collect();
        let energies = bins.iter().map(|&k| self.energies[k]).collect();
        let weight_sum = compensated(weights.iter().copied());
        Self { i0: self.i0, energies, weights, weight_sum, coefficients, least: self.least.clone() }
    }

    /// The same bins with other materials: `coefficients[m*bins + k]`, cm²/g.
    pub(super) fn with_coefficients(&self, coefficients: Vec<f64>) -> Self {
        let least = least(&coefficients, self.bins());
        Self { coefficients, least, ..self.clone() }
    }

    /// Number of energy bins with weight.
    pub fn bins(&self) -> usize {
        self.weights.len()
    }

    /// Number of materials.
    pub fn materials(&self) -> usize {
        self.least.len()
    }

    /// Signal of a ray that meets nothing: the sum of the spectrum's weights.
    pub fn i0(&self) -> f64 {
        self.i0
    }

    /// Energy of each bin, keV.
    pub fn energies(&self) -> &[f64] {
        &self.energies
    }

    /// Relative weight `w_k` of each bin; they sum to 1.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// `(μ/ρ)_m(E_k)` of a material (an index below `materials()`), one per bin, cm²/g.
    pub fn coefficients(&self, material: usize) -> &[f64] {
        &self.coefficients[material * self.bins()..(material + 1) * self.bins()]
    }

    /// The smallest coefficient of a material over the bins, cm²/g. What passes a path is at most
    /// `I0 · exp(−Σ_m least_m · A_m)`, whatever the spectrum: the bound for stopping early.
    pub fn least_attenuation(&self, material: usize) -> f64 {
        self.least[material]
    }

    /// Signal I, in the units of the spectrum's weights, behind one areal density (g/cm²) per material.
    ///
    /// Exactly I0 when all are 0; 0 when the sum underflows.
    ///
    /// # Panics
    /// When there is not one areal density per material.
    pub fn intensity(&self, areal_density: &[f64]) -> f64 {
        if self.is_opaque(areal_density) {
            return 0.0;
        }
        let passing =
            compensated((0..self.bins()).map(|k| self.weights[k] * (-self.tau(k, areal_density)).exp()));
        self.i0 * (passing / self.weight_sum)
    }

    /// Line integral p = −ln(I/I0) behind one areal density (g/cm²) per material.
    ///
    /// Exactly 0 when all are 0; finite also where the intensity underflows; +∞ only when τ is.
    ///
    /// # Panics
    /// When there is not one areal density per material.
    pub fn line_integral(&self, areal_density: &[f64]) -> f64 {
        if self.is_opaque(areal_density) {
            return f64::INFINITY;
        }
        let taus = (0..self.bins()).map(|k| self.tau(k, areal_density));
        let least = taus.clone().fold(f64::INFINITY, f64::min);
        // `min` passes over NaN, so each τ is infinite or NaN here, and one says it for all.
        if least.is_infinite() {
            return self.tau(0, areal_density);
        }
        // Relative to the least attenuated bin, whose term is its weight: the sum cannot underflow.
        let passing = compensated(taus.zip(&self.weights).map(|(tau, w)| w * (least - tau).exp()));
        least - (passing / self.weight_sum).ln()
    }

    /// Whether a material is infinitely dense. Asked first, because ∞ times a coefficient of 0 is NaN.
    fn is_opaque(&self, areal_density: &[f64]) -> bool {
        assert_eq!(areal_density.len(), self.materials(), "one areal density per material");
        areal_density.contains(&f64::INFINITY)
    }

    /// Optical depth `τ_k`.
    fn tau(&self, k: usize, areal_density: &[f64]) -> f64 {
        areal_density.iter().enumerate().map(|(m, a)| self.coefficients[m * self.bins() + k] * a).sum()
    }
}

/// The smallest number of each row.
fn least(values: &[f64], columns: usize) -> Vec<f64> {
    values.chunks(columns).map(|row| row.iter().copied().fold(f64::INFINITY, f64::min)).collect()
}

/// The sum of numbers that are not negative, with the rounding of every addition made good (Kahan, CACM 8(1), 40, 1965):
/// thousands of equal terms are rounded the same way.
fn compensated(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0, 0.0);
    for value in values {
        let term: f64 = value - lost;
        let next = sum + term;
        lost = (next - sum) - term;
        sum = next;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::{DetectorResponse, EnergyGrid};

    const GRID: EnergyGrid = EnergyGrid::SPECIFICATION;

    fn model_of(spectrum: &Spectrum, materials: &[&str]) -> SpectralModel {
        let attenuation = MassAttenuation::named(materials, *spectrum.grid()).unwrap();
        SpectralModel::new(spectrum, &attenuation).unwrap()
    }

    fn model(name: &str, materials: &[&str]) -> SpectralModel {
        model_of(&Spectrum::named(name, GRID).unwrap(), materials)
    }

    fn assert_close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() <= relative, "{value:e}, expected {expected:e}");
    }

    #[test]
    fn an_empty_path_is_exact() {
        for response in DetectorResponse::names() {
            let detector = DetectorResponse::named(response, GRID).unwrap();
            for name in Spectrum::names() {
                let spectrum = Spectrum::named(name, GRID).unwrap().folded(&detector).unwrap();
                let model = model_of(&spectrum, &MassAttenuation::SPECIFICATION);
                assert_eq!(model.intensity(&[0.0; 4]), spectrum.total());
                assert_eq!(model.line_integral(&[0.0; 4]), 0.0);
                assert_close(model.weights().iter().sum(), 1.0, 1e-14);
            }
        }
    }

    #[test]
    fn one_energy_obeys_beer_and_lambert() {
        for kev in [15.0, 60.0, 150.0] {
            let model = model_of(&Spectrum::monoenergetic(kev).unwrap(), &["water", "bone_cortical"]);
            let [water, bone] = [0, 1].map(|m| model.coefficients(m)[0]);
            for (a, b) in [(1e-9, 0.0), (20.0, 0.0), (3.0, 2.0), (4000.0, 100.0)] {
                assert_close(model.line_integral(&[a, b]), a * water + b * bone, 1e-15);
            }
            assert_close(model.intensity(&[3.0, 2.0]), (-3.0 * water - 2.0 * bone).exp(), 1e-15);
        }
    }

    #[test]
    fn all_weight_in_the_last_bin_is_one_energy() {
        let mut weights = vec![0.0; 136];
        weights[135] = 1e-30;
        let last = model_of(&Spectrum::new("last", GRID, weights).unwrap(), &["water"]);
        let mono = model_of(&Spectrum::monoenergetic(150.0).unwrap(), &["water"]);
        assert_eq!(last.bins(), 1);
        assert_eq!(last.line_integral(&[20.0]), mono.line_integral(&[20.0]));
        assert_eq!(last.least_attenuation(0), mono.coefficients(0)[0]);
    }

    #[test]
    fn line_integrals_do_not_depend_on_the_scale_of_the_weights() {
        let spectrum = Spectrum::named(Spectrum::DEFAULT, GRID).unwrap();
        let path = [0.02, 3.0, 21.2, 5.0];
        let line_integral = |scale: f64| {
            let weights = spectrum.weights().iter().map(|w| w * scale).collect();
            let scaled = Spectrum::new("scaled", GRID, weights).unwrap();
            model_of(&scaled, &MassAttenuation::SPECIFICATION).line_integral(&path)
        };
        let p = line_integral(1.0);
        for exponent in [-300, -20, 1, 40, 500] {
            assert_eq!(line_integral(2f64.powi(exponent)), p, "2^{exponent}");
        }
        for scale in [1e-30, 1e30] {
            assert_close(line_integral(scale), p, 1e-14);
        }
    }

    #[test]
    fn agrees_with_a_correctly_rounded_sum() {
        // Sums of the same tables with exactly rounded addition, written independently of this code.
        let path = [0.05, 2.1, 21.2, 3.84];
        for (name, response, path, expected) in [
            ("W120_2p5Al", "ideal", path, 6.057_312_068_225_677),
            ("W120_2p5Al", "bottom_energy", path, 5.526_118_922_494_724_5),
            ("W80_2p5Al", "top_counting", path, 7.349_952_504_829_788),
            ("W120_2p5Al", "ideal", [0.0, 0.0, 1e-3, 0.0], 0.000_259_085_742_871_828_4),
            ("W120_2p5Al", "ideal", [0.0, 0.0, 4000.0, 0.0], 649.319_608_930_378_8),
        ] {
            let detector = DetectorResponse::named(response, GRID).unwrap();
            let spectrum = Spectrum::named(name, GRID).unwrap().folded(&detector).unwrap();
            let p = model_of(&spectrum, &MassAttenuation::SPECIFICATION).line_integral(&path);
            assert!(
                (p - expected).abs() <= 1e-13 * expected + 1e-15,
                "{name} {response}: {p}, not {expected}"
            );
        }
    }

    #[test]
    fn intensity_and_line_integral_say_the_same() {
        let model = model("W100_2p5Al", &MassAttenuation::SPECIFICATION);
        for depth in [1e-6, 0.1, 1.0, 10.0, 100.0, 1000.0] {
            let path = [0.01, 0.1, depth, 0.3 * depth];
            assert_close(model.intensity(&path), model.i0() * (-model.line_integral(&path)).exp(), 1e-12);
        }
    }

    #[test]
    fn an_opaque_path_has_no_signal_but_a_line_integral() {
        let model = model(Spectrum::DEFAULT, &["tungsten", "bone_cortical"]);
        let path = [1000.0, 0.0];
        let least = 1000.0 * model.least_attenuation(0);
        assert!(least > 1000.0);
        assert_eq!(model.intensity(&path), 0.0);
        let p = model.line_integral(&path);
        // Between the least attenuated bin with all of the weight and with its own.
        let smallest = model.weights().iter().copied().fold(1.0, f64::min);
        assert!(p > least && p <= least - smallest.ln(), "{p}");
    }

    #[test]
    fn infinite_and_overflowing_paths_are_dark() {
        // A material without attenuation must not turn infinity into NaN.
        let values = [vec![0.0; 136], vec![50.0; 136]].concat();
        let table = MassAttenuation::new(GRID, vec!["nothing".into(), "lead".into()], values).unwrap();
        let spectrum = Spectrum::named(Spectrum::DEFAULT, GRID).unwrap();
        let model = SpectralModel::new(&spectrum, &table).unwrap();
        for path in [[f64::INFINITY, 0.0], [0.0, f64::INFINITY], [f64::INFINITY; 2], [0.0, 1e308]] {
            assert_eq!(model.intensity(&path), 0.0, "{path:?}");
            assert_eq!(model.line_integral(&path), f64::INFINITY, "{path:?}");
        }
        assert_eq!(model.line_integral(&[1e300, 0.0]), 0.0);
        assert!(model.intensity(&[0.0, f64::NAN]).is_nan());
        assert!(model.line_integral(&[0.0, f64::NAN]).is_nan());
    }

    #[test]
    fn a_bin_of_almost_no_weight_counts_where_it_alone_passes() {
        let grid = EnergyGrid::new(20.0, 130.0, 2).unwrap();
        let model = model_of(&Spectrum::new("two lines", grid, vec![1.0, 1e-25]).unwrap(), &["water"]);
        let [soft, hard] = [0, 1].map(|k| model.coefficients(0)[k]);
        assert_close(model.line_integral(&[1.0]), soft, 1e-15);
        assert_close(model.line_integral(&[1000.0]), 1000.0 * hard + 25.0 * 10f64.ln(), 1e-14);
    }

    #[test]
    fn beams_harden() {
        for name in Spectrum::names() {
            let model = model(name, &["aluminium"]);
            // cm of aluminium after which `part` of the photons is left.
            let layer = |part: f64| {
                let (mut thin, mut thick) = (0.0, 20.0);
                for _ in 0..60 {
                    let middle = 0.5 * (thin + thick);
                    let less = model.intensity(&[2.699 * middle]) < part * model.i0();
                    *if less { &mut thick } else { &mut thin } = middle;
                }
                thin
            };
            let (first, second) = (layer(0.5), layer(0.25) - layer(0.5));
            assert!(second > 1.1 * first, "{name}: half-value layers {first} and {second} cm");
        }
    }

    #[test]
    fn half_value_layers_exceed_those_in_air_kerma() {
        // Air kerma weights the soft photons more, so its published half-value layer (mm Al) is the thinner one:
        // more than half of the photons pass it, and fewer than at the next higher voltage.
        for (name, next, mm) in [
            ("W60_2p5Al", "W80_2p5Al", 2.0816),
            ("W80_2p5Al", "W100_2p5Al", 2.7338),
            ("W100_2p5Al", "W120_2p5Al", 3.4584),
        ] {
            let passing = |name: &str| {
                let model = model(name, &["aluminium"]);
                model.intensity(&[0.1 * mm * 2.699]) / model.i0()
            };
            assert!(passing(name) > 0.5 && passing(name) < 0.65, "{name}: {}", passing(name));
            assert!(passing(next) > passing(name));
        }
    }

    #[test]
    fn the_copper_filter_is_copper() {
        // The tube model's own spectrum behind 0.1 mm Cu, and ours through the same copper.
        let bare = model("W120_2p5Al", &["copper", "water"]);
        let filtered = model("W120_2p5Al_0p1Cu", &["copper", "water"]);
        let copper = 8.96 * 0.01;
        for water in [5.0, 20.0, 40.0] {
            let behind = bare.line_integral(&[copper, water]) - bare.line_integral(&[copper, 0.0]);
            assert_close(filtered.line_integral(&[0.0, water]), behind, 1e-3);
        }
    }

    #[test]
    fn the_early_exit_bound_holds_for_every_material_and_tube() {
        for name in Spectrum::names() {
            let model = model(name, &["air", "soft_tissue", "titanium", "steel_316l", "tungsten"]);
            for m in 0..model.materials() {
                let mut path = [0.0; 5];
                path[m] = 15.0 / model.least_attenuation(m);
                assert!(model.line_integral(&path) >= 15.0, "{name}, material {m}");
            }
        }
        // Behind the K edge 70 keV is among the strongest attenuated energies, and 69 keV passes far better.
        let grid = EnergyGrid::new(69.0, 1.0, 3).unwrap();
        let flat = Spectrum::new("flat", grid, vec![1.0; 3]).unwrap();
        let model = model_of(&flat, &["tungsten"]);
        assert_eq!(model.least_attenuation(0), model.coefficients(0)[0]);
    }

    #[test]
    fn energies_must_agree() {
        let attenuation = MassAttenuation::named(&["water"], GRID).unwrap();
        let message = SpectralModel::new(&Spectrum::monoenergetic(60.0).unwrap(), &attenuation).unwrap_err();
        assert!(message.to_string().contains("mass attenuation is on 136 energies"), "{message}");
    }

    #[test]
    #[should_panic(expected = "one areal density per material")]
    fn a_missing_areal_density_is_not_zero() {
        model(Spectrum::DEFAULT, &["water", "air"]).intensity(&[1.0]);
    }
}
