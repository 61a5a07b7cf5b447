//! NRRD (`.nrrd`, `.nhdr`): a header of lines `field: value`, with the voxels behind it or in another file.
//!
//! As version 5 of the format's definition has it (Teem).

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use crate::error::Result;
use crate::formats::stored::{Array, Coding, Source, Storage, StoredVolume};
use crate::formats::text_header::{TextHeader, numbers};
use crate::formats::{Checked, data_file, file_error, has_ending};
use crate::geometry::Grid;

/// What a file starts with, before the version.
const MAGIC: &str = "NRRD000";

/// Whether the file's name is that of an NRRD.
pub(super) fn is_nrrd(path: &Path) -> bool {
    has_ending(path, &[".nrrd", ".nhdr"])
}

/// Opens a file.
pub(super) fn open(path: &Path) -> Result<StoredVolume> {
    let fail = |reason: String| file_error(path, reason);
    let header = TextHeader::read(path, split, str::is_empty).map_err(fail)?;
    if header.get(&[MAGIC]).is_none() {
        return Err(fail(format!("is not NRRD: it doesn't start with {MAGIC}")));
    }
    let mut array = array(&header).map_err(fail)?;
    let coding = match header.required("encoding").map_err(fail)?.to_lowercase().as_str() {
        "raw" => Coding::Plain,
        "gzip" | "gz" => Coding::Gzip,
        other => return Err(fail(format!("encoding is {other}; valid: raw, gzip"))),
    };
    let [lines] = header.numbers(&["line skip", "lineskip"], Some([0_u64])).map_err(fail)?;
    if lines != 0 {
        return Err(fail(format!("line skip is {lines}; valid: 0")));
    }
    let (file, mut start) = match header.get(&["data file", "datafile"]) {
        None => (path.to_owned(), header.bytes),
        Some(name) => (data_file::named(path, "data file", name).map_err(fail)?, 0),
    };
    let [skipped] = header.numbers(&["byte skip", "byteskip"], Some([0])).map_err(fail)?;
    let first = data_file::start(&file, "byte skip", skipped, coding, &array).map_err(fail)?;
    // Of what is compressed, bytes are skipped when it is expanded.
    if skipped >= 0 {
        array.offset = first;
    } else {
        start = first;
    }
    StoredVolume::new(&file, Source::File, start, coding, array)
}

/// A field and its value; the magic is one of its own; remarks and keys of users are none.
fn split(line: &str) -> Checked<Option<(&str, &str)>> {
    if let Some(version) = line.strip_prefix(MAGIC) {
        return Ok(Some((MAGIC, version)));
    }
    if line.starts_with('#') || line.contains(":=") {
        return Ok(None);
    }
    line.split_once(": ")
        // A field without a value, as lines are trimmed.
        .or_else(|| Some((line.strip_suffix(':')?, "")))
        .map(Some)
        .ok_or_else(|| format!("is not NRRD: it has {line:?} in its header; valid: field: value"))
}

fn array(header: &TextHeader) -> Checked<Array> {
    let [dimension]: [u32; 1] = header.numbers(&["dimension"], None)?;
    if dimension != 3 {
        return Err(format!("dimension is {dimension}; valid: 3"));
    }
    let kinds = header.get(&["kinds"]).unwrap_or_default();
    if let Some(kind) =
        kinds.split_whitespace().find(|kind| !["domain", "space", "???", "none"].contains(kind))
    {
        return Err(format!("kinds has {kind}; valid: domain, space: one number to a voxel"));
    }
    let grid =
        Grid::new(header.numbers(&["sizes"], None)?, index_to_world(header)?).map_err(|e| e.to_string())?;
    let kind = header.required("type")?;
    let storage = storage(kind)
        .ok_or_else(|| format!("type is {kind}; valid: integers of 8 to 64 bits, float, double"))?;
    let big_endian = match header.get(&["endian"]).map(str::to_lowercase).as_deref() {
        Some("big") => true,
        Some("little") => false,
        None if storage.bytes() == 1 => false,
        None => return Err("has no endian".to_owned()),
        Some(other) => return Err(format!("endian is {other}; valid: little, big")),
    };
    Ok(Array { grid, storage, big_endian, slope: 1.0, intercept: 0.0, offset: 0 })
}

fn index_to_world(header: &TextHeader) -> Checked<DAffine3> {
    // The signs that make it LPS.
    let valid = "left-posterior-superior (LPS), right-anterior-superior (RAS), left-anterior-superior (LAS)";
    let space = header.get(&["space"]).ok_or_else(|| format!("has no space; valid: {valid}"))?;
    let signs = match space.to_lowercase().as_str() {
        "left-posterior-superior" | "lps" => DVec3::ONE,
        "right-anterior-superior" | "ras" => DVec3::new(-1.0, -1.0, 1.0),
        "left-anterior-superior" | "las" => DVec3::new(1.0, -1.0, 1.0),
        other => return Err(format!("space is {other}; valid: {valid}")),
    };
    let units = header.get(&["space units"]).unwrap_or_default();
    if units.split_whitespace().any(|unit| unit.trim_matches('"') != "mm") {
        return Err(format!("space units are {units}; valid: mm"));
    }
    let text = header.required("space directions")?;
    let directions: [DVec3; 3] = vectors(text)
        .and_then(|vectors| vectors.try_into().ok())
        .ok_or_else(|| format!("space directions are {text:?}; valid: three vectors of three numbers"))?;
    let text = header.get(&["space origin"]).unwrap_or("(0,0,0)");
    let origin: [DVec3; 1] = vectors(text)
        .and_then(|vectors| vectors.try_into().ok())
        .ok_or_else(|| format!("space origin is {text:?}; valid: a vector of three numbers"))?;
    let [x, y, z] = directions.map(|direction| signs * direction);
    Ok(DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: signs * origin[0] })
}

/// Vectors in parentheses, their numbers with commas between them.
fn vectors(text: &str) -> Option<Vec<DVec3>> {
    let (closed, rest) = text.trim().rsplit_once(')')?;
    let vector =
        |part: &str| numbers(&part.trim().strip_prefix('(')?.replace(',', " ")).map(DVec3::from_array);
    if rest.is_empty() { closed.split(')').map(vector).collect() } else { None }
}

fn storage(kind: &str) -> Option<Storage> {
    Some(match kind {
        "signed char" | "int8" | "int8_t" => Storage::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Storage::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Storage::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Storage::U16,
        "int" | "signed int" | "int32" | "int32_t" => Storage::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Storage::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Storage::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Storage::U64,
        "float" => Storage::F32,
        "double" => Storage::F64,
        _ => return None,
    })
}

#[cfg(test)]
mod tests;
