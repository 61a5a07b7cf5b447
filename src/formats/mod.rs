//! Readers and writers of files: CT volumes, labels, detector poses, tables, images. No physics.
//!
//! Volumes come and go slice by slice, so that a file never needs more memory than one slice. Every output is written
//! under a temporary name in the same folder and renamed when complete: a file that exists is a whole file.

mod colour_picture;
mod ct;
mod ct_volume;
mod curve;
mod data_file;
#[cfg(feature = "dicom")]
mod dicom;
mod error_map;
mod exr;
mod geometry;
mod json_texts;
mod labels;
mod meta_image;
mod mosaic;
mod nifti;
mod nrrd;
mod picture;
mod png;
mod pose_table;
mod raw;
mod replacement;
mod sixteen_bits;
mod slices;
mod stored;
mod tables;
#[cfg(test)]
mod test_volume;
mod text;
mod text_header;
mod tiff;
mod views;

use std::path::Path;

use crate::error::Error;

pub use colour_picture::{ColourPicture, Rgb};
pub use ct::{CtHeader, CtReader, Slice, VoxelKind, is_raw, open_ct};
pub use ct_volume::read_volume;
pub use curve::read_curve;
#[cfg(feature = "dicom")]
pub use dicom::{DicomCt, RtImage, read_rt_image_description, write_rt_image};
pub use error_map::{error_colour, error_map};
pub use exr::{ExrImage, read_exr_metadata, write_exr};
pub use geometry::GeometryFile;
pub use labels::{LabelReader, open_labels};
pub use mosaic::first_column;
pub use nifti::{NiftiVoxel, NiftiWriter, is_nifti};
pub use picture::{Picture, radiograph};
pub use png::{read_png_texts, write_png_gray16};
pub use pose_table::{CArm, PoseTable};
pub use raw::{RawCt, RawLabels, RawLayout, read_raw_f32, write_raw_f32, write_raw_f64};
pub use sixteen_bits::SixteenBits;
pub use stored::{StoredCt, StoredLabels};
pub use tables::{Column, Table, read_detector, read_materials, read_spectrum};
pub use text::write_text;
pub use tiff::{TiffPage, read_tiff_metadata, write_tiff};
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
