//! Density and composition of the built-in materials.

use std::sync::LazyLock;

use crate::error::Result;
use crate::physics::tables::{number, records, unknown};

static MATERIALS: LazyLock<Vec<Material>> = LazyLock::new(|| {
    let rows = records(include_str!("tables/materials.csv")).skip(1);
    rows.map(|row| Material {
        name: row[0],
        reference_density: number(row[1]),
        composition: row[2].split(' ').map(element).collect(),
        citation: row[3],
    })
    .collect()
});

fn element(entry: &str) -> (u8, f64) {
    let (z, fraction) = entry.split_once(':').expect("Z:fraction");
    (number(z), number(fraction))
}

/// What a built-in material is.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    name: &'static str,
    reference_density: f64,
    composition: Vec<(u8, f64)>,
    citation: &'static str,
}

impl Material {
    /// The built-in material of that name, one of [`MassAttenuation::material_names`](super::MassAttenuation::material_names).
    ///
    /// # Errors
    /// `InvalidArgument` for an unknown name.
    pub fn named(name: &str) -> Result<&'static Self> {
        MATERIALS.iter().find(|m| m.name == name).ok_or_else(|| {
            let names: Vec<_> = MATERIALS.iter().map(|m| m.name).collect();
            unknown("material", name, &names)
        })
    }

    /// The name.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Usual mass density in g/cm³; for `lung` that of the tissue, not of the inflated lung (0.26).
    pub fn reference_density(&self) -> f64 {
        self.reference_density
    }

    /// Atomic number and mass fraction of each element.
    pub fn composition(&self) -> &[(u8, f64)] {
        &self.composition
    }

    /// Where the composition comes from.
    pub fn citation(&self) -> &'static str {
        self.citation
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::MassAttenuation;

    #[test]
    fn materials_and_coefficients_are_the_same_list() {
        let names: Vec<_> = MATERIALS.iter().map(Material::name).collect();
        assert_eq!(names, MassAttenuation::material_names());
    }

    #[test]
    fn mass_fractions_sum_to_one() {
        for material in MATERIALS.iter() {
            let sum: f64 = material.composition().iter().map(|(_, fraction)| fraction).sum();
            // Published compositions are rounded to three or four digits.
            assert!((sum - 1.0).abs() < 2e-3, "{}: {sum}", material.name());
            assert!(material.citation().len() > 5, "{}", material.name());
        }
    }

    #[test]
    fn water_is_two_hydrogen_and_one_oxygen() {
        let water = Material::named("water").unwrap();
        assert_eq!(water.reference_density(), 1.0);
        let hydrogen = 2.0 * 1.008 / (2.0 * 1.008 + 15.999);
        assert_eq!(water.composition()[0].0, 1);
        assert!((water.composition()[0].1 - hydrogen).abs() < 2e-5);
    }

    #[test]
    fn densities_of_the_specification() {
        for (name, density) in [("air", 0.001_204_79), ("soft_tissue", 1.06), ("bone_cortical", 1.92)] {
            assert_eq!(Material::named(name).unwrap().reference_density(), density);
        }
        assert!(Material::named("soft_tissue").unwrap().citation().contains("tissue, soft"));
        assert!(Material::named("unobtainium").unwrap_err().to_string().contains("tungsten"));
    }
}
