//! The kernel text on an NVIDIA GPU: compiled when it is first used, by NVIDIA's run-time compiler, and launched by
//! NVIDIA's driver. Both are found when the device is opened; nothing of CUDA is needed before.
#![allow(unsafe_code, reason = "calls NVIDIA's driver")]

mod device;
mod driver;
mod launch;
mod outputs;
mod parallel;
mod program;
mod volume;

use std::ffi::c_void;
use std::sync::{Arc, Mutex, PoisonError};

use cudarc::driver::result;

pub(crate) use device::Device;
pub(crate) use parallel::Parallel;

use crate::engine::gpu::{Kernel, Prepared, Views};
use crate::engine::{
    Backend, DeviceOutputs, Engine, Images, Job, Layers, Passed, SignalsJob, Timings, ViewJob,
};
use crate::error::{Error, Result};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::volume::Volume;
use driver::{Current, Event, Stream};
use launch::Queue;
use outputs::{Places, SignalPlanes};
use volume::DeviceVolume;

/// Most views of one launch. Between launches progress is reported.
const VIEWS_AT_ONCE: usize = 8;

/// The kernel on a GPU, ready for one scene and one volume.
pub(crate) struct Cuda {
    prepared: Prepared,
    volume: Arc<DeviceVolume>,
    device: Arc<Device>,
    /// Columns and rows of pixels.
    block: [u32; 2],
    views_at_once: usize,
    timings: Mutex<Timings>,
}

impl Cuda {
    /// Ready to project `volume` as `scene` and `plan` say.
    ///
    /// # Errors
    /// `Unsupported` for a volume or a detector that is too large; `OutOfMemory`; `Device`.
    pub(crate) fn new(device: Arc<Device>, volume: &Arc<Volume>, scene: &Scene, plan: &Plan) -> Result<Self> {
        let on_device = device.volume(volume)?;
        let prepared = Prepared::new(volume, &on_device.voxels, scene, plan)?;
        let timings = Timings {
            upload_seconds: on_device.upload_seconds,
            volume_bytes: on_device.bytes(),
            ..Timings::default()
        };
        Ok(Self {
            views_at_once: prepared.most_views.min(VIEWS_AT_ONCE),
            prepared,
            volume: on_device,
            device,
            block: plan.block.unwrap_or([1, 1]).map(|n| n as u32),
            timings: Mutex::new(timings),
        })
    }

    fn pixels(&self) -> usize {
        self.prepared.size[0] * self.prepared.size[1]
    }

    fn threads(&self) -> u32 {
        self.block[0] * self.block[1]
    }

    /// Projects the views of one launch into the images of views `first …`, and their signals, behind what is at an address
    /// of the GPU's, into planes of their own; seconds of the kernel.
    fn launch(
        &self,
        views: &Views,
        layers: Layers,
        (first, images): (usize, &mut Images<f32>),
        mut signals: Option<(SignalPlanes<'_>, u64)>,
        (stream, current): (&Stream<'_>, &Current),
    ) -> Result<f64> {
        let program = self.device.program(Kernel::Projection, &views.definitions, self.threads(), current)?;
        let pixels = self.pixels() * views.beams.len();
        let materials = self.prepared.materials;
        let (_, bytes) = Places::packed(0, pixels, materials, layers);
        let of_signals = signals.as_ref().map_or(0, |(planes, _)| planes.bytes());
        let lent = self.device.lend("the images", bytes + of_signals, stream.raw, current)?;
        let (places, _) = Places::packed(lent.address, pixels, materials, layers);
        let signal_places =
            signals.as_ref().map(|(planes, before)| planes.places(lent.address + bytes as u64, *before));
        let [start, end] = [Event::new(current)?, Event::new(current)?];
        let queue = Queue { stream: stream.raw, current, clock: Some((stream, [&start, &end])) };
        // SAFETY: the places are in memory that is lent until after the stream is waited for, which is also when the
        // images are complete; a failure in between waits as well.
        let enqueued = unsafe {
            self.enqueue(views, layers, &program, (places, signal_places), &queue)
                .and_then(|()| places.copy_back(images, first, pixels, stream))
                .and_then(|()| match signals.as_mut().zip(signal_places) {
                    Some(((planes, _), places)) => planes.copy_back(&places, stream),
                    None => Ok(()),
                })
        };
        enqueued.and(stream.finish("the kernel"))?;
        let mut timings = self.timings.lock().unwrap_or_else(PoisonError::into_inner);
        timings.compile_seconds = program.compile_seconds;
        (timings.registers, timings.local_bytes) = (program.registers, program.local_bytes);
        end.seconds_since(&start)
    }
}

impl Engine for Cuda {
    fn project(&self, job: &Job<'_>) -> Result<Images<f32>> {
        let mut images =
            Images::zeroed(self.prepared.size, job.views.len(), self.prepared.materials, job.layers)?;
        let current = self.device.current()?;
        let stream = Stream::new(&current)?;
        let mut kernel_seconds = 0.0;
        for (n, some) in job.views.chunks(self.views_at_once).enumerate() {
            let (views, first) = (self.prepared.views(some, job.layers), n * self.views_at_once);
            let images = (first, &mut images);
            kernel_seconds += self.launch(&views, job.layers, images, None, (&stream, &current))?;
            job.progress.finished(some.len() * self.pixels() * self.prepared.rays_per_pixel)?;
        }
        self.timings.lock().unwrap_or_else(PoisonError::into_inner).kernel_seconds = kernel_seconds;
        Ok(images)
    }

    fn has_signals(&self) -> bool {
        true
    }

    fn signals(&self, job: &SignalsJob<'_>) -> Result<Option<(Images<f32>, Passed)>> {
        let Some(most) = self.prepared.views_of_signals(job) else { return Ok(None) };
        let at_once = most.min(VIEWS_AT_ONCE);
        let size = self.prepared.size;
        let mut images = Images::zeroed(size, job.views.len(), self.prepared.materials, job.layers)?;
        let Passed { mut passing, mut open } = Passed::zeroed(job, size)?;
        let current = self.device.current()?;
        let stream = Stream::new(&current)?;
        let what = "what lies before the volume";
        let before = self.device.lend(what, size_of_val(job.before), stream.raw, &current)?;
        let copied = match job.before {
            [] => Ok(()),
            // SAFETY: lent for as many bytes; the job's stay, and the stream is waited for.
            values => unsafe { result::memcpy_htod_async(before.address, values, stream.raw) },
        };
        driver::checked(what, copied).and(stream.finish(what))?;
        let planes = job.rows.len() * self.pixels();
        let mut kernel_seconds = 0.0;
        for (n, some) in job.views.chunks(at_once).enumerate() {
            let (views, first) = (self.prepared.signals(some, job), n * at_once);
            let passing = &mut passing[first * planes..][..some.len() * planes];
            let signals = Some((SignalPlanes { passing, open: &mut open }, before.address));
            let images = (first, &mut images);
            kernel_seconds += self.launch(&views, job.layers, images, signals, (&stream, &current))?;
            job.progress.finished(some.len() * self.pixels())?;
        }
        self.timings.lock().unwrap_or_else(PoisonError::into_inner).kernel_seconds = kernel_seconds;
        Ok(Some((images, Passed { passing, open })))
    }

    unsafe fn encode(&self, job: &Job<'_>, queue: *mut c_void, outputs: &DeviceOutputs) -> Result<()> {
        if !outputs.intensity_texture.is_null() {
            let valid = format!("NULL, because the engine is {}", Backend::Cuda.name());
            return Err(Error::invalid("outputs.intensity_texture", "not NULL", valid));
        }
        let current = self.device.current()?;
        let queue = Queue { stream: queue.cast(), current: &current, clock: None };
        // SAFETY: a stream, by the caller's promise.
        unsafe { driver::not_captured(queue.stream)? };
        let address = |pointer: *mut c_void| pointer.expose_provenance() as u64;
        let mut places = Places {
            intensity: address(outputs.intensity),
            line_integral: address(outputs.line_integral),
            areal_density: address(outputs.areal_density),
            bone_path: address(outputs.bone_path),
        };
        // All kernels are compiled before the first is in the queue.
        let prepared = |some: &[ViewJob]| {
            let views = self.prepared.views(some, job.layers);
            let program =
                self.device.program(Kernel::Projection, &views.definitions, self.threads(), &current)?;
            Ok((views, program))
        };
        let launches: Vec<_> = job.views.chunks(self.views_at_once).map(prepared).collect::<Result<_>>()?;
        for (views, program) in &launches {
            // SAFETY: stream and places are the caller's, as promised.
            unsafe { self.enqueue(views, job.layers, program, (places, None), &queue)? };
            places = places.after(self.pixels() * views.beams.len(), self.prepared.materials);
        }
        Ok(())
    }

    fn timings(&self) -> Option<Timings> {
        Some(*self.timings.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn specification_loop(&self, views: &[ViewJob]) -> Result<Option<f64>> {
        let layers = Layers { intensity: true, ..Layers::default() };
        let mut views = self.prepared.views(&views[..self.views_at_once.min(views.len())], layers);
        views.definitions = views.definitions.with_specification_loop();
        let (size, materials) = (self.prepared.size, self.prepared.materials);
        let mut images = Images::zeroed(size, views.beams.len(), materials, layers)?;
        let current = self.device.current()?;
        let stream = Stream::new(&current)?;
        self.launch(&views, layers, (0, &mut images), None, (&stream, &current)).map(Some)
    }

    fn copy_bandwidth(&self) -> Result<Option<f64>> {
        self.volume.copy_bandwidth().map(Some)
    }
}
