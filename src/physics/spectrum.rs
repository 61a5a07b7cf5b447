//! Tube spectra.

use crate::error::{Error, Result};
use crate::physics::energy::WEIGHTS;
use crate::physics::tables::{SPECTRA, tabulated};
use crate::physics::{DetectorResponse, EnergyGrid};

/// Relative photons (or, once folded with a detector, relative signal) per energy bin.
///
/// Only ratios of weights matter to a line integral; the sum of the weights is the signal of a ray that meets nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    name: String,
    grid: EnergyGrid,
    weights: Vec<f64>,
}

impl Spectrum {
    /// Name of the default tube: tungsten, 120 kVp, 2.5 mm Al.
    pub const DEFAULT: &'static str = "W120_2p5Al";

    /// A spectrum of one's own: `weights[k]` is for energy k of `grid`.
    ///
    /// # Errors
    /// `InvalidArgument` unless there is one weight per energy, all are finite and at least 0 (the first that is not
    /// is named), and their sum is finite and above 0.
    pub fn new(name: impl Into<String>, grid: EnergyGrid, weights: Vec<f64>) -> Result<Self> {
        grid.check_values("spectrum", &weights, WEIGHTS)?;
        let sum: f64 = weights.iter().sum();
        if !(sum.is_finite() && sum > 0.0) {
            return Err(Error::invalid("spectrum's sum", sum, "finite, above 0"));
        }
        Ok(Self { name: name.into(), grid, weights })
    }

    /// A built-in tube spectrum at the energies of `grid`, which must be whole keV in 15 … 150.
    ///
    /// The 136 tabulated bins sum to 1. On a grid that leaves energies out, the weights are those of the energies kept.
    ///
    /// # Errors
    /// `InvalidArgument` for an unknown name, an energy that is not tabulated, or a grid without photons.
    pub fn named(name: &str, grid: EnergyGrid) -> Result<Self> {
        let photons = SPECTRA.column("spectrum", name)?;
        let all: f64 = photons.iter().sum();
        let weights = tabulated(&grid)?.into_iter().map(|k| photons[k] / all).collect();
        Self::new(name, grid, weights)
    }

    /// Names of the built-in spectra: anode, kVp, filter.
    pub fn names() -> &'static [&'static str] {
        SPECTRA.names()
    }

    /// All photons at one energy in keV.
    pub fn monoenergetic(kev: f64) -> Result<Self> {
        Self::new(format!("{kev} keV"), EnergyGrid::single(kev)?, vec![1.0])
    }

    /// This spectrum as a detector with `response` weights it: the product, energy by energy.
    ///
    /// # Errors
    /// `InvalidArgument` when the energies differ or the detector sees none of the photons.
    pub fn folded(&self, response: &DetectorResponse) -> Result<Self> {
        response.grid().check_same("detector response", &self.grid)?;
        let weights = self.weights.iter().zip(response.factors()).map(|(w, f)| w * f).collect();
        Self::new(format!("{} × {}", self.name, response.name()), self.grid, weights)
            .map_err(|error| error.called("spectrum", "detector_response × spectrum"))
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The energies.
    pub fn grid(&self) -> &EnergyGrid {
        &self.grid
    }

    /// One weight per energy.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Sum of the weights: the signal without an object.
    pub fn total(&self) -> f64 {
        self.weights.iter().sum()
    }

    /// Mean energy in keV, weighted by this spectrum.
    pub fn mean_kev(&self) -> f64 {
        let total = self.total();
        // Divided first: weights near the largest float would overflow when multiplied.
        self.weights.iter().zip(self.grid.energies()).map(|(w, e)| w / total * e).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: EnergyGrid = EnergyGrid::SPECIFICATION;

    #[test]
    fn built_in_spectra_sum_to_one_and_end_at_their_tube_voltage() {
        for name in Spectrum::names() {
            let spectrum = Spectrum::named(name, GRID).unwrap();
            assert!((spectrum.total() - 1.0).abs() < 1e-14, "{name}");
            let kvp = name[1..].split('_').next().unwrap().parse::<f64>().unwrap();
            let above = GRID.energies().zip(spectrum.weights()).filter(|(e, w)| *e > kvp && **w > 0.0);
            assert_eq!(above.count(), 0, "{name} has photons above {kvp} keV");
        }
        assert!(Spectrum::names().contains(&Spectrum::DEFAULT));
    }

    #[test]
    fn mean_energies_are_those_of_the_tube_model() {
        // Computed by the tube model on 0.1 keV bins, before binning to 1 keV.
        for (name, mean) in [("W60_2p5Al", 35.954), ("W120_2p5Al", 54.433), ("W120_CT_3Al_0p9Ti", 63.598)] {
            let difference = Spectrum::named(name, GRID).unwrap().mean_kev() - mean;
            assert!(difference.abs() < 1e-3, "{name}: {difference} keV");
        }
    }

    #[test]
    fn tungsten_lines_stand_out() {
        let spectrum = Spectrum::named("W100_2p5Al", GRID).unwrap();
        let at = |kev| spectrum.weights()[GRID.index_of(kev).unwrap()];
        // Kα1 59.3 keV, Kα2 58.0 keV, Kβ1 67.2 keV.
        for line in [58.0, 59.0, 67.0] {
            assert!(at(line) > 1.3 * at(line - 3.0) && at(line) > 1.3 * at(line + 4.0), "{line} keV");
        }
    }

    #[test]
    fn a_part_of_the_grid_keeps_the_weights_of_its_energies() {
        let whole = Spectrum::named(Spectrum::DEFAULT, GRID).unwrap();
        let part = Spectrum::named(Spectrum::DEFAULT, EnergyGrid::new(40.0, 5.0, 9).unwrap()).unwrap();
        for (energy, weight) in part.grid().energies().zip(part.weights()) {
            assert_eq!(*weight, whole.weights()[GRID.index_of(energy).unwrap()]);
        }
    }

    #[test]
    fn refusals_name_what_is_wrong() {
        let spoilt = |k: usize, value: f64| {
            let mut weights = vec![1.0; 136];
            weights[k] = value;
            Spectrum::new("own", GRID, weights).unwrap_err().to_string()
        };
        assert!(spoilt(12, f64::NAN).starts_with("spectrum[12] is NaN"));
        assert!(spoilt(0, -1e-30).starts_with("spectrum[0] is -"));
        assert!(spoilt(135, f64::INFINITY).starts_with("spectrum[135] is inf"));
        for (weights, reason) in
            [(vec![0.0; 136], "sum"), (vec![1e307; 136], "sum"), (vec![1.0; 135], "135"), (vec![], "136")]
        {
            let message = Spectrum::new("own", GRID, weights).unwrap_err().to_string();
            assert!(message.contains(reason), "{message}");
        }
        let message = Spectrum::named("W120", GRID).unwrap_err().to_string();
        assert!(message.contains("W120_2p5Al_0p1Cu"), "the valid names are missing: {message}");
        // 60 kVp has no photon from 100 keV on.
        assert!(Spectrum::named("W60_2p5Al", EnergyGrid::new(100.0, 1.0, 10).unwrap()).is_err());
    }

    #[test]
    fn a_single_bin_at_the_last_energy_is_a_spectrum() {
        let mut weights = vec![0.0; 136];
        weights[135] = 1e-30;
        let spectrum = Spectrum::new("last", GRID, weights).unwrap();
        assert_eq!((spectrum.mean_kev(), spectrum.total()), (150.0, 1e-30));
    }

    #[test]
    fn folding_multiplies_and_needs_the_same_energies() {
        let spectrum = Spectrum::named(Spectrum::DEFAULT, GRID).unwrap();
        assert_eq!(spectrum.folded(&DetectorResponse::ideal(GRID)).unwrap().weights(), spectrum.weights());
        let step = GRID.energies().map(|e| if e < 80.0 { 0.0 } else { 2.0 }).collect();
        let folded = spectrum.folded(&DetectorResponse::new("step", GRID, step).unwrap()).unwrap();
        assert_eq!(folded.weights()[64], 0.0);
        assert_eq!(folded.weights()[65], 2.0 * spectrum.weights()[65]);

        let blind = DetectorResponse::new("blind", GRID, vec![0.0; 136]).unwrap();
        let message = spectrum.folded(&blind).unwrap_err().to_string();
        assert!(message.starts_with("detector_response × spectrum's sum is 0"), "{message}");
        let elsewhere = DetectorResponse::ideal(EnergyGrid::new(15.0, 1.0, 135).unwrap());
        assert!(spectrum.folded(&elsewhere).unwrap_err().to_string().contains("detector response"));
    }
}
