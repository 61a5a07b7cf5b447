//! What an engine on a device measures of itself.

/// Times by the device's own clock where it has one, and what the kernel takes of the device.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Timings {
    /// Making and copying the volume's voxels, s. Projectors of one volume share them.
    pub upload_seconds: f64,
    /// Memory of the volume on the device.
    pub volume_bytes: usize,
    /// Compiling the kernel that ran last, s. It is kept, and compiled once.
    pub compile_seconds: f64,
    /// All launches of the projection that ended last, without copies, s.
    pub kernel_seconds: f64,
    /// Registers of a thread of the kernel that ran last.
    pub registers: u32,
    /// Memory of such a thread for what its registers do not hold: spills, and arrays with computed indices.
    pub local_bytes: u32,
}
