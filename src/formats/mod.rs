//! Readers and writers of files: CT volumes, labels, detector poses, tables, images. No physics.
//!
//! Volumes come and go slice by slice, so that a file never needs more memory than one slice. Every output is written
//! under a temporary name in the same folder and renamed when complete: a file that exists is a whole file.

mod colour_picture;
mod ct;
mod ct_volume;
mod curve;
mod error_map;
mod exr;
mod geometry;
mod labels;
mod mosaic;
mod nifti;
mod picture;
mod png;
mod pose_table;
mod raw;
mod replacement;
mod slices;
mod tables;
mod text;
mod views;

use std::path::Path;

use crate::error::Error;

pub use colour_picture::{ColourPicture, Rgb};
pub use ct::{CtHeader, CtReader, Slice, VoxelKind, open_ct};
pub use ct_volume::read_volume;
pub use curve::read_curve;
pub use error_map::{error_colour, error_map};
pub use exr::{ExrImage, read_exr_metadata, write_exr};
pub use geometry::GeometryFile;
pub use labels::{LabelReader, open_labels};
pub use mosaic::first_column;
pub use nifti::{NiftiCt, NiftiLabels, NiftiVoxel, NiftiWriter};
pub use picture::{Picture, radiograph};
pub use png::{write_png_gray8, write_png_gray16, write_png_rgb8};
pub use pose_table::{CArm, PoseTable};
pub use raw::{RawCt, RawLabels, RawLayout, read_raw_f32, write_raw_f32, write_raw_f64};
pub use tables::{Column, Table, read_detector, read_materials, read_spectrum};
pub use text::write_text;
pub use views::{VIEW_COLUMNS, read_views, write_views};

/// A result whose error is the reason alone; the caller adds the path.
type Checked<T> = std::result::Result<T, String>;

/// A file that cannot be read or written, or is not what it claims to be.
#[allow(clippy::needless_pass_by_value, reason = "errors of many types are handed over where they arise")]
fn file_error(path: &Path, reason: impl ToString) -> Error {
    Error::File { path: path.display().to_string(), reason: reason.to_string() }
}

/// Whether the file's name ends in one of the endings, in any case.
fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    endings.iter().any(|ending| name.ends_with(ending))
}
