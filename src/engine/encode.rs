//! Where an engine on a GPU leaves its layers, when the caller's queue runs them.

use std::ffi::c_void;

/// The caller's device memory for each layer; null for what is not wanted. CUDA: device pointers. Metal: `id<MTLBuffer>`,
/// and for `intensity_texture` an `id<MTLTexture>`. Laid out as [`Images`](crate::engine::Images).
#[derive(Debug, Clone, Copy)]
pub struct DeviceOutputs {
    /// Detector signal.
    pub intensity: *mut c_void,
    /// −ln(I/I0).
    pub line_integral: *mut c_void,
    /// g/cm² by material.
    pub areal_density: *mut c_void,
    /// mm.
    pub bone_path_mm: *mut c_void,
    /// Detector signal once more. Only on Metal.
    pub intensity_texture: *mut c_void,
}
