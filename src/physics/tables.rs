//! The embedded tables (`tables/*.csv`), parsed once at first use. Their provenance is in `tables/README.md`.

use std::fmt::Display;
use std::str::FromStr;
use std::sync::LazyLock;

use crate::error::{Error, Result};
use crate::physics::EnergyGrid;

/// Total mass attenuation, cm²/g: one column per material.
pub(super) static MASS_ATTENUATION: LazyLock<EnergyTable> =
    LazyLock::new(|| EnergyTable::parse(include_str!("tables/mu_rho_total.csv")));

/// Tube spectra, photons/(cm² mAs) per 1 keV bin at 100 cm: one column per tube setting.
pub(super) static SPECTRA: LazyLock<EnergyTable> =
    LazyLock::new(|| EnergyTable::parse(include_str!("tables/spectra.csv")));

/// Factors of a dual-layer panel: one column per factor.
pub(super) static DETECTOR: LazyLock<EnergyTable> =
    LazyLock::new(|| EnergyTable::parse(include_str!("tables/detector.csv")));

/// Partial mass attenuation, cm²/g: one line per tissue and energy.
pub(super) const COMPONENTS: &str = include_str!("tables/mu_rho_components.csv");

/// Columns of numbers over the 136 energies of [`EnergyGrid::SPECIFICATION`].
pub(super) struct EnergyTable {
    names: Vec<&'static str>,
    columns: Vec<Vec<f64>>,
}

impl EnergyTable {
    fn parse(text: &'static str) -> Self {
        let mut records = records(text);
        let names = records.next().expect("a line of column names").split_off(1);
        let mut columns = vec![Vec::with_capacity(EnergyGrid::SPECIFICATION.count()); names.len()];
        for (k, record) in records.enumerate() {
            assert_eq!(number::<f64>(record[0]), EnergyGrid::SPECIFICATION.energy(k), "energies of a table");
            for (column, field) in columns.iter_mut().zip(&record[1..]) {
                column.push(number(field));
            }
        }
        Self { names, columns }
    }

    /// Column names, in the file's order.
    pub(super) fn names(&self) -> &[&'static str] {
        &self.names
    }

    /// The column called `name`, on the table's own energies. `argument` is what an error calls it.
    pub(super) fn column(&self, argument: &str, name: &str) -> Result<&[f64]> {
        match self.names.iter().position(|n| *n == name) {
            Some(index) => Ok(&self.columns[index]),
            None => Err(unknown(argument, name, &self.names)),
        }
    }

    /// The column called `name` at the energies of `grid`, which must all be tabulated: a table is never
    /// interpolated, because that is wrong across a K edge.
    pub(super) fn at(&self, argument: &str, name: &str, grid: &EnergyGrid) -> Result<Vec<f64>> {
        let column = self.column(argument, name)?;
        tabulated(grid)?.into_iter().map(|index| Ok(column[index])).collect()
    }
}

/// Rows of the built-in tables at the energies of `grid`.
pub(super) fn tabulated(grid: &EnergyGrid) -> Result<Vec<usize>> {
    let index = |(k, kev): (usize, f64)| {
        EnergyGrid::SPECIFICATION.index_of(kev).ok_or_else(|| {
            let valid = "whole keV from 15 to 150 for the built-in tables, which are not interpolated (K edges); \
                         supply your own table for other energies";
            Error::invalid(EnergyGrid::argument(k), format!("{kev} keV"), valid)
        })
    };
    grid.energies().enumerate().map(index).collect()
}

/// The error for a name that is not in a list.
pub(super) fn unknown(argument: &str, name: &str, names: &[&str]) -> Error {
    Error::invalid(argument, format!("\"{name}\""), format!("one of {}", names.join(", ")))
}

/// The lines of an embedded table that are not comments, cut at commas outside quotes.
pub(super) fn records(text: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()).map(|line| {
        let mut quoted = false;
        line.split(move |c| {
            quoted ^= c == '"';
            c == ',' && !quoted
        })
        .map(|field| field.trim_matches('"'))
        .collect()
    })
}

/// A number of an embedded table.
pub(super) fn number<T: FromStr<Err: Display>>(field: &str) -> T {
    field.parse().unwrap_or_else(|error| panic!("embedded table, {field}: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::energy::WEIGHTS;

    #[test]
    fn every_energy_table_is_complete() {
        for (table, columns) in [(&MASS_ATTENUATION, 22), (&SPECTRA, 7), (&DETECTOR, 9)] {
            assert_eq!(table.names.len(), columns);
            for (name, column) in table.names.iter().zip(&table.columns) {
                EnergyGrid::SPECIFICATION.check_values(name, column, WEIGHTS).unwrap();
            }
        }
    }

    #[test]
    fn a_quoted_comma_does_not_cut() {
        let fields: Vec<_> = records("# a,b\nx,1,\"tissue, soft\"\n").collect();
        assert_eq!(fields, [["x", "1", "tissue, soft"]]);
    }

    #[test]
    fn energies_between_rows_are_refused_with_a_way_out() {
        let grid = EnergyGrid::new(69.0, 0.5, 3).unwrap();
        let message = MASS_ATTENUATION.at("material", "tungsten", &grid).unwrap_err().to_string();
        assert!(message.contains("69.5 keV") && message.contains("your own table"), "{message}");
        for kev in [14.0, 151.0, 60.0 + 1e-8] {
            assert!(tabulated(&EnergyGrid::single(kev).unwrap()).is_err(), "{kev} keV");
        }
        assert_eq!(tabulated(&EnergyGrid::new(150.0 - 1e-10, 1.0, 1).unwrap()), Ok(vec![135]));
    }
}
