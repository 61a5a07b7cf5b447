//! The kernel text of parallel beams on an NVIDIA GPU.

use std::ffi::c_void;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use cudarc::driver::{result, sys};

use crate::engine::Timings;
use crate::engine::cuda::Device;
use crate::engine::cuda::device::Lent;
use crate::engine::cuda::driver::{Current, Event, Stream, checked};
use crate::engine::cuda::program::Program;
use crate::engine::cuda::volume::Buffer;
use crate::engine::gpu::parallel::{HeldField, Job, Wanted};
use crate::engine::gpu::{Definitions, Kernel};
use crate::error::Result;

/// Rows and columns of a block. Neighbouring threads are neighbouring rows, whose voxels are neighbours.
const BLOCK: [u32; 2] = [32, 4];

const THREADS: u32 = BLOCK[0] * BLOCK[1];

/// `DrrParallelRays`; 0 for what is not there.
#[repr(C)]
struct Rays {
    field: sys::CUdeviceptr,
    mask: sys::CUdeviceptr,
    interval: sys::CUdeviceptr,
    measured: sys::CUdeviceptr,
}

/// A field on a GPU.
pub(crate) struct Parallel {
    field: Buffer,
    device: Arc<Device>,
    timings: Mutex<Timings>,
}

/// What a launch goes into.
#[derive(Clone, Copy)]
struct Queue<'a> {
    stream: &'a Stream<'a>,
    current: &'a Current,
    clock: &'a [Event<'a>; 2],
}

impl Parallel {
    /// Of values with a border, z fastest, copied to the GPU.
    ///
    /// # Errors
    /// `OutOfMemory`; `Device`.
    pub(crate) fn new(device: &Arc<Device>, field: &[f32]) -> Result<Self> {
        let start = Instant::now();
        let buffer = Buffer::new(device, size_of_val(field), "the field")?;
        let current = device.current()?;
        let stream = Stream::new(&current)?;
        // SAFETY: the field stays until the stream has been waited for, also when the copy is refused.
        let filled = unsafe { buffer.fill(0, field, &stream) };
        filled.and(stream.finish("the copy to the GPU"))?;
        let timings = Timings {
            upload_seconds: start.elapsed().as_secs_f64(),
            volume_bytes: buffer.bytes,
            ..Timings::default()
        };
        Ok(Self { field: buffer, device: device.clone(), timings: Mutex::new(timings) })
    }

    /// Values in memory that is lent until the stream comes to its end.
    ///
    /// # Safety
    /// The values stay until the stream has run it.
    unsafe fn sent<'a, T: Copy>(&self, what: &str, values: &[T], queue: Queue<'a>) -> Result<Lent<'a>> {
        let stream = queue.stream.raw;
        let lent = self.device.lend(what, size_of_val(values), stream, queue.current)?;
        // SAFETY: lent for as many bytes; the values stay by the caller's promise.
        checked(what, unsafe { result::memcpy_htod_async(lent.address, values, stream) })?;
        Ok(lent)
    }

    /// Puts a job into a stream, with all that it needs.
    ///
    /// # Safety
    /// Job and results stay until the stream has run it.
    unsafe fn enqueue(&self, job: &Job<'_>, results: &mut [f32], queue: Queue<'_>) -> Result<Arc<Program>> {
        let device = &self.device;
        let program = device.program(Kernel::Parallel, &job.definitions(), THREADS, queue.current)?;
        let none = Definitions::flags([]);
        let sum = || device.program(Kernel::ParallelSums, &none, THREADS, queue.current);
        let sum = (job.wanted == Wanted::Sums).then(sum).transpose()?;
        let stream = queue.stream.raw;
        let planes = device.lend("the images", job.rays() * size_of::<f32>(), stream, queue.current)?;
        let sums = device.lend("the sums", job.sums() * size_of::<f32>(), stream, queue.current)?;
        // SAFETY: the job stays by the caller's promise.
        let [views, mask, intervals, measured] = unsafe {
            [
                Some(self.sent("the views", &job.views, queue)?),
                job.mask.as_ref().map(|mask| self.sent("the mask", mask, queue)).transpose()?,
                job.intervals.as_ref().map(|all| self.sent("the lengths", all, queue)).transpose()?,
                job.measured.map(|image| self.sent("the measured image", image, queue)).transpose()?,
            ]
        };
        let address = |lent: &Option<Lent<'_>>| lent.as_ref().map_or(0, |lent| lent.address);
        let mut rays = Rays {
            field: self.field.address,
            mask: address(&mask),
            interval: address(&intervals),
            measured: address(&measured),
        };
        let (mut launch, mut first_view) = (job.launch, address(&views));
        let (mut first_plane, mut first_sum) = (planes.address, sums.address);
        let [rows, columns] = BLOCK;
        let grid = (launch.height.div_ceil(rows) * launch.views, launch.width.div_ceil(columns), 1);
        queue.clock[0].record(queue.stream)?;
        let mut of_rays: [*mut c_void; 4] = [
            (&raw mut launch).cast(),
            (&raw mut first_view).cast(),
            (&raw mut rays).cast(),
            (&raw mut first_plane).cast(),
        ];
        // SAFETY: the parameters are those of `shaders/parallel.cu` by type and order, and are copied during the call; the
        // arrays are as long as the launch says.
        checked("the kernel", unsafe {
            result::launch_kernel(program.function, grid, (rows, columns, 1), 0, stream, &mut of_rays)
        })?;
        if let Some(sum) = &sum {
            let mut of_sums: [*mut c_void; 3] =
                [(&raw mut launch).cast(), (&raw mut first_plane).cast(), (&raw mut first_sum).cast()];
            let grid = ((job.sums() as u32).div_ceil(THREADS), 1, 1);
            // SAFETY: as above.
            checked("the kernel", unsafe {
                result::launch_kernel(sum.function, grid, (THREADS, 1, 1), 0, stream, &mut of_sums)
            })?;
        }
        queue.clock[1].record(queue.stream)?;
        let from = if sum.is_some() { sums.address } else { planes.address };
        // SAFETY: the place has as many numbers as the results, which stay by the caller's promise.
        checked("the images from the GPU", unsafe { result::memcpy_dtoh_async(results, from, stream) })?;
        Ok(program)
    }
}

impl HeldField for Parallel {
    fn run(&self, job: &Job<'_>, results: &mut [f32]) -> Result<f64> {
        let current = self.device.current()?;
        let stream = Stream::new(&current)?;
        let clock = [Event::new(&current)?, Event::new(&current)?];
        let queue = Queue { stream: &stream, current: &current, clock: &clock };
        // SAFETY: the stream is waited for, also when something is refused half-way.
        let queued = unsafe { self.enqueue(job, results, queue) };
        let finished = stream.finish("the kernel");
        let program = queued?;
        finished?;
        let mut timings = self.timings.lock().unwrap_or_else(PoisonError::into_inner);
        timings.compile_seconds = program.compile_seconds;
        (timings.registers, timings.local_bytes) = (program.registers, program.local_bytes);
        clock[1].seconds_since(&clock[0])
    }

    fn timings(&self) -> Option<Timings> {
        Some(*self.timings.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
