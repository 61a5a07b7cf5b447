//! Filters between source and patient.

use std::path::PathBuf;

use anyhow::Result;
use drr::effects::{Filter, Profile};
use drr::formats::read_curve;
use drr::physics::{EnergyGrid, Material};

/// What a filter is made of, and how thick it is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FilterArgument {
    material: String,
    thickness: Thickness,
}

#[derive(Debug, Clone, PartialEq)]
enum Thickness {
    /// mm.
    Flat(f64),
    /// A table of fan angle and thickness.
    BowTie(PathBuf),
}

/// `MATERIAL:MM`.
pub(super) fn flat(text: &str) -> Result<FilterArgument, String> {
    let (material, mm) = parts(text).ok_or("expected MATERIAL:MM, such as copper:0.1")?;
    let mm = mm.parse::<f64>().ok().filter(|mm| mm.is_finite() && *mm >= 0.0);
    let mm = mm.ok_or("expected MATERIAL:MM with a thickness of at least 0 mm")?;
    of(material, Thickness::Flat(mm))
}

/// `MATERIAL:FILE.csv`.
pub(super) fn bow_tie(text: &str) -> Result<FilterArgument, String> {
    let (material, file) = parts(text).ok_or("expected MATERIAL:FILE.csv, such as aluminium:bowtie.csv")?;
    of(material, Thickness::BowTie(file.into()))
}

fn parts(text: &str) -> Option<(&str, &str)> {
    text.split_once(':').filter(|(material, rest)| !material.is_empty() && !rest.is_empty())
}

fn of(material: &str, thickness: Thickness) -> Result<FilterArgument, String> {
    Material::named(material).map_err(|error| error.to_string())?;
    Ok(FilterArgument { material: material.into(), thickness })
}

impl FilterArgument {
    /// The filter at the energies of a spectrum.
    pub(super) fn filter(&self, grid: EnergyGrid) -> Result<Filter> {
        let profile = match &self.thickness {
            Thickness::Flat(mm) => Profile::Flat { mm: *mm },
            Thickness::BowTie(path) => {
                let points = read_curve(path, ["degrees", "mm"])?;
                let [degrees, mm] = [0, 1].map(|axis| points.iter().map(|p| p[axis]).collect());
                Profile::BowTie { degrees, mm }
            }
        };
        Ok(Filter::named(&self.material, grid, profile)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filter_has_a_material_that_there_is_and_a_thickness() {
        let copper = flat("copper:0.1").expect("valid");
        assert_eq!(copper, FilterArgument { material: "copper".into(), thickness: Thickness::Flat(0.1) });
        for bad in ["copper", "copper:", ":1", "copper:-1", "copper:nan", "cheese:1"] {
            assert!(flat(bad).is_err(), "{bad}");
        }
        assert!(bow_tie("pmma:a:b.csv").is_ok_and(|f| f.thickness == Thickness::BowTie("a:b.csv".into())));
    }
}
