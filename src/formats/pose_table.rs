//! Tables of cone-beam views. Lines that start with `#` are comments.

use std::collections::HashSet;
use std::path::Path;

use csv::{Position, ReaderBuilder, StringRecord, Trim};
use glam::DVec3;

use crate::error::Result;
use crate::formats::{Checked, file_error};
use crate::geometry::DetectorPose;

/// Columns of a pose, mm in the world: [`DetectorPose`].
const POSE: [&str; 12] = [
    "source_x_mm",
    "source_y_mm",
    "source_z_mm",
    "first_pixel_x_mm",
    "first_pixel_y_mm",
    "first_pixel_z_mm",
    "column_step_x_mm",
    "column_step_y_mm",
    "column_step_z_mm",
    "row_step_x_mm",
    "row_step_y_mm",
    "row_step_z_mm",
];
/// Columns of a C-arm's view; all but the first may be absent.
const C_ARM: [&str; 7] =
    ["angle_degrees", "sad_mm", "sdd_mm", "pixel_mm", "offset_x_mm", "offset_y_mm", "offset_z_mm"];
/// Those of them that are lengths.
const POSITIVE: [&str; 3] = ["sad_mm", "sdd_mm", "pixel_mm"];
const NAME: &str = "name";

/// Most views of a table.
const MAX_VIEWS: usize = 1_000_000;
/// Most characters of a name: what is added to it must fit a file's name.
const MAX_NAME: usize = 100;

/// The C-arm that a table's views are of, where it has no columns for them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CArm {
    /// What it turns about, mm in the world; a view's offset is added.
    pub centre: DVec3,
    /// Columns and rows of pixels.
    pub size: [usize; 2],
    /// From the source to the axis, mm.
    pub sad_mm: f64,
    /// From the source to the detector, mm.
    pub sdd_mm: f64,
    /// From pixel to pixel, mm.
    pub pixel_mm: f64,
}

/// One cone-beam view per line of a CSV file.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseTable {
    /// Where source and detector are; at least one.
    pub poses: Vec<DetectorPose>,
    /// What the views are called, where the table has a column for it: letters, digits, `.`, `_` and `-`, which can begin a
    /// file's name. No two are the same, also where a file system does not tell capitals from small letters.
    pub names: Option<Vec<String>>,
}

impl PoseTable {
    /// Reads a table with a header line, columns in any order: either `angle_degrees` of a C-arm as in
    /// [`DetectorPose::c_arm`], with `sad_mm`, `sdd_mm` and `pixel_mm` where they are not those of `c_arm`, and `offset_x_mm`,
    /// `offset_y_mm` and `offset_z_mm` of its centre where they are not 0; or the twelve of a pose: `source_x_mm`, …,
    /// `first_pixel_x_mm`, …, `column_step_x_mm`, …, `row_step_x_mm`, …. With either a column `name` may stand.
    ///
    /// # Errors
    /// `File`, with line and column, for what is not such a table: a column that is not known, because it may be mistyped, too;
    /// for no views or more than a million.
    pub fn read(path: &Path, c_arm: &CArm) -> Result<Self> {
        parse(path, c_arm).map_err(|reason| file_error(path, reason))
    }
}

fn parse(path: &Path, c_arm: &CArm) -> Checked<PoseTable> {
    let text = |error: csv::Error| error.to_string();
    let mut reader =
        ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).from_path(path).map_err(text)?;
    let header = reader.headers().map_err(text)?;
    let columns = Columns::of(header).map_err(|reason| format!("line {}: {reason}", line(header)))?;
    let mut poses = Vec::new();
    let mut names = columns.name.map(|_| Vec::new());
    let mut taken = HashSet::new();
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(text)? {
        let at = |reason: String| format!("line {}: {reason}", line(&record));
        if poses.len() == MAX_VIEWS {
            return Err(at(format!("more than {MAX_VIEWS} views; valid: 1 … {MAX_VIEWS}")));
        }
        poses.push(columns.pose(&record, c_arm).map_err(at)?);
        if let Some((names, column)) = names.as_mut().zip(columns.name) {
            let name = name(&record[column]).map_err(at)?;
            if !taken.insert(name.to_ascii_lowercase()) {
                return Err(at(format!(
                    "{NAME} is \"{name}\" as in a line before; valid: names that differ"
                )));
            }
            names.push(name.to_owned());
        }
    }
    if poses.is_empty() {
        return Err("has no lines below its header".into());
    }
    Ok(PoseTable { poses, names })
}

/// Where the columns are.
struct Columns {
    given: Given,
    name: Option<usize>,
}

/// What a table's views are given by.
enum Given {
    Pose([usize; 12]),
    CArm([Option<usize>; 7]),
}

impl Columns {
    fn of(header: &StringRecord) -> Checked<Self> {
        let place = |name: &str| header.iter().position(|own| own == name);
        for (n, name) in header.iter().enumerate() {
            if place(name) != Some(n) {
                return Err(format!(
                    "column {} repeats the name \"{name}\"; valid: names that differ",
                    n + 1
                ));
            }
            if name != NAME && !POSE.contains(&name) && !C_ARM.contains(&name) {
                let valid = [&[NAME], &C_ARM[..], &POSE].concat().join(", ");
                return Err(format!("column {} is \"{name}\"; valid: {valid}", n + 1));
            }
        }
        let [poses, c_arm] = [POSE.map(place).to_vec(), C_ARM.map(place).to_vec()];
        let given = if poses.iter().all(Option::is_none) {
            let columns = C_ARM.map(place);
            if columns[0].is_none() {
                return Err(format!("has no column {}; valid: with it, or the twelve of a pose", C_ARM[0]));
            }
            Given::CArm(columns)
        } else {
            if let Some(n) = c_arm.iter().position(Option::is_some) {
                return Err(format!("has columns of a pose and {}; valid: either", C_ARM[n]));
            }
            let mut columns = [0; 12];
            for ((column, place), name) in columns.iter_mut().zip(poses).zip(POSE) {
                *column =
                    place.ok_or_else(|| format!("has no column {name}; valid: all twelve of a pose"))?;
            }
            Given::Pose(columns)
        };
        Ok(Self { given, name: place(NAME) })
    }

    fn pose(&self, record: &StringRecord, c_arm: &CArm) -> Checked<DetectorPose> {
        let pose = match &self.given {
            Given::Pose(columns) => {
                let mut values = [0.0; 12];
                for ((value, &column), name) in values.iter_mut().zip(columns).zip(POSE) {
                    *value = number(&record[column], name)?;
                }
                let vectors = values.as_chunks().0;
                let [source, first_pixel, column_step, row_step] =
                    [0, 1, 2, 3].map(|n: usize| DVec3::from_array(vectors[n]));
                DetectorPose { source, first_pixel, column_step, row_step }
            }
            Given::CArm(columns) => {
                let mut values = [0.0, c_arm.sad_mm, c_arm.sdd_mm, c_arm.pixel_mm, 0.0, 0.0, 0.0];
                for ((value, &column), name) in values.iter_mut().zip(columns).zip(C_ARM) {
                    if let Some(column) = column {
                        *value = number(&record[column], name)?;
                    }
                }
                let [angle, sad, sdd, pixel, x, y, z] = values;
                let centre = c_arm.centre + DVec3::new(x, y, z);
                DetectorPose::c_arm(centre, angle, sad, sdd, pixel, c_arm.size)
            }
        };
        pose.validate().map(|()| pose).map_err(|error| error.to_string())
    }
}

fn line(record: &StringRecord) -> u64 {
    record.position().map_or(1, Position::line)
}

fn number(text: &str, name: &str) -> Checked<f64> {
    let positive = POSITIVE.contains(&name);
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && (value > 0.0 || !positive) => Ok(value),
        _ => {
            let valid = if positive { "a number above 0" } else { "a finite number" };
            Err(format!("{name} is \"{text}\"; valid: {valid}"))
        }
    }
}

/// What is no path, no hidden file and no option, on any system.
fn name(text: &str) -> Checked<&str> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    let begins = text.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
    if begins && text.len() <= MAX_NAME && text.chars().all(plain) {
        return Ok(text);
    }
    Err(format!(
        "{NAME} is \"{}\"; valid: 1 … {MAX_NAME} of A-Z, a-z, 0-9, \".\", \"_\" and \"-\", not \".\" or \"-\" first",
        text.escape_debug()
    ))
}

#[cfg(test)]
mod tests;
