//! What the engines that run the kernel text share: the text and its definitions, the wire structs, voxels and tables as
//! the kernel reads them.

mod beam;
mod definitions;
mod few;
mod occupancy;
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
#[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
pub(crate) use text::CUDA as CUDA_TEXT;
#[cfg(feature = "host")]
pub(crate) use text::HOST as HOST_TEXT;
#[cfg(target_vendor = "apple")]
pub(crate) use text::METAL as METAL_TEXT;
#[cfg(any(feature = "cuda", target_vendor = "apple"))]
pub(crate) use volumes::Volumes;
pub(crate) use voxels::{DeviceVoxels, Layout, Slab};
