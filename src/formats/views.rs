//! Tables of the views of a parallel beam. Lines that start with `#` are comments.

use std::path::Path;

use csv::{Position, ReaderBuilder, StringRecord, Trim};

use crate::error::Result;
use crate::formats::{Checked, file_error, write_text};
use crate::parallel::ViewParameters;

/// What a table of views must have under these names, in any order, beside anything else.
pub const VIEW_COLUMNS: [&str; 5] = ["alpha_degrees", "beta_degrees", "phi_degrees", "dx_mm", "dz_mm"];

/// Most views of a table.
const MAX_VIEWS: usize = 100_000;

/// Reads the parameters of views, one per line.
///
/// # Errors
/// `File` for a column that is missing, with the line for what is no finite number or not valid, and for no views or more
/// than 100000.
pub fn read_views(path: &Path) -> Result<Vec<ViewParameters>> {
    parse(path).map_err(|reason| file_error(path, reason))
}

/// Writes a table that [`read_views`] reads.
///
/// # Errors
/// `File` when it cannot be written.
pub fn write_views(path: &Path, views: &[ViewParameters]) -> Result<()> {
    let line = |view: &ViewParameters| {
        let [alpha, beta, phi] = [view.alpha, view.beta, view.phi].map(f64::to_degrees);
        format!("{alpha},{beta},{phi},{},{}\n", view.dx, view.dz)
    };
    write_text(path, &(VIEW_COLUMNS.join(",") + "\n" + &views.iter().map(line).collect::<String>()))
}

fn parse(path: &Path) -> Checked<Vec<ViewParameters>> {
    let text = |error: csv::Error| error.to_string();
    let mut reader =
        ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).from_path(path).map_err(text)?;
    let columns = columns(reader.headers().map_err(text)?)?;
    let mut views = Vec::new();
    for record in reader.records() {
        let record = record.map_err(text)?;
        let line = record.position().map_or(1, Position::line);
        if views.len() == MAX_VIEWS {
            return Err(format!("line {line}: more than {MAX_VIEWS} views"));
        }
        let view = view(&record, columns).map_err(|reason| format!("line {line}: {reason}"))?;
        views.push(view);
    }
    if views.is_empty() {
        return Err("has no lines below its header".into());
    }
    Ok(views)
}

/// Where the columns are.
fn columns(header: &StringRecord) -> Checked<[usize; 5]> {
    let mut columns = [0; 5];
    for (column, name) in columns.iter_mut().zip(VIEW_COLUMNS) {
        let place = header.iter().position(|own| own == name);
        *column = place.ok_or_else(|| format!("has no column {name}; valid: {}", VIEW_COLUMNS.join(",")))?;
    }
    Ok(columns)
}

fn view(record: &StringRecord, columns: [usize; 5]) -> Checked<ViewParameters> {
    let mut values = [0.0; 5];
    for ((value, column), name) in values.iter_mut().zip(columns).zip(VIEW_COLUMNS) {
        let text = &record[column];
        *value = text.parse().map_err(|_| format!("{name} is \"{text}\"; valid: a finite number"))?;
    }
    let [alpha, beta, phi, dx, dz] = values;
    let [alpha, beta, phi] = [alpha, beta, phi].map(f64::to_radians);
    let view = ViewParameters { alpha, beta, phi, dx, dz };
    view.validate().map_err(|error| error.to_string())?;
    Ok(view)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<ViewParameters>> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read_views(file.path())
    }

    #[test]
    fn columns_are_found_by_their_names() {
        let text = "# two views\nview,dz_mm,dx_mm,phi_degrees,beta_degrees,alpha_degrees,why\n0,5,4,180,2,1,x\n1,0,0,0,0,0,\n";
        let views = read(text).unwrap();
        let first = ViewParameters {
            alpha: 1_f64.to_radians(),
            beta: 2_f64.to_radians(),
            phi: std::f64::consts::PI,
            dx: 4.0,
            dz: 5.0,
        };
        assert_eq!(views, [first, ViewParameters::default()]);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let refused = |text: &str| read(text).unwrap_err().to_string();
        let header = VIEW_COLUMNS.join(",");
        assert!(refused("alpha_degrees,dx_mm\n1,2\n").contains("has no column beta_degrees"));
        assert!(refused(&header).contains("no lines"));
        let bad = refused(&format!("{header}\n0,0,0,0,0\n0,0,far,0,0\n"));
        assert!(bad.contains("line 3: phi_degrees is \"far\""), "{bad}");
        let bad = refused(&format!("{header}\nnan,0,0,0,0\n"));
        assert!(bad.contains("line 2: alpha is NaN"), "{bad}");
    }

    #[test]
    fn what_is_written_is_read_to_within_rounding() {
        let view = |n: u32| {
            let x = f64::from(n);
            ViewParameters { alpha: 1e-3 * x, beta: -0.01, phi: 0.7 * x, dx: 1.0 / (3.0 + x), dz: -x }
        };
        let views: Vec<_> = (0..20).map(view).collect();
        let file = tempfile::NamedTempFile::new().unwrap();
        write_views(file.path(), &views).unwrap();
        for (own, other) in views.iter().zip(&read_views(file.path()).unwrap()) {
            let mut pairs = own.to_array().into_iter().zip(other.to_array());
            assert!(pairs.all(|(a, b)| (a - b).abs() <= 4.0 * f64::EPSILON * a.abs()));
        }
    }
}
