//! MetaImage (`.mha`, `.mhd`): a header of lines `Name = value`, with the voxels behind it or in another file.
//!
//! As the documentation of MetaIO has it; the world is LPS, mm.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use crate::error::Result;
use crate::formats::stored::{Array, Coding, Source, Storage, StoredVolume};
use crate::formats::text_header::TextHeader;
use crate::formats::{Checked, data_file, file_error, has_ending};
use crate::geometry::Grid;

/// The field that ends the header: where the voxels are.
const DATA_FILE: &str = "ElementDataFile";

/// Whether the file's name is that of a MetaImage.
pub(super) fn is_meta_image(path: &Path) -> bool {
    has_ending(path, &[".mha", ".mhd"])
}

/// Opens a file.
pub(super) fn open(path: &Path) -> Result<StoredVolume> {
    let fail = |reason: String| file_error(path, reason);
    let header = TextHeader::read(path, split, |line| line.starts_with(DATA_FILE)).map_err(fail)?;
    let array = array(&header).map_err(fail)?;
    let coding = if flag(&header, &["CompressedData"]).map_err(fail)? { Coding::Zlib } else { Coding::Plain };
    let file = header.required(DATA_FILE).map_err(fail)?;
    let [skipped] = header.numbers::<i64, 1>(&["HeaderSize"], Some([0])).map_err(fail)?;
    if file.eq_ignore_ascii_case("LOCAL") {
        if skipped != 0 {
            return Err(fail(format!("HeaderSize is {skipped}, with voxels behind the header; valid: 0")));
        }
        return StoredVolume::new(path, Source::File, header.bytes, coding, array);
    }
    let file = data_file::named(path, DATA_FILE, file).map_err(fail)?;
    let start = data_file::start(&file, "HeaderSize", skipped, coding, &array).map_err(fail)?;
    StoredVolume::new(&file, Source::File, start, coding, array)
}

/// A field and its value.
fn split(line: &str) -> Checked<Option<(&str, &str)>> {
    let wrong = || format!("is not MetaImage: it has {line:?} in its header; valid: Name = value");
    line.split_once('=').map(Some).ok_or_else(wrong)
}

fn array(header: &TextHeader) -> Checked<Array> {
    let [rank]: [u32; 1] = header.numbers(&["NDims"], None)?;
    if rank != 3 {
        return Err(format!("NDims is {rank}; valid: 3"));
    }
    let [channels]: [u32; 1] = header.numbers(&["ElementNumberOfChannels"], Some([1]))?;
    if channels != 1 {
        return Err(format!("ElementNumberOfChannels is {channels}; valid: 1"));
    }
    if !flag(header, &["BinaryData"])? && header.get(&["BinaryData"]).is_some() {
        return Err("BinaryData is False: voxels are text; valid: True".to_owned());
    }
    if let Some(unit) = header.get(&["DistanceUnits"]).filter(|unit| !["mm", "?"].contains(unit)) {
        return Err(format!("DistanceUnits is {unit}; valid: mm"));
    }
    let dimensions = header.numbers(&["DimSize"], None)?;
    let spacing = DVec3::from_array(header.numbers(&["ElementSpacing", "ElementSize"], Some([1.0; 3]))?);
    // The directions of the axes one after the other, although it is written as a matrix.
    let identity = DMat3::IDENTITY.to_cols_array();
    let directions = header.numbers(&["TransformMatrix", "Orientation", "Rotation"], Some(identity))?;
    let directions = DMat3::from_cols_array(&directions);
    let translation = DVec3::from_array(header.numbers(&["Offset", "Position", "Origin"], Some([0.0; 3]))?);
    // The centre of rotation is for editors: the offset is the first voxel's place whatever it is.
    let map = DAffine3 { matrix3: directions * DMat3::from_diagonal(spacing), translation };
    let grid = Grid::new(dimensions, map).map_err(|e| e.to_string())?;
    let kind = header.required("ElementType")?;
    let storage = storage(kind).ok_or_else(|| {
        format!("ElementType is {kind}; valid: MET_CHAR, MET_UCHAR, … MET_LONG_LONG, MET_ULONG_LONG, MET_FLOAT, MET_DOUBLE")
    })?;
    let big_endian = flag(header, &["BinaryDataByteOrderMSB", "ElementByteOrderMSB"])?;
    Ok(Array { grid, storage, big_endian, slope: 1.0, intercept: 0.0, offset: 0 })
}

/// Longs have four bytes in files, on any machine.
fn storage(kind: &str) -> Option<Storage> {
    Some(match kind {
        "MET_CHAR" => Storage::I8,
        "MET_UCHAR" => Storage::U8,
        "MET_SHORT" => Storage::I16,
        "MET_USHORT" => Storage::U16,
        "MET_INT" | "MET_LONG" => Storage::I32,
        "MET_UINT" | "MET_ULONG" => Storage::U32,
        "MET_LONG_LONG" => Storage::I64,
        "MET_ULONG_LONG" => Storage::U64,
        "MET_FLOAT" => Storage::F32,
        "MET_DOUBLE" => Storage::F64,
        _ => return None,
    })
}

fn flag(header: &TextHeader, names: &[&str]) -> Checked<bool> {
    match header.get(names).map(str::to_lowercase).as_deref() {
        None | Some("false" | "0") => Ok(false),
        Some("true" | "1") => Ok(true),
        Some(other) => Err(format!("{} is {other}; valid: True, False", names[0])),
    }
}

#[cfg(test)]
mod tests;
