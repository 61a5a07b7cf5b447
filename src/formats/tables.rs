//! CSV tables over the photon energy. Lines that start with `#` are comments.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use crate::error::Result;
use crate::formats::{Checked, file_error};
use crate::physics::{EnergyGrid, MAX_ENERGIES};

/// How far an energy may be from its place, in steps.
const STEP_TOLERANCE: f64 = 1e-6;
const ENERGY: &str = "energy_keV";

/// A column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The name in the header line.
    pub name: String,
    /// One value per energy; finite and not negative.
    pub values: Vec<f64>,
}

/// Columns over a common grid of energies.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The energies; the step is 1 keV where there is one energy only.
    pub energies: EnergyGrid,
    /// At least one column; the names differ.
    pub columns: Vec<Column>,
}

/// Reads a spectrum, `energy_keV,weight`; the weights are relative.
pub fn read_spectrum(path: &Path) -> Result<Table> {
    read(path, Some("weight"))
}

/// Reads a detector's response, `energy_keV,factor`: the signal of one photon of that energy.
pub fn read_detector(path: &Path) -> Result<Table> {
    read(path, Some("factor"))
}

/// Reads mass attenuation coefficients in cm²/g, `energy_keV,name0,name1,…`: one column per material.
pub fn read_materials(path: &Path) -> Result<Table> {
    read(path, None)
}

fn read(path: &Path, only_column: Option<&str>) -> Result<Table> {
    parse(path, only_column).map_err(|reason| file_error(path, reason))
}

fn parse(path: &Path, only_column: Option<&str>) -> Checked<Table> {
    let mut reader = ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_path(path)
        .map_err(|e| e.to_string())?;
    let header = reader.headers().map_err(|e| e.to_string())?.clone();
    let mut columns = columns(&header, only_column)?;
    let mut energies: Vec<(f64, u64)> = vec![];
    for record in reader.records() {
        let record = record.map_err(|e| e.to_string())?;
        let line = line(&record);
        if energies.len() == MAX_ENERGIES {
            return Err(format!("line {line}: more than {MAX_ENERGIES} energies; valid: 1 … {MAX_ENERGIES}"));
        }
        energies.push((number(&record[0], ENERGY, line)?, line));
        for (column, text) in columns.iter_mut().zip(record.iter().skip(1)) {
            column.values.push(number(text, &column.name, line)?);
        }
    }
    Ok(Table { energies: energy_grid(&energies)?, columns })
}

fn columns(header: &StringRecord, only_column: Option<&str>) -> Checked<Vec<Column>> {
    let names: Vec<&str> = header.iter().collect();
    let right = match only_column {
        Some(name) => names == [ENERGY, name],
        None => names.len() > 1 && names[0] == ENERGY && !names.contains(&""),
    };
    if !right {
        let valid = only_column.unwrap_or("one column per material");
        let line = line(header);
        return Err(format!("line {line}: the header is \"{}\"; valid: {ENERGY},{valid}", names.join(",")));
    }
    if let Some((i, name)) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
        return Err(format!("line {}: column {} repeats the name {name}", line(header), i + 1));
    }
    Ok(names[1..].iter().map(|&name| Column { name: name.to_owned(), values: vec![] }).collect())
}

fn line(record: &StringRecord) -> u64 {
    record.position().map_or(1, csv::Position::line)
}

fn number(text: &str, name: &str, line: u64) -> Checked<f64> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err(format!("line {line}: {name} is \"{text}\"; valid: a finite number, not negative")),
    }
}

/// Energies with their lines → the grid they lie on.
fn energy_grid(energies: &[(f64, u64)]) -> Checked<EnergyGrid> {
    let (&(first_kev, first_line), &(last, _)) =
        energies.first().zip(energies.last()).ok_or("has no lines below its header")?;
    if first_kev <= 0.0 {
        return Err(format!("line {first_line}: {ENERGY} is {first_kev}; valid: positive"));
    }
    let count = energies.len();
    let step_kev = if count == 1 { 1.0 } else { (last - first_kev) / (count - 1) as f64 };
    for pair in energies.windows(2) {
        let [(before, _), (energy, line)] = [pair[0], pair[1]];
        if energy <= before {
            return Err(format!("line {line}: {ENERGY} is {energy} after {before}; valid: ascending"));
        }
    }
    for (i, &(energy, line)) in energies.iter().enumerate() {
        let expected = first_kev + i as f64 * step_kev;
        if (energy - expected).abs() > STEP_TOLERANCE * step_kev {
            return Err(format!(
                "line {line}: {ENERGY} is {energy}; valid: equal steps, which is {expected} here"
            ));
        }
    }
    EnergyGrid::new(first_kev, step_kev, count).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        file
    }

    #[test]
    fn materials_have_their_columns_by_name() {
        let text = "# cm^2/g\nenergy_keV, water ,bone\n# between\n15,1.5,9e0\r\n15.5,1.25,8\n\n16,1,7.5\n";
        let table = read_materials(file(text).path()).unwrap();
        assert_eq!(table.energies, EnergyGrid::new(15.0, 0.5, 3).unwrap());
        assert_eq!(table.columns.len(), 2);
        assert_eq!(table.columns[0], Column { name: "water".to_owned(), values: vec![1.5, 1.25, 1.0] });
        assert_eq!(table.columns[1], Column { name: "bone".to_owned(), values: vec![9.0, 8.0, 7.5] });
    }

    #[test]
    fn decimal_energies_count_as_uniform() {
        let rows: Vec<String> = (0..1360).map(|i| format!("{:.1},1", 15.0 + 0.1 * f64::from(i))).collect();
        let table = read_spectrum(file(&format!("energy_keV,weight\n{}", rows.join("\n"))).path()).unwrap();
        assert_eq!(table.energies.count(), 1360);
        assert!((table.energies.step_kev() - 0.1).abs() < 1e-12);
    }

    #[test]
    fn one_energy_is_a_spectrum() {
        let table = read_spectrum(file("energy_keV,weight\n70,2\n").path()).unwrap();
        assert_eq!(table.energies, EnergyGrid::single(70.0).unwrap());
        assert_eq!(table.columns[0].values, [2.0]);
    }

    #[test]
    fn every_kind_of_table_has_its_own_header() {
        let detector = file("energy_keV,factor\n1,0.5\n2,0.25\n");
        assert_eq!(read_detector(detector.path()).unwrap().columns[0].values, [0.5, 0.25]);
        assert!(read_spectrum(detector.path()).unwrap_err().to_string().contains("energy_keV,weight"));
    }

    #[test]
    fn errors_name_the_line() {
        let cases = [
            ("", "header"),
            ("15,1\n16,2\n", "line 1: the header is \"15,1\""),
            ("energy_keV,weight\n", "no lines"),
            ("# a\nenergy_keV,weight\n# b\n15,1\n16,x\n", "line 5: weight is \"x\""),
            ("energy_keV,weight\n15,1\n16,-1\n", "line 3: weight is \"-1\""),
            ("energy_keV,weight\n15,1\n16,NaN\n", "line 3: weight is \"NaN\""),
            ("energy_keV,weight\n15,1\n16,1,2\n", "line: 3"),
            ("energy_keV,weight\n0,1\n1,1\n", "line 2: energy_keV is 0"),
            ("energy_keV,weight\n15,1\n17,1\n16,1\n", "line 4: energy_keV is 16 after 17"),
            ("energy_keV,weight\n15,1\n16,1\n17.001,1\n18,1\n", "line 4: energy_keV is 17.001"),
        ];
        for (text, word) in cases {
            let message = read_spectrum(file(text).path()).unwrap_err().to_string();
            assert!(message.contains(word), "{word}: {message}");
        }
        let long: Vec<String> = (1..6000).map(|kev| format!("{kev},1")).collect();
        let long = read_spectrum(file(&format!("energy_keV,weight\n{}", long.join("\n"))).path())
            .unwrap_err()
            .to_string();
        assert!(long.contains("line 4098: more than 4096 energies"), "{long}");
        let repeated = read_materials(file("energy_keV,a,b,a\n1,1,1,1\n").path()).unwrap_err().to_string();
        assert!(repeated.contains("column 4 repeats the name a"), "{repeated}");
    }
}
