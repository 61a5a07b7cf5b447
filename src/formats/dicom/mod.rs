//! DICOM: CTs, as a series of files or one object with several frames, are read; radiographs are written as RT Images.
//!
//! Opening reads headers only, reading one slice at a time. References are to the parts of the DICOM standard (PS3).

mod attributes;
mod codecs;
mod ct;
mod data_set;
mod file;
mod files;
mod fragments;
mod object;
mod pixels;
mod plane;
mod rt_image;
mod series;
mod stack;
mod stored;
mod syntax;

pub use ct::DicomCt;
pub(super) use file::is_dicom;
pub use rt_image::{RtImage, read_rt_image_description, write_rt_image};
