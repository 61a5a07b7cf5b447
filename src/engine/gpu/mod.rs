//! What the engines that run the kernel text share: the text and its definitions, the wire structs, voxels and tables as
//! the kernel reads them.

mod beam;
mod definitions;
mod occupancy;
mod prepared;
mod spectra;
mod text;
mod voxels;
pub(crate) mod wire;

pub(crate) use definitions::Definitions;
pub(crate) use prepared::{Prepared, Views};
#[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
pub(crate) use text::CUDA as CUDA_TEXT;
#[cfg(feature = "host")]
pub(crate) use text::HOST as HOST_TEXT;
#[cfg(target_vendor = "apple")]
pub(crate) use text::METAL as METAL_TEXT;
pub(crate) use voxels::{DeviceVoxels, Layout, Slab};
