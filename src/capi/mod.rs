//! The C ABI. Its reference is `include/DRR_Shared.h`, generated from the doc comments here.
//!
//! One file per noun; each function checks, converts and delegates, and computes nothing. `boundary` turns errors
//! and panics into a status; `handle`, `options` and `memory` are the only readers and writers of what a caller
//! points to.
#![allow(unsafe_code, reason = "the boundary to C")]
#![allow(
    clippy::missing_safety_doc,
    reason = "the doc comments are the C header's and state every pointer's contract"
)]
#![allow(
    clippy::doc_markdown,
    rustdoc::broken_intra_doc_links,
    rustdoc::invalid_html_tags,
    reason = "written for C"
)]

mod boundary;
mod handle;
mod lut;
mod memory;
mod motion;
mod names;
mod normal_equations;
mod options;
mod parallel_calls;
mod pose_gradient_calls;
mod progress;
mod ray_transform_calls;
mod spectra;

pub mod blur;
pub mod certificate;
pub mod context;
pub mod effects;
pub mod encode;
pub mod exposure;
pub mod filter;
pub mod geometry;
pub mod implant;
pub mod metal;
pub mod outputs;
pub mod parallel;
pub mod parallel_f64;
pub mod parallel_geometry;
pub mod physics;
pub mod pose_gradient;
pub mod pose_gradient_f64;
pub mod projector;
pub mod ray_transform;
pub mod ray_transform_f64;
pub mod raycast;
pub mod raycast_view;
pub mod reference;
pub mod scene;
pub mod status;
pub mod version;
pub mod volume;
pub mod volume_file;
