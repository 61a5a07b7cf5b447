//! How likely each kind of interaction is.

use super::Coherent;
use crate::error::{Error, Result};
use crate::physics::tables::{COMPONENTS, number, records, unknown};
use crate::physics::{EnergyGrid, Material};

/// Molar masses in g/mol of the elements of tissues (IUPAC, Abridged Standard Atomic Weights 2021).
const MOLAR_MASSES: [(u8, f64); 13] = [
    (1, 1.008),
    (6, 12.011),
    (7, 14.007),
    (8, 15.999),
    (11, 22.990),
    (12, 24.305),
    (15, 30.974),
    (16, 32.06),
    (17, 35.45),
    (18, 39.95),
    (19, 39.098),
    (20, 40.078),
    (26, 55.845),
];

/// Mass coefficients of the three kinds of interaction, cm²/g.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coefficients {
    /// The photon is absorbed.
    pub(crate) photoelectric: f64,
    /// The photon is scattered by an electron and loses energy.
    pub(crate) incoherent: f64,
    /// The photon is scattered by an atom and keeps its energy.
    pub(crate) coherent: f64,
}

impl Coefficients {
    /// Their sum, which attenuates.
    pub(crate) fn total(&self) -> f64 {
        self.photoelectric + self.incoherent + self.coherent
    }

    /// Those after which there still is a photon.
    pub(crate) fn scattering(&self) -> f64 {
        self.incoherent + self.coherent
    }
}

/// The interactions of one tissue at every energy from 15 to 150 keV: tabulated at whole keV, between them as powers of
/// the energy, which is right because no element of a tissue has an edge there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Interactions {
    /// Logarithms of the table's energies.
    energies: Vec<f64>,
    /// Logarithms of the three coefficients and of the coherent peak, one row per energy.
    rows: Vec<[f64; 4]>,
}

impl Interactions {
    /// Lowest energy, keV.
    pub(crate) const LOWEST_KEV: f64 = 15.0;
    /// Highest energy, keV.
    pub(crate) const HIGHEST_KEV: f64 = 150.0;

    /// Those of a built-in tissue: air, lung, `soft_tissue`, `bone_cortical`, water, adipose or muscle.
    ///
    /// # Errors
    /// `InvalidArgument` for another name.
    pub(crate) fn named(material: &str) -> Result<Self> {
        let rows: Vec<Vec<&str>> = records(COMPONENTS).skip(1).filter(|row| row[0] == material).collect();
        if rows.is_empty() {
            let mut names: Vec<_> = records(COMPONENTS).skip(1).map(|row| row[0]).collect();
            names.dedup();
            return Err(unknown("scattering material", material, &names));
        }
        let point_charges = Coherent::of_point_charges(molar(Material::named(material)?)?.into_iter());
        let row = |row: &Vec<&str>| {
            let [photoelectric, incoherent, coherent] = [2, 3, 4].map(|k| number::<f64>(row[k]));
            let peak = Coherent::of_part(coherent / point_charges).peak();
            [photoelectric, incoherent, coherent, peak].map(f64::ln)
        };
        let energies = EnergyGrid::SPECIFICATION.energies().map(f64::ln).collect();
        Ok(Self { energies, rows: rows.iter().map(row).collect() })
    }

    /// Index of the interval of the table that holds `kev`, and the part of it that lies below.
    fn place(&self, kev: f64) -> (usize, f64) {
        let index = (kev - Self::LOWEST_KEV).clamp(0.0, (self.rows.len() - 2) as f64) as usize;
        let below = kev.ln() - self.energies[index];
        (index, below / (self.energies[index + 1] - self.energies[index]))
    }

    fn value(&self, (index, part): (usize, f64), column: usize) -> f64 {
        let [low, high] = [0, 1].map(|next| self.rows[index + next][column]);
        (low + part * (high - low)).exp()
    }

    /// The coefficients at `kev` in [`Self::LOWEST_KEV`] … [`Self::HIGHEST_KEV`].
    pub(crate) fn at(&self, kev: f64) -> Coefficients {
        let place = self.place(kev);
        let [photoelectric, incoherent, coherent] = [0, 1, 2].map(|column| self.value(place, column));
        Coefficients { photoelectric, incoherent, coherent }
    }

    /// Where coherently scattered photons of `kev` go.
    pub(crate) fn coherent(&self, kev: f64) -> Coherent {
        Coherent::of_peak(self.value(self.place(kev), 3))
    }
}

/// Atomic number, mass fraction and molar mass of each element.
fn molar(material: &Material) -> Result<Vec<(u8, f64, f64)>> {
    let element = |&(z, fraction): &(u8, f64)| {
        let known = MOLAR_MASSES.iter().find(|(number, _)| *number == z);
        let valid = "elements of tissues, whose molar masses are known";
        known.map(|(_, molar)| (z, fraction, *molar)).ok_or_else(|| Error::invalid("element", z, valid))
    };
    material.composition().iter().map(element).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::over_directions;
    use super::super::{AVOGADRO, Incoherent, SQUARE_ELECTRON_RADIUS};
    use super::*;
    use crate::physics::MassAttenuation;

    const TISSUES: [&str; 7] = ["air", "lung", "soft_tissue", "bone_cortical", "water", "adipose", "muscle"];

    #[test]
    fn the_three_kinds_attenuate_as_the_total_does() {
        for name in TISSUES {
            let (own, total) = (
                Interactions::named(name).unwrap(),
                MassAttenuation::named(&[name], EnergyGrid::SPECIFICATION).unwrap(),
            );
            assert_eq!(own.rows.len(), 136);
            for (kev, total) in EnergyGrid::SPECIFICATION.energies().zip(total.coefficients(0)) {
                assert!((own.at(kev).total() / total - 1.0).abs() < 1e-7, "{name} at {kev} keV");
            }
        }
        assert!(Interactions::named("tungsten").unwrap_err().to_string().contains("soft_tissue"));
    }

    #[test]
    fn coherent_scattering_over_all_angles_is_the_tabulated() {
        for name in TISSUES {
            let own = Interactions::named(name).unwrap();
            let charges: f64 = molar(Material::named(name).unwrap())
                .unwrap()
                .iter()
                .map(|(z, fraction, molar)| fraction * f64::from(*z).powi(2) / molar)
                .sum();
            for kev in [15.0, 16.0, 33.0, 60.0, 100.0, 150.0] {
                let peak = own.coherent(kev).peak();
                let form = |cosine: f64| 1.0 / (1.0 + peak * 0.5 * (1.0 - cosine)).powi(2);
                let angles = over_directions(|cosine| 0.5 * (1.0 + cosine * cosine) * form(cosine));
                let ratio = SQUARE_ELECTRON_RADIUS * AVOGADRO * charges * angles / own.at(kev).coherent;
                assert!((ratio - 1.0).abs() < 1e-6, "{name} at {kev} keV: {ratio}");
            }
        }
    }

    #[test]
    fn bound_electrons_scatter_a_little_less_than_free_ones() {
        // Water: 10 electrons per 18.015 g/mol.
        let water = Interactions::named("water").unwrap();
        for (kev, least) in [(15.0, 0.78), (30.0, 0.91), (60.0, 0.97), (150.0, 0.99)] {
            let free = AVOGADRO * 10.0 / 18.015 * Incoherent::new(kev).cross_section();
            let ratio = water.at(kev).incoherent / free;
            assert!(ratio > least && ratio < 1.001, "{kev} keV: {ratio}");
        }
    }

    #[test]
    fn the_form_factor_hardly_depends_on_the_energy() {
        // x0 = 1/(λ √peak) with λ = 12.398 Å keV/E: a property of the atoms, about half an inverse ångström for oxygen.
        let water = Interactions::named("water").unwrap();
        for kev in [15.0, 30.0, 60.0, 120.0] {
            let x0 = kev / 12.398_42 / water.coherent(kev).peak().sqrt();
            assert!(x0 > 0.2 && x0 < 0.6, "{kev} keV: {x0} Å⁻¹");
        }
    }

    #[test]
    fn between_whole_kev_the_table_goes_on_smoothly() {
        let water = Interactions::named("water").unwrap();
        for kev in [15.5, 40.5, 99.5, 149.5] {
            // Photoelectric absorption falls about as E⁻³·²: the geometric mean of the neighbours, shifted by 1/E².
            let [below, at, above] = [kev - 0.5, kev, kev + 0.5].map(|e| water.at(e).photoelectric);
            let mean = (below * above).sqrt();
            assert!(at < mean && at > mean * (1.0 - 1.0 / (kev * kev)), "{kev} keV: {at} and {mean}");
            assert!(water.at(kev).total() > 0.0);
        }
    }
}
