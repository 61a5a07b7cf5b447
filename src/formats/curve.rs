//! CSV tables of one number against another. Lines that start with `#` are comments.

use std::path::Path;

use csv::{Position, ReaderBuilder, Trim};

use crate::error::Result;
use crate::formats::{Checked, file_error};

/// Most points of a curve.
const MAX_POINTS: usize = 4096;

/// Reads points `x,y` under a header with these two names. Any finite numbers; what they must be is their user's to check.
///
/// # Errors
/// `File` with the line, for another header, what is no finite number, and for no points or more than 4096.
pub fn read_curve(path: &Path, names: [&str; 2]) -> Result<Vec<[f64; 2]>> {
    parse(path, names).map_err(|reason| file_error(path, reason))
}

fn parse(path: &Path, names: [&str; 2]) -> Checked<Vec<[f64; 2]>> {
    let text = |error: csv::Error| error.to_string();
    let mut reader =
        ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).from_path(path).map_err(text)?;
    let header: Vec<String> = reader.headers().map_err(text)?.iter().map(str::to_owned).collect();
    if header != names {
        return Err(format!("the header is \"{}\"; valid: {}", header.join(","), names.join(",")));
    }
    let mut points = Vec::new();
    for record in reader.records() {
        let record = record.map_err(text)?;
        let line = record.position().map_or(1, Position::line);
        if points.len() == MAX_POINTS {
            return Err(format!("line {line}: more than {MAX_POINTS} points"));
        }
        let number = |n: usize| match record[n].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(format!("line {line}: {} is \"{}\"; valid: a finite number", names[n], &record[n])),
        };
        points.push([number(0)?, number(1)?]);
    }
    if points.is_empty() {
        return Err("has no lines below its header".into());
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<[f64; 2]>> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read_curve(file.path(), ["degrees", "mm"])
    }

    #[test]
    fn points_are_read_as_they_are() {
        let points = read("# a bow-tie\ndegrees, mm\n-10,12.5\n0,1e-3\r\n\n10,12.5\n").unwrap();
        assert_eq!(points, [[-10.0, 12.5], [0.0, 1e-3], [10.0, 12.5]]);
    }

    #[test]
    fn errors_name_the_line() {
        let cases = [
            ("", "valid: degrees,mm"),
            ("angle,mm\n1,2\n", "the header is \"angle,mm\""),
            ("degrees,mm\n", "no lines"),
            ("degrees,mm\n1,2\n2,inf\n", "line 3: mm is \"inf\""),
            ("degrees,mm\n1,2,3\n", "line: 2"),
        ];
        for (text, word) in cases {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(word), "{word}: {message}");
        }
        let long = "degrees,mm\n".to_owned() + &"1,2\n".repeat(MAX_POINTS + 1);
        assert!(read(&long).unwrap_err().to_string().contains("line 4098: more than 4096"));
    }
}
