//! What a detector makes of a photon of energy E.

use crate::error::{Error, Result};
use crate::physics::EnergyGrid;
use crate::physics::energy::WEIGHTS;
use crate::physics::tables::{DETECTOR, unknown};

const NAMES: [&str; 6] =
    ["ideal", "transmission", "top_counting", "bottom_counting", "top_energy", "bottom_energy"];

/// One factor per energy, which multiplies a spectrum: the mean signal per photon that reaches the detector.
///
/// The built-in panel has two layers: 0.2 mm caesium iodide on 0.7 mm glass (together stack 1), a mask of 0.05 mm
/// tungsten (mask 2), 0.55 mm caesium iodide. Normal incidence, no K fluorescence, no light spread.
///
/// | name | factor | unit |
/// |---|---|---|
/// | `ideal` | 1: every photon counts once | 1 |
/// | `transmission` | `T_stack1 · T_mask2`, the specification's product taken literally | 1 |
/// | `top_counting` | `A_top`, the fraction that interacts in the top scintillator | 1 |
/// | `bottom_counting` | `T_stack1 · T_mask2 · A_bot` | 1 |
/// | `top_energy` | `ABS_top · E`, the mean energy absorbed | keV |
/// | `bottom_energy` | `T_stack1 · T_mask2 · ABS_bot · E` | keV |
///
/// `transmission` alone is no signal of either layer: it counts the photons that *arrive* at the bottom scintillator,
/// and a layer sees only what it absorbs. Of the photons of 150 keV 80 % arrive, and 13 % of those interact: against
/// `bottom_counting` it gives hard radiation too much weight. It is here for comparison with the specification.
///
/// Noise needs more than the mean: a detected photon adds its gain, factor over detection efficiency, so that the
/// signal of λ photons of one energy has mean λ·η·g and variance λ·η·g² (Swank, J Appl Phys 44, 4199, 1973). Photon counting
/// has the gain 1.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorResponse {
    name: String,
    grid: EnergyGrid,
    factors: Vec<f64>,
    /// Probability of detection, where it is known.
    efficiency: Option<Vec<f64>>,
}

impl DetectorResponse {
    /// Every photon counts once, whatever its energy.
    pub fn ideal(grid: EnergyGrid) -> Self {
        let every = vec![1.0; grid.count()];
        Self { name: "ideal".into(), grid, efficiency: Some(every.clone()), factors: every }
    }

    /// A response of one's own, of which only the mean is known: `factors[k]` is for energy k of `grid`.
    ///
    /// # Errors
    /// `InvalidArgument` unless there is one factor per energy and all are finite and at least 0.
    pub fn new(name: impl Into<String>, grid: EnergyGrid, factors: Vec<f64>) -> Result<Self> {
        grid.check_values("detector_response", &factors, WEIGHTS)?;
        Ok(Self { name: name.into(), grid, factors, efficiency: None })
    }

    /// And the probability that a photon of each energy is detected at all. Equal to the factors: photon counting.
    ///
    /// # Errors
    /// `InvalidArgument` unless there is one per energy, each is in 0 … 1, and none is 0 where the factor is not.
    pub fn with_efficiency(self, efficiency: Vec<f64>) -> Result<Self> {
        let range = (0.0..=1.0, "0 … 1, a probability");
        self.grid.check_values("detector_efficiency", &efficiency, range)?;
        let silent = |(f, e): (&f64, &f64)| *f > 0.0 && *e == 0.0;
        if let Some(k) = self.factors.iter().zip(&efficiency).position(silent) {
            let valid = format!("above 0, because detector_response[{k}] is {}", self.factors[k]);
            return Err(Error::invalid(format!("detector_efficiency[{k}]"), 0, valid));
        }
        Ok(Self { efficiency: Some(efficiency), ..self })
    }

    /// A built-in response; all but `ideal` need a `grid` of whole keV in 15 … 150.
    ///
    /// # Errors
    /// `InvalidArgument` for an unknown name or an energy that is not tabulated.
    pub fn named(name: &str, grid: EnergyGrid) -> Result<Self> {
        let product = |columns: &[&str]| -> Result<Vec<f64>> {
            let mut product = vec![1.0; grid.count()];
            for column in columns {
                let values = DETECTOR.at("detector_response", column, &grid)?;
                product.iter_mut().zip(values).for_each(|(f, v)| *f *= v);
            }
            Ok(product)
        };
        let arriving = ["T_stack1", "T_mask2_w"];
        let (counted, absorbed) = match name {
            "ideal" => return Ok(Self::ideal(grid)),
            "transmission" => (product(&["T_det_spec"])?, None),
            "top_counting" => (product(&["A_top"])?, None),
            "bottom_counting" => (product(&[arriving[0], arriving[1], "A_bot"])?, None),
            "top_energy" => (product(&["A_top"])?, Some(product(&["ABS_top"])?)),
            "bottom_energy" => (
                product(&[arriving[0], arriving[1], "A_bot"])?,
                Some(product(&[arriving[0], arriving[1], "ABS_bot"])?),
            ),
            _ => return Err(unknown("detector_response", name, &NAMES)),
        };
        let kev = |absorbed: Vec<f64>| absorbed.iter().zip(grid.energies()).map(|(f, e)| f * e).collect();
        let factors = absorbed.map_or_else(|| counted.clone(), kev);
        Self::new(name, grid, factors)?.with_efficiency(counted)
    }

    /// Names of the built-in responses.
    pub fn names() -> &'static [&'static str] {
        &NAMES
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The energies.
    pub fn grid(&self) -> &EnergyGrid {
        &self.grid
    }

    /// One factor per energy.
    pub fn factors(&self) -> &[f64] {
        &self.factors
    }

    /// Probability of detection at each energy; `None` where it is not known.
    pub fn efficiency(&self) -> Option<&[f64]> {
        self.efficiency.as_deref()
    }

    /// Whether every photon that is detected adds 1.
    pub fn counts_photons(&self) -> bool {
        self.efficiency() == Some(self.factors())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::{MassAttenuation, Spectrum};

    const GRID: EnergyGrid = EnergyGrid::SPECIFICATION;

    fn factors(name: &str) -> Vec<f64> {
        DetectorResponse::named(name, GRID).unwrap().factors
    }

    #[test]
    fn layers_attenuate_as_their_materials_do() {
        let table = MassAttenuation::named(&["csi", "glass_borosilicate", "tungsten"], GRID).unwrap();
        let expected = [factors("top_counting"), factors("transmission"), factors("bottom_counting")];
        for k in 0..GRID.count() {
            let [csi, glass, tungsten] = [0, 1, 2].map(|m| table.coefficients(m)[k]);
            // Areal densities in g/cm² from density and thickness in cm.
            let top = csi * 3.61 * 0.02;
            let arriving = (-(top + glass * 2.23 * 0.07 + tungsten * 19.3 * 0.005)).exp();
            let layers = [-(-top).exp_m1(), arriving, arriving * -(-csi * 3.61 * 0.055).exp_m1()];
            for (layer, table) in layers.iter().zip(&expected) {
                assert!((layer / table[k] - 1.0).abs() < 1e-6, "{} keV", GRID.energy(k));
            }
        }
    }

    #[test]
    fn a_photon_counts_at_most_once() {
        for name in ["ideal", "transmission", "top_counting", "bottom_counting"] {
            assert!(factors(name).iter().all(|f| (0.0..=1.0).contains(f)), "{name}");
        }
    }

    #[test]
    fn what_arrives_is_harder_than_what_interacts() {
        let tube = Spectrum::named(Spectrum::DEFAULT, GRID).unwrap();
        let [arriving, interacting] = ["transmission", "bottom_counting"].map(|name| {
            let response = DetectorResponse::named(name, GRID).unwrap();
            tube.folded(&response).unwrap().mean_kev()
        });
        assert!(arriving > interacting + 5.0, "{arriving} and {interacting} keV");
        let last = GRID.count() - 1;
        assert!((factors("transmission")[last] - 0.80).abs() < 0.005);
        assert!((factors("bottom_counting")[last] / factors("transmission")[last] - 0.13).abs() < 0.005);
    }

    #[test]
    fn a_detected_photon_has_a_gain() {
        for name in DetectorResponse::names() {
            let response = DetectorResponse::named(name, GRID).unwrap();
            let efficiency = response.efficiency().unwrap();
            let gains: Vec<f64> = response.factors().iter().zip(efficiency).map(|(f, e)| f / e).collect();
            assert_eq!(response.counts_photons(), !name.ends_with("energy"), "{name}");
            let least = if response.counts_photons() { 1.0 } else { 1.001 };
            // A photon gives up at most its energy.
            assert!(gains.iter().zip(GRID.energies()).all(|(g, e)| *g >= least && *g <= e), "{name}");
        }
        let own = DetectorResponse::new("own", GRID, vec![0.5; 136]).unwrap();
        assert!(own.efficiency().is_none() && !own.counts_photons());
        let refused = |k: usize, value: f64| {
            let mut efficiency = vec![0.5; 136];
            efficiency[k] = value;
            own.clone().with_efficiency(efficiency).unwrap_err().to_string()
        };
        assert!(refused(3, 1.1).starts_with("detector_efficiency[3] is 1.1"));
        assert!(refused(4, 0.0).contains("detector_response[4] is 0.5"));
    }

    #[test]
    fn absorbed_energy_is_less_than_what_interacts() {
        for (energy, counting) in [("top_energy", "top_counting"), ("bottom_energy", "bottom_counting")] {
            let pairs = factors(energy).into_iter().zip(factors(counting));
            for ((absorbed, interacting), e) in pairs.zip(GRID.energies()) {
                assert!(absorbed > 0.0 && absorbed < interacting * e, "{energy} at {e} keV");
            }
        }
    }

    #[test]
    fn names_are_the_accepted_names() {
        for name in DetectorResponse::names() {
            assert_eq!(DetectorResponse::named(name, GRID).unwrap().name(), *name);
        }
        let message = DetectorResponse::named("bottom", GRID).unwrap_err().to_string();
        assert!(message.contains("bottom_counting"), "{message}");
        let between = EnergyGrid::single(60.5).unwrap();
        assert!(DetectorResponse::named("ideal", between).is_ok());
        assert!(DetectorResponse::named("top_energy", between).is_err());
        let message = DetectorResponse::new("own", between, vec![f64::NAN]).unwrap_err().to_string();
        assert!(message.starts_with("detector_response[0] is NaN"), "{message}");
    }
}
