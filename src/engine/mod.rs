//! Engines execute a plan. They share the plan and the rays, and nothing else.

pub mod cpu;
#[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
mod cuda;
mod device;
mod encode;
#[cfg_attr(
    not(any(feature = "cuda", feature = "host", target_vendor = "apple")),
    allow(dead_code, unused_imports, reason = "none of its engines is built")
)]
pub(crate) mod gpu;
#[cfg(feature = "host")]
pub mod host;
mod images;
#[cfg(target_vendor = "apple")]
mod metal;
mod progress;
pub mod reference;
mod signals;
mod timings;

use std::ffi::c_void;
use std::sync::Arc;

pub(crate) use device::Device;
pub use device::DeviceChoice;
pub use encode::DeviceOutputs;
pub(crate) use encode::unsupported_queues;
pub use images::{Images, Layers};
pub use progress::{Progress, Report, SILENT};
pub use signals::{MAX_BEFORE, MAX_SIGNALS, Passed, SignalsJob};
pub use timings::Timings;

use crate::error::{Error, Result};
use crate::physics::SpectralModel;
use crate::raycast::Beam;
use crate::shared::DrrAddress;
use crate::volume::{Volume, Voxels};

/// Which engine runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// float64, single algorithmic steps, no shortcuts: the truth, slow.
    Reference,
    /// float32 on all cores, by the best vector instructions of the machine, which decide the last bits of rays that are swept
    /// together. The environment variable `DRR_SIMD` = `sse2`, `avx2`, `avx512`, `neon` or `portable` takes others of those there are.
    Cpu,
    /// The GPU kernels' text, compiled for the host by this machine's C++ compiler when it is first used: to see what a
    /// GPU computes where there is none. Needs the feature `host`.
    Host,
    /// float32 on an NVIDIA GPU. Needs the feature `cuda`, and NVIDIA's driver and run-time compiler on the machine.
    Cuda,
    /// float32 on an Apple GPU. Needs macOS.
    Metal,
}

impl Backend {
    /// Every engine, there or not.
    pub const ALL: [Self; 5] = [Self::Reference, Self::Cpu, Self::Host, Self::Cuda, Self::Metal];

    /// The engines of which the best that is there is taken, best first. The last one always is.
    pub(crate) const BEST_FIRST: [Self; 3] = [Self::Metal, Self::Cuda, Self::Cpu];

    /// The name on command lines and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Cpu => "cpu",
            Self::Host => "host",
            Self::Cuda => "cuda",
            Self::Metal => "metal",
        }
    }

    /// Whether its work is done by a GPU.
    pub(crate) fn has_device(self) -> bool {
        matches!(self, Self::Cuda | Self::Metal)
    }

    /// # Errors
    /// `Unsupported` when the volume is where this engine cannot read it.
    pub(crate) fn check_reads(self, volume: &Volume) -> Result<()> {
        match volume.voxels() {
            Voxels::Texture { .. } if self != Self::Metal => {
                let text =
                    format!("the volume is in a texture, which the engine {} cannot read", self.name());
                Err(Error::Unsupported(text))
            }
            _ => Ok(()),
        }
    }
}

/// One view of a job.
#[derive(Debug, Clone)]
pub struct ViewJob {
    /// Its rays.
    pub beam: Beam,
    /// Whether a ray may stop once what is left is below e⁻¹⁵ of I0. An engine may ignore it, and does unless intensity is the
    /// only layer asked for that the stop would change.
    pub early_exit: bool,
    /// Spectral tables of this view alone, instead of the scene's.
    pub spectral: Option<Arc<SpectralModel>>,
    /// Where Metal finds tables of this view alone, as in [`ProjectionUniforms`](crate::shared): spectrum, mass
    /// attenuation; 0: the scene's.
    pub lut_addresses: [DrrAddress; 2],
}

impl ViewJob {
    /// Whether the view brings no spectral tables of its own.
    pub(crate) fn has_the_scene_s_tables(&self) -> bool {
        self.spectral.is_none() && self.lut_addresses == [0, 0]
    }
}

/// What an engine is asked to do.
pub struct Job<'a> {
    /// The views.
    pub views: &'a [ViewJob],
    /// The layers to return.
    pub layers: Layers,
    /// Where finished rays are reported.
    pub progress: Progress<'a>,
}

/// An engine that has been made ready for one plan and one volume.
pub trait Engine: Send + Sync {
    /// Projects all views of the job.
    ///
    /// # Errors
    /// `Cancelled` once the job's progress says so: each thread finishes at most one more piece of work; `OutOfMemory`.
    fn project(&self, job: &Job<'_>) -> Result<Images<f32>>;

    /// Whether it ever takes sums by several rows of weights: what a job for them needs is made only then.
    fn has_signals(&self) -> bool {
        false
    }

    /// Casts the rays of all views and sums what passes of them by several rows of weights, beside the layers that the job
    /// has; `None` where the engine leaves the sums to whoever has the areal densities.
    ///
    /// # Errors
    /// As [`Engine::project`].
    fn signals(&self, job: &SignalsJob<'_>) -> Result<Option<(Images<f32>, Passed)>> {
        let _ = job;
        Ok(None)
    }

    /// Puts the projection of all views into a queue of the device's and returns without waiting for it. The job's
    /// progress hears nothing.
    ///
    /// # Safety
    /// `queue` and `outputs` are as [`DeviceOutputs`] says.
    ///
    /// # Errors
    /// `Unsupported` where there is no queue: on the CPU; `InvalidArgument` for an output that the engine does not have.
    #[allow(unsafe_code, reason = "queue and outputs are the caller's, and believed")]
    unsafe fn encode(&self, job: &Job<'_>, queue: *mut c_void, outputs: &DeviceOutputs) -> Result<()> {
        let _ = (job, queue, outputs);
        Err(unsupported_queues())
    }

    /// What the device measured so far; `None` for engines of the CPU, which whoever calls them can time.
    fn timings(&self) -> Option<Timings> {
        None
    }

    /// Seconds of the kernel that has the specification's own inner loop, one accumulator per energy along the ray, for
    /// these views, by the device's clock: what areal densities save. `None` for engines without it.
    ///
    /// # Errors
    /// As [`Engine::project`].
    fn specification_loop(&self, views: &[ViewJob]) -> Result<Option<f64>> {
        let _ = views;
        Ok(None)
    }

    /// Bytes per second, read and written, of one copy between two buffers of the device as large as the volume's,
    /// by the device's clock; `None` for engines of the CPU.
    ///
    /// # Errors
    /// `OutOfMemory` when the device has no room for the copy.
    fn copy_bandwidth(&self) -> Result<Option<f64>> {
        Ok(None)
    }
}
