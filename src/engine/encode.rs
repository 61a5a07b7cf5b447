//! Projections that are put into a queue of the caller's, with images that stay on the device.

use std::ffi::c_void;

use crate::engine::{Backend, Layers};
use crate::error::Error;

/// Where the layers go on the device; null for what is not wanted. Arrays are as those of
/// [`Images`](crate::engine::Images).
///
/// | | `cuda` | `metal` |
/// |---|---|---|
/// | queue | `CUstream` of the device's primary context; null: the default stream | `id<MTLCommandBuffer>` |
/// | array | `CUdeviceptr` | `id<MTLBuffer>`, from its first byte on |
/// | texture | null | `id<MTLTexture>` of `R32Float`: 2D for one view, 2D array for several |
///
/// They must be large enough for all views, and stay until the queue has run the projection.
#[derive(Debug, Clone, Copy)]
pub struct DeviceOutputs {
    /// See [`Images::intensity`](crate::engine::Images::intensity).
    pub intensity: *mut c_void,
    /// See [`Images::line_integral`](crate::engine::Images::line_integral).
    pub line_integral: *mut c_void,
    /// See [`Images::areal_density`](crate::engine::Images::areal_density).
    pub areal_density: *mut c_void,
    /// See [`Images::bone_path`](crate::engine::Images::bone_path).
    pub bone_path: *mut c_void,
    /// The intensity once more, to be looked at.
    pub intensity_texture: *mut c_void,
}

impl DeviceOutputs {
    /// The layers that have a place.
    pub fn layers(&self) -> Layers {
        Layers {
            intensity: !self.intensity.is_null() || !self.intensity_texture.is_null(),
            line_integral: !self.line_integral.is_null(),
            areal_density: !self.areal_density.is_null(),
            bone_path: !self.bone_path.is_null(),
        }
    }
}

/// What an engine without queues answers.
pub(crate) fn unsupported_queues() -> Error {
    let queues = [Backend::Cuda, Backend::Metal].map(Backend::name).join(" and ");
    Error::Unsupported(format!("only the engines {queues} have queues to put a projection into"))
}
