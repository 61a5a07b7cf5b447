//! What the engines that run the kernel text share: the text and its definitions, the wire structs, voxels and tables as
//! the kernel reads them.

mod beam;
mod definitions;
mod few;
pub(crate) mod parallel;
mod prepared;
mod programs;
mod spectra;
mod text;
#[cfg(any(feature = "cuda", target_vendor = "apple"))]
mod volumes;
mod voxels;
pub(crate) mod wire;

pub(crate) use definitions::Definitions;
pub(crate) use prepared::{Prepared, Views};
pub(crate) use programs::Programs;
pub(crate) use text::Kernel;
#[cfg(any(feature = "cuda", target_vendor = "apple"))]
pub(crate) use volumes::Volumes;
pub(crate) use voxels::{DeviceVoxels, Layout, Slab};
