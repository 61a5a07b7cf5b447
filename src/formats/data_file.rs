//! The file in which the voxels of a text header are.

use std::path::{Path, PathBuf};

use crate::formats::Checked;
use crate::formats::stored::{Array, Coding};

/// The one file that a header's `field` names: beside the header, unless its path is absolute.
pub(super) fn named(header: &Path, field: &str, name: &str) -> Checked<PathBuf> {
    if name.starts_with("LIST") || name.contains('%') {
        return Err(format!("{field} is {name}: a file for each slice; valid: one file"));
    }
    Ok(header.parent().unwrap_or(Path::new("")).join(name))
}

/// Where the voxels start in a file of which `field` says how many bytes are skipped: −1 where they are its end.
pub(super) fn start(file: &Path, field: &str, skipped: i64, coding: Coding, array: &Array) -> Checked<u64> {
    match u64::try_from(skipped) {
        Ok(skipped) => Ok(skipped),
        Err(_) if skipped == -1 && coding == Coding::Plain => {
            let length = std::fs::metadata(file).map_err(|e| format!("{}: {e}", file.display()))?.len();
            Ok(length.saturating_sub(array.bytes()))
        }
        Err(_) => Err(format!("{field} is {skipped}; valid: 0 and more, or -1 where nothing is compressed")),
    }
}
