//! The kernel text, flattened for compilers that have no folder to include from. `build.rs` makes it of `shaders/`.

/// For Metal.
#[cfg(target_vendor = "apple")]
pub(crate) const METAL: &str = include_str!(concat!(env!("OUT_DIR"), "/drr.metal"));

/// For NVIDIA's run-time compiler.
#[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
pub(crate) const CUDA: &str = include_str!(concat!(env!("OUT_DIR"), "/drr.cu"));

/// For a C++17 compiler of the host.
#[cfg(feature = "host")]
pub(crate) const HOST: &str = include_str!(concat!(env!("OUT_DIR"), "/host.cpp"));
