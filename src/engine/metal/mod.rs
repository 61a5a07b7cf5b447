//! The kernel text on an Apple GPU. Written and checked without one: README.md here says what has been verified.
#![allow(unsafe_code, reason = "calls Metal")]

mod device;
mod failure;
mod launch;
mod objects;
mod outputs;
mod parallel;
mod program;
mod time;
mod volume;

use std::ffi::c_void;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use objc2::rc::autoreleasepool;
use objc2::runtime::ProtocolObject;
use objc2_metal::{MTLBlitCommandEncoder, MTLBuffer, MTLCommandBuffer, MTLCommandEncoder};

use crate::engine::gpu::Prepared;
use crate::engine::{DeviceOutputs, Engine, Images, Job, Layers, Passed, SignalsJob, Timings, ViewJob};
use crate::error::{Error, Result};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::volume::Volume;
pub(crate) use device::Device;
use failure::none;
use launch::Launch;
use objects::Buffer;
use outputs::Outputs;
pub(crate) use parallel::Parallel;
use time::Stopwatch;
use volume::DeviceVolume;
pub(crate) use volume::Texture;

/// Views of one launch: enough to share what they read of the volume, few enough to be cancelled soon.
const VIEWS_AT_ONCE: usize = 4;

/// The kernel on a GPU, ready for one scene and one volume.
pub(crate) struct Metal {
    device: Arc<Device>,
    prepared: Prepared,
    volume: Arc<DeviceVolume>,
    /// Columns and rows of a threadgroup.
    block: [usize; 2],
    timings: Mutex<Timings>,
}

impl Metal {
    /// Ready to project `volume` as `scene` and `plan` say.
    ///
    /// # Errors
    /// `Unsupported` for a volume that is too large, or in a texture that is not Metal's; `OutOfMemory`.
    pub(crate) fn new(
        device: &Arc<Device>,
        volume: &Arc<Volume>,
        scene: &Scene,
        plan: &Plan,
    ) -> Result<Self> {
        autoreleasepool(|_| {
            let on_device = device.volume(volume)?;
            let prepared = Prepared::new(volume, &on_device.voxels, scene, plan)?;
            let timings = Timings {
                upload_seconds: on_device.upload_seconds,
                volume_bytes: on_device.bytes(),
                ..Timings::default()
            };
            Ok(Self {
                device: device.clone(),
                prepared,
                volume: on_device,
                block: plan.block.unwrap_or([1, 1]),
                timings: Mutex::new(timings),
            })
        })
    }

    fn launch(&self, views: &[ViewJob], outputs: &Outputs) -> Result<Launch> {
        Launch::new(&self.device, &self.prepared, self.block, views, outputs)
    }

    fn images(&self, job: &Job<'_>) -> Result<Images<f32>> {
        if job.views.iter().any(|view| view.lut_addresses != [0, 0]) {
            let text = "tables at GPU addresses must be resident for the command buffer that reads them, which only \
                        the caller can see to: encode into a command buffer of your own";
            return Err(Error::Unsupported(text.into()));
        }
        let [width, height] = self.prepared.size;
        let at_once = self.prepared.most_views.min(VIEWS_AT_ONCE).min(job.views.len()).max(1);
        let materials = self.prepared.materials;
        let mut images = Images::zeroed([width, height], job.views.len(), materials, job.layers)?;
        let outputs = Outputs::new(&self.device, &self.prepared, at_once, job.layers)?;
        let mut kernel_seconds = 0.0;
        for (n, views) in job.views.chunks(at_once).enumerate() {
            let launch = self.launch(views, &outputs)?;
            kernel_seconds += self.run(&launch, &outputs)?;
            outputs.read(&mut images, n * at_once, views.len());
            self.measured().compile_seconds = launch.compile_seconds();
            job.progress.finished(views.len() * width * height * self.prepared.rays_per_pixel)?;
        }
        self.measured().kernel_seconds = kernel_seconds;
        Ok(images)
    }

    fn passed(&self, job: &SignalsJob<'_>) -> Result<Option<(Images<f32>, Passed)>> {
        let Some(most) = self.prepared.views_of_signals(job) else { return Ok(None) };
        let [width, height] = self.prepared.size;
        let at_once = most.min(VIEWS_AT_ONCE).min(job.views.len()).max(1);
        let (size, materials) = (self.prepared.size, self.prepared.materials);
        let mut images = Images::zeroed(size, job.views.len(), materials, job.layers)?;
        let mut passed = Passed::zeroed(job, size)?;
        let outputs = Outputs::of_signals(&self.device, &self.prepared, at_once, job)?;
        let mut kernel_seconds = 0.0;
        for (n, views) in job.views.chunks(at_once).enumerate() {
            let launch = Launch::signals(&self.device, &self.prepared, self.block, (views, job), &outputs)?;
            kernel_seconds += self.run(&launch, &outputs)?;
            outputs.read(&mut images, n * at_once, views.len());
            outputs.read_signals(&mut passed, job.rows.len() * width * height, n * at_once, views.len());
            self.measured().compile_seconds = launch.compile_seconds();
            job.progress.finished(views.len() * width * height)?;
        }
        self.measured().kernel_seconds = kernel_seconds;
        Ok(Some((images, passed)))
    }

    /// Runs one launch to its end; the seconds that the GPU took.
    fn run(&self, launch: &Launch, outputs: &Outputs) -> Result<f64> {
        // A job may have thousands of launches, whose command buffers keep what they use.
        autoreleasepool(|_| {
            let commands = self.device.command_buffer()?;
            let stopwatch = Stopwatch::new(self.device.gpu());
            launch.encode(&commands, &self.volume, outputs, Some(&stopwatch))?;
            finish(&commands, outputs.bytes())?;
            Ok(stopwatch.seconds(self.device.gpu(), &commands))
        })
    }

    /// Bytes per second, read and written, of a copy of the voxels.
    fn copy(&self) -> Result<Option<f64>> {
        let Some(voxels) = self.volume.largest() else { return Ok(None) };
        let bytes = voxels.length();
        let copy = Buffer::new(self.device.gpu(), bytes, "a copy of the voxels")?;
        let mut seconds = f64::NAN;
        // The first copy also makes the memory's pages.
        for _ in 0..2 {
            let commands = self.device.command_buffer()?;
            let encoder = commands.blitCommandEncoder().ok_or_else(none("blit encoder"))?;
            // SAFETY: both buffers are that long.
            unsafe {
                encoder
                    .copyFromBuffer_sourceOffset_toBuffer_destinationOffset_size(voxels, 0, &copy, 0, bytes);
            }
            encoder.endEncoding();
            finish(&commands, bytes)?;
            seconds = commands.GPUEndTime() - commands.GPUStartTime();
        }
        Ok(Some(2.0 * bytes as f64 / seconds))
    }

    fn measured(&self) -> MutexGuard<'_, Timings> {
        self.timings.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Runs what has been encoded to its end. `bytes` are those of its results.
fn finish(commands: &ProtocolObject<dyn MTLCommandBuffer>, bytes: usize) -> Result<()> {
    commands.commit();
    commands.waitUntilCompleted();
    failure::check(commands, bytes)
}

impl Engine for Metal {
    fn project(&self, job: &Job<'_>) -> Result<Images<f32>> {
        autoreleasepool(|_| self.images(job))
    }

    fn has_signals(&self) -> bool {
        true
    }

    fn signals(&self, job: &SignalsJob<'_>) -> Result<Option<(Images<f32>, Passed)>> {
        autoreleasepool(|_| self.passed(job))
    }

    /// `queue` is an `id<MTLCommandBuffer>` of the engine's GPU that retains its references, is not committed, and has no
    /// encoder open. The tables behind LUT addresses must be resident for it. The layers are those of `outputs`.
    ///
    /// # Errors
    /// `InvalidArgument` when the command buffer or an output is not as described, and nothing is encoded then;
    /// `Unsupported` for more views than one launch has; `OutOfMemory`.
    unsafe fn encode(&self, job: &Job<'_>, queue: *mut c_void, outputs: &DeviceOutputs) -> Result<()> {
        autoreleasepool(|_| {
            // SAFETY: the caller's promise.
            let commands = unsafe { self.device.callers_command_buffer(queue)? };
            // SAFETY: the caller's promise.
            let outputs =
                unsafe { Outputs::retained(&self.device, &self.prepared, job.views.len(), outputs)? };
            let launch = self.launch(job.views, &outputs)?;
            launch.encode(&commands, &self.volume, &outputs, None)
        })
    }

    fn timings(&self) -> Option<Timings> {
        Some(*self.measured())
    }

    fn specification_loop(&self, views: &[ViewJob]) -> Result<Option<f64>> {
        let views = &views[..views.len().min(VIEWS_AT_ONCE)];
        let layers = Layers { intensity: true, ..Layers::default() };
        autoreleasepool(|_| {
            let outputs = Outputs::new(&self.device, &self.prepared, views.len(), layers)?;
            let launch =
                Launch::specification_loop(&self.device, &self.prepared, self.block, views, &outputs)?;
            self.run(&launch, &outputs).map(Some)
        })
    }

    fn copy_bandwidth(&self) -> Result<Option<f64>> {
        autoreleasepool(|_| self.copy())
    }
}
