//! What a detector makes of a photon of energy E.

use crate::error::Result;
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
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorResponse {
    name: String,
    grid: EnergyGrid,
    factors: Vec<f64>,
}

impl DetectorResponse {
    /// Every photon counts once, whatever its energy.
    pub fn ideal(grid: EnergyGrid) -> Self {
        Self { name: "ideal".into(), grid, factors: vec![1.0; grid.count()] }
    }

    /// A response of one's own: `factors[k]` is for energy k of `grid`.
    ///
    /// # Errors
    /// `InvalidArgument` unless there is one factor per energy and all are finite and at least 0.
    pub fn new(name: impl Into<String>, grid: EnergyGrid, factors: Vec<f64>) -> Result<Self> {
        grid.check_values("detector_response", &factors, WEIGHTS)?;
        Ok(Self { name: name.into(), grid, factors })
    }

    /// A built-in response; all but `ideal` need a `grid` of whole keV in 15 … 150.
    ///
    /// # Errors
    /// `InvalidArgument` for an unknown name or an energy that is not tabulated.
    pub fn named(name: &str, grid: EnergyGrid) -> Result<Self> {
        let columns: &[&str] = match name {
            "ideal" => return Ok(Self::ideal(grid)),
            "transmission" => &["T_det_spec"],
            "top_counting" => &["A_top"],
            "bottom_counting" => &["T_stack1", "T_mask2_w", "A_bot"],
            "top_energy" => &["ABS_top"],
            "bottom_energy" => &["T_stack1", "T_mask2_w", "ABS_bot"],
            _ => return Err(unknown("detector_response", name, &NAMES)),
        };
        let mut factors: Vec<f64> = match name {
            "top_energy" | "bottom_energy" => grid.energies().collect(),
            _ => vec![1.0; grid.count()],
        };
        for column in columns {
            let values = DETECTOR.at("detector_response", column, &grid)?;
            factors.iter_mut().zip(values).for_each(|(f, v)| *f *= v);
        }
        Self::new(name, grid, factors)
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
