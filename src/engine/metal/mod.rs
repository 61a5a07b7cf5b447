//! The kernel text on an Apple GPU. Written and checked without one: README.md here says what has been verified.
#![allow(unsafe_code, reason = "calls Metal")]

mod command;
mod device;
mod failure;
mod library;
mod objects;
mod outputs;
mod time;
mod volume;

use std::ffi::c_void;
use std::ptr::NonNull;
use std::sync::Arc;

use objc2::rc::{Retained, autoreleasepool};
use objc2::runtime::ProtocolObject;
use objc2_metal::{MTLCommandBuffer, MTLCommandBufferStatus, MTLDevice};

use crate::engine::gpu::Prepared;
use crate::engine::{DeviceOutputs, Engine, Images, Job};
use crate::error::{Error, Result};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::volume::Volume;
use command::{Launch, most_views};
pub use device::Device;
use outputs::Outputs;
use time::Stopwatch;
use volume::DeviceVolume;
pub use volume::Texture;

/// Views of one launch: enough to share what they read of the volume, few enough to be cancelled soon.
const VIEWS_AT_ONCE: usize = 4;

/// The kernel on a GPU, ready for one scene and one volume.
pub struct Metal {
    device: Arc<Device>,
    prepared: Prepared,
    volume: Arc<DeviceVolume>,
}

impl Metal {
    /// Ready to project `volume` as `scene` and `plan` say.
    ///
    /// # Errors
    /// `Unsupported` for a volume that is too large, or in a texture that is not Metal's; `OutOfMemory`.
    pub fn new(device: &Arc<Device>, volume: &Arc<Volume>, scene: &Scene, plan: &Plan) -> Result<Self> {
        autoreleasepool(|_| {
            let on_device = device.volume(volume)?;
            let voxels = &on_device.voxels;
            let prepared = Prepared::new(volume, voxels, voxels.layout(), scene, plan)?;
            Ok(Self { device: device.clone(), prepared, volume: on_device })
        })
    }

    fn project(&self, job: &Job<'_>) -> Result<Images<f32>> {
        if job.views.iter().any(|view| view.lut_addresses != [0, 0]) {
            let text = "tables at GPU addresses must be resident for the command buffer that reads them, which only \
                        the caller can see to: encode into a command buffer of your own";
            return Err(Error::Unsupported(text.into()));
        }
        let [width, height] = self.prepared.size;
        let at_once = most_views(&self.prepared)?.min(VIEWS_AT_ONCE).min(job.views.len()).max(1);
        let materials = self.prepared.materials;
        let mut images = Images::zeroed([width, height], job.views.len(), materials, job.layers)?;
        let outputs = Outputs::new(&self.device, &self.prepared, at_once, job.layers)?;
        let mut seconds = 0.0;
        for (n, views) in job.views.chunks(at_once).enumerate() {
            let launch = Launch::new(&self.device, &self.prepared, views, &outputs)?;
            seconds += self.run(&launch, &outputs)?;
            outputs.read(&mut images, n * at_once, views.len());
            job.progress.finished(views.len() * width * height * self.prepared.rays_per_pixel)?;
        }
        self.device.set_last_gpu_seconds(seconds);
        Ok(images)
    }

    /// Runs one launch to its end; the seconds that the GPU took.
    fn run(&self, launch: &Launch, outputs: &Outputs) -> Result<f64> {
        let commands = self.device.command_buffer()?;
        let stopwatch = Stopwatch::new(self.device.gpu());
        launch.encode(&self.device, &commands, &self.volume, outputs, Some(&stopwatch))?;
        commands.commit();
        commands.waitUntilCompleted();
        failure::check(&commands, outputs.bytes())?;
        Ok(stopwatch.seconds(self.device.gpu(), &commands))
    }
}

impl Engine for Metal {
    fn project(&self, job: &Job<'_>) -> Result<Images<f32>> {
        autoreleasepool(|_| self.project(job))
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
            let commands = unsafe { self.commands(queue)? };
            // SAFETY: the caller's promise.
            let outputs =
                unsafe { Outputs::retained(&self.device, &self.prepared, job.views.len(), outputs)? };
            let launch = Launch::new(&self.device, &self.prepared, job.views, &outputs)?;
            launch.encode(&self.device, &commands, &self.volume, &outputs, None)
        })
    }
}

impl Metal {
    /// The caller's command buffer.
    ///
    /// # Safety
    /// `queue` is null or an `id<MTLCommandBuffer>`.
    unsafe fn commands(&self, queue: *mut c_void) -> Result<Retained<ProtocolObject<dyn MTLCommandBuffer>>> {
        let invalid = |value: &str| {
            Error::invalid(
                "queue",
                value,
                "an id<MTLCommandBuffer> of the context's GPU that retains its references and is not committed",
            )
        };
        let pointer = NonNull::new(queue).ok_or_else(|| invalid("NULL"))?;
        // SAFETY: the caller's promise.
        let commands: Option<Retained<ProtocolObject<dyn MTLCommandBuffer>>> =
            unsafe { Retained::retain(pointer.cast().as_ptr()) };
        let commands = commands.ok_or_else(|| invalid("NULL"))?;
        if !self.device.is(&commands.device()) {
            return Err(invalid(&format!("of {}", commands.device().name())));
        }
        if !commands.retainedReferences() {
            return Err(invalid("without retained references"));
        }
        if commands.status() != MTLCommandBufferStatus::NotEnqueued
            && commands.status() != MTLCommandBufferStatus::Enqueued
        {
            return Err(invalid("committed"));
        }
        Ok(commands)
    }
}
