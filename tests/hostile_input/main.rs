//! Hostile input does no harm: what the fuzz targets in `tests/fuzz` found, and what was written by hand to break
//! things, goes through the same checks.
#![allow(missing_docs, reason = "a test program")]

mod c_boundary;
#[cfg(feature = "formats")]
mod ct;
#[cfg(feature = "dicom")]
mod dicom;
#[cfg(feature = "formats")]
mod file;
#[cfg(feature = "formats")]
mod geometry;
#[cfg(feature = "formats")]
mod labels;
#[cfg(feature = "formats")]
mod nifti;
#[cfg(feature = "formats")]
mod pose_table;
#[cfg(feature = "formats")]
mod tables;
#[cfg(feature = "formats")]
mod text_headers;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Gives every file of `cases/target` to `check`. Those whose names start with `valid` must be accepted, all others
/// refused: a case that no longer is what its name says is found out.
fn replay(target: &str, check: fn(&[u8]) -> bool) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hostile_input/cases").join(target);
    let mut paths: Vec<_> =
        std::fs::read_dir(&folder).expect("the cases").map(|entry| entry.expect("a case").path()).collect();
    paths.sort();
    assert!(!paths.is_empty());
    for path in paths {
        let bytes = std::fs::read(&path).expect("a case can be read");
        let passed = catch_unwind(AssertUnwindSafe(|| check(&bytes)));
        let valid = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("valid"));
        assert!(passed.is_ok(), "{} does harm", path.display());
        assert_eq!(passed.ok(), Some(valid), "{} is what its name says", path.display());
    }
}

#[test]
fn at_the_c_boundary() {
    replay("c_boundary", c_boundary::check);
}

#[cfg(feature = "formats")]
#[test]
fn in_nifti_files() {
    replay("nifti", nifti::check);
}

#[cfg(feature = "formats")]
#[test]
fn in_labels() {
    replay("labels", labels::check);
}

#[cfg(feature = "formats")]
#[test]
fn in_geometry_files() {
    replay("geometry", geometry::check);
}

#[cfg(feature = "formats")]
#[test]
fn in_tables_of_views() {
    replay("pose_table", pose_table::check);
}

#[cfg(feature = "formats")]
#[test]
fn in_tables() {
    replay("tables", tables::check);
}

#[cfg(feature = "dicom")]
#[test]
fn in_dicom_files() {
    replay("dicom", dicom::check);
}

#[cfg(feature = "formats")]
#[test]
fn in_text_headers() {
    replay("text_headers", text_headers::check);
}
