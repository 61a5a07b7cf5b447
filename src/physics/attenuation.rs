//! Mass attenuation coefficients.

use crate::error::{Error, Result};
use crate::physics::EnergyGrid;
use crate::physics::tables::MASS_ATTENUATION;

/// Most materials of one scene.
pub const MAX_MATERIALS: usize = 8;
/// Largest mass attenuation coefficient, cm²/g: the line integral through any volume stays far from the end of float32.
pub(crate) const MAX_ATTENUATION: f64 = 1e9;

/// Total mass attenuation coefficients μ/ρ in cm²/g, with coherent scattering, of up to [`MAX_MATERIALS`] materials.
///
/// Coefficient of material m at energy k: `values[m*count + k]`.
#[derive(Debug, Clone, PartialEq)]
pub struct MassAttenuation {
    grid: EnergyGrid,
    names: Vec<String>,
    values: Vec<f64>,
}

impl MassAttenuation {
    /// The four materials of the specification, in the order of its lookup table.
    pub const SPECIFICATION: [&str; 4] = ["air", "lung", "soft_tissue", "bone_cortical"];

    /// A table of one's own: `values[m*grid.count() + k]` in cm²/g.
    ///
    /// # Errors
    /// `InvalidArgument` unless there are 1 … [`MAX_MATERIALS`] names, one value per material and energy, and all
    /// values are in 0 … 1e9 cm²/g (the first that is not is named).
    pub fn new(grid: EnergyGrid, names: Vec<String>, values: Vec<f64>) -> Result<Self> {
        check_material_count("mass_attenuation.names", names.len())?;
        if values.len() != names.len() * grid.count() {
            let valid = format!("{} materials × {} energies", names.len(), grid.count());
            return Err(Error::invalid("mass_attenuation", format!("{} values", values.len()), valid));
        }
        let valid = format!("0 … {MAX_ATTENUATION:e} cm²/g");
        for (m, row) in values.chunks(grid.count()).enumerate() {
            grid.check_values(&format!("mass_attenuation[{m}]"), row, (0.0..=MAX_ATTENUATION, &valid))?;
        }
        Ok(Self { grid, names, values })
    }

    /// Built-in materials at the energies of `grid`, which must be whole keV in 15 … 150.
    ///
    /// # Errors
    /// `InvalidArgument` for an unknown name, none or too many of them, or an energy that is not tabulated.
    pub fn named(names: &[&str], grid: EnergyGrid) -> Result<Self> {
        check_material_count("materials", names.len())?;
        let mut values = Vec::with_capacity(names.len() * grid.count());
        for (m, name) in names.iter().enumerate() {
            values.extend(MASS_ATTENUATION.at(&format!("materials[{m}]"), name, &grid)?);
        }
        Self::new(grid, names.iter().map(ToString::to_string).collect(), values)
    }

    /// The same with one more of the built-in materials at its end.
    ///
    /// # Errors
    /// As [`MassAttenuation::named`]; `InvalidArgument` for more than [`MAX_MATERIALS`].
    pub fn with(&self, name: &str) -> Result<Self> {
        let own = Self::named(&[name], self.grid)?;
        let names = self.names.iter().chain(&own.names).cloned().collect();
        Self::new(self.grid, names, [&self.values[..], &own.values].concat())
    }

    /// Names of the built-in materials.
    pub fn material_names() -> &'static [&'static str] {
        MASS_ATTENUATION.names()
    }

    /// The energies.
    pub fn grid(&self) -> &EnergyGrid {
        &self.grid
    }

    /// The materials of this table, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Coefficients of a material (an index below `names().len()`), one per energy, cm²/g.
    pub fn coefficients(&self, material: usize) -> &[f64] {
        let count = self.grid.count();
        &self.values[material * count..(material + 1) * count]
    }
}

/// Checks the number of materials of a scene.
pub(super) fn check_material_count(argument: &str, count: usize) -> Result<()> {
    if count == 0 || count > MAX_MATERIALS {
        return Err(Error::invalid(argument, format!("{count} materials"), format!("1 … {MAX_MATERIALS}")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: EnergyGrid = EnergyGrid::SPECIFICATION;

    fn coefficient(material: &str, kev: f64) -> f64 {
        let grid = EnergyGrid::single(kev).unwrap();
        MassAttenuation::named(&[material], grid).unwrap().coefficients(0)[0]
    }

    #[test]
    fn well_known_coefficients() {
        // NIST tables of Hubbell & Seltzer, which give four digits.
        for (material, kev, expected) in [
            ("water", 20.0, 0.8096),
            ("water", 60.0, 0.2059),
            ("water", 150.0, 0.1505),
            ("bone_cortical", 30.0, 1.331),
            ("aluminium", 60.0, 0.2778),
            ("tungsten", 100.0, 4.438),
            ("air", 100.0, 0.1541),
        ] {
            let ratio = coefficient(material, kev) / expected;
            assert!((ratio - 1.0).abs() < 2e-3, "{material} at {kev} keV: ratio {ratio}");
        }
    }

    #[test]
    fn k_edges_lie_between_their_energies() {
        for (material, below) in [("tungsten", 69.0), ("iodine", 33.0), ("csi", 35.0), ("gd2o2s", 50.0)] {
            let jump = coefficient(material, below + 1.0) / coefficient(material, below);
            assert!(jump > 1.4, "{material} above {below} keV: {jump}");
        }
        assert!(GRID.energies().skip(1).all(|e| coefficient("water", e) < coefficient("water", e - 1.0)));
    }

    #[test]
    fn a_solution_is_the_mixture_of_its_parts() {
        let table = MassAttenuation::named(&["water", "iodine", "iodine350_water"], GRID).unwrap();
        for k in 0..GRID.count() {
            let [water, iodine, solution] = [0, 1, 2].map(|m| table.coefficients(m)[k]);
            let mixture = (1.0 - 0.273_641) * water + 0.273_641 * iodine;
            assert!((mixture / solution - 1.0).abs() < 2e-6, "{} keV", GRID.energy(k));
        }
    }

    #[test]
    fn every_built_in_material_at_every_single_energy() {
        assert_eq!(MassAttenuation::material_names().len(), 22);
        for name in MassAttenuation::material_names() {
            assert!(GRID.energies().all(|e| coefficient(name, e) > 0.0), "{name}");
        }
    }

    #[test]
    fn one_more_material_changes_no_other() {
        let table = MassAttenuation::named(&MassAttenuation::SPECIFICATION, GRID).unwrap();
        let more = table.with("titanium").unwrap();
        assert_eq!(
            more,
            MassAttenuation::named(&["air", "lung", "soft_tissue", "bone_cortical", "titanium"], GRID)
                .unwrap()
        );
        let full = (0..4).fold(table, |table, _| table.with("water").unwrap());
        assert!(full.with("water").unwrap_err().to_string().contains("9 materials"));
    }

    #[test]
    fn refusals_name_what_is_wrong() {
        let names = |n: usize| vec!["m".to_string(); n];
        let with = |value: f64| {
            let mut values = vec![0.0; 272];
            values[136 + 7] = value;
            MassAttenuation::new(GRID, names(2), values)
        };
        assert!(with(1e9).is_ok());
        for (error, part) in [
            (with(f64::NAN), "mass_attenuation[1][7] is NaN; valid: 0 … 1e9 cm²/g"),
            (with(-1.0), "mass_attenuation[1][7] is -1; valid: 0 … 1e9 cm²/g"),
            (with(1e10), "mass_attenuation[1][7] is 10000000000; valid: 0 … 1e9 cm²/g"),
            (MassAttenuation::new(GRID, names(2), vec![0.0; 136]), "2 materials × 136 energies"),
            (MassAttenuation::new(GRID, vec![], vec![]), "1 … 8"),
            (MassAttenuation::new(GRID, names(9), vec![0.0; 9 * 136]), "1 … 8"),
            (MassAttenuation::named(&[], GRID), "1 … 8"),
            (
                MassAttenuation::named(&["air", "bone"], GRID),
                "materials[1] is \"bone\"; valid: one of air, lung",
            ),
        ] {
            let message = error.unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
