//! The kernel text of parallel beams on an Apple GPU.

use std::ptr::NonNull;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use objc2::rc::autoreleasepool;
use objc2::runtime::ProtocolObject;
use objc2_foundation::ns_string;
use objc2_metal::{
    MTLBuffer, MTLCommandBuffer, MTLCommandEncoder, MTLComputeCommandEncoder, MTLComputePassDescriptor,
    MTLComputePipelineState, MTLDevice, MTLSize,
};

use crate::engine::Timings;
use crate::engine::gpu::parallel::{HeldField, Job, Launch, Wanted};
use crate::engine::gpu::{Definitions, Kernel};
use crate::engine::metal::Device;
use crate::engine::metal::failure::none;
use crate::engine::metal::finish;
use crate::engine::metal::objects::Buffer;
use crate::engine::metal::program::{Pipeline, Variant, options, pipelines};
use crate::engine::metal::time::Stopwatch;
use crate::error::Result;

/// Rows and columns of a threadgroup. Neighbouring threads are neighbouring rows, whose voxels are neighbours.
const BLOCK: [usize; 2] = [32, 4];

/// The kernels of one specialisation.
pub(super) struct Program {
    project: Pipeline,
    sum: Pipeline,
    compile_seconds: f64,
}

impl Program {
    /// # Errors
    /// `Unsupported`, with the compiler's words.
    pub(super) fn compiled(
        device: &ProtocolObject<dyn MTLDevice>,
        definitions: &Definitions,
    ) -> Result<Self> {
        let start = Instant::now();
        let names = [ns_string!("projectParallel"), ns_string!("sumParallel")];
        let options = options(&Variant { definitions: definitions.clone(), image: None });
        let [project, sum] = pipelines(device, Kernel::Parallel, &options, names)?;
        Ok(Self { project, sum, compile_seconds: start.elapsed().as_secs_f64() })
    }
}

/// A field on a GPU.
pub(crate) struct Parallel {
    field: Buffer,
    device: Arc<Device>,
    timings: Mutex<Timings>,
}

/// What a launch reads and writes beside its field.
struct Places {
    views: Buffer,
    mask: Option<Buffer>,
    intervals: Option<Buffer>,
    measured: Option<Buffer>,
    planes: Buffer,
    sums: Buffer,
}

impl Places {
    fn new(gpu: &ProtocolObject<dyn MTLDevice>, job: &Job<'_>) -> Result<Self> {
        let room = |values: usize, what: &str| Buffer::new(gpu, values * size_of::<f32>(), what);
        Ok(Self {
            views: Buffer::of(gpu, &job.views, "the views")?,
            mask: job.mask.as_ref().map(|mask| Buffer::of(gpu, mask, "the mask")).transpose()?,
            intervals: job.intervals.as_ref().map(|all| Buffer::of(gpu, all, "the lengths")).transpose()?,
            measured: job.measured.map(|image| Buffer::of(gpu, image, "the measured image")).transpose()?,
            planes: room(job.rays(), "the images")?,
            sums: room(job.sums(), "the sums")?,
        })
    }
}

impl Parallel {
    /// Of values with a border, z fastest, copied to the GPU.
    ///
    /// # Errors
    /// `Unsupported` when the GPU has no buffers of that size; `OutOfMemory`.
    pub(crate) fn new(device: &Arc<Device>, field: &[f32]) -> Result<Self> {
        let start = Instant::now();
        let field = autoreleasepool(|_| Buffer::of(device.gpu(), field, "the field"))?;
        let timings = Timings {
            upload_seconds: start.elapsed().as_secs_f64(),
            volume_bytes: field.length(),
            ..Timings::default()
        };
        Ok(Self { field, device: device.clone(), timings: Mutex::new(timings) })
    }

    /// Gives both kernels their arguments.
    fn bind(&self, encoder: &ProtocolObject<dyn MTLComputeCommandEncoder>, job: &Job<'_>, places: &Places) {
        let bind = |buffer: Option<&Buffer>, index: usize| {
            if let Some(buffer) = buffer {
                // SAFETY: the indices of `shaders/parallel.metal`; arrays as long as the launch says.
                unsafe { encoder.setBuffer_offset_atIndex(Some(buffer), 0, index) };
            }
        };
        let launch = NonNull::from(&job.launch);
        // SAFETY: the index of `shaders/parallel.metal`, whose wire struct is these bytes.
        unsafe { encoder.setBytes_length_atIndex(launch.cast(), size_of::<Launch>(), 0) };
        bind(Some(&places.views), 1);
        bind(Some(&self.field), 2);
        bind(Some(&places.planes), 3);
        bind(places.mask.as_ref(), 4);
        bind(places.intervals.as_ref(), 5);
        bind(places.measured.as_ref(), 6);
        bind(Some(&places.sums), 7);
    }

    fn encode(
        &self,
        commands: &ProtocolObject<dyn MTLCommandBuffer>,
        program: &Program,
        job: &Job<'_>,
        places: &Places,
        stopwatch: &Stopwatch,
    ) -> Result<()> {
        let pass = MTLComputePassDescriptor::new();
        stopwatch.attach(&pass);
        let encoder = commands.computeCommandEncoderWithDescriptor(&pass);
        let encoder = encoder.ok_or_else(none("compute encoder"))?;
        self.bind(&encoder, job, places);
        encoder.setComputePipelineState(&program.project);
        let Launch { width, height, views, .. } = job.launch;
        let [columns, rows, depth] = [width, height, views].map(|n| n as usize);
        let most = program.project.maxTotalThreadsPerThreadgroup();
        let group =
            MTLSize { width: BLOCK[0].min(most), height: BLOCK[1].min(most / BLOCK[0]).max(1), depth: 1 };
        encoder.dispatchThreads_threadsPerThreadgroup(MTLSize { width: rows, height: columns, depth }, group);
        // Dispatches of one pass run one after the other, and see what those before have written.
        if job.wanted == Wanted::Sums {
            encoder.setComputePipelineState(&program.sum);
            let line = |width: usize| MTLSize { width, height: 1, depth: 1 };
            let most = program.sum.maxTotalThreadsPerThreadgroup();
            let group = line((BLOCK[0] * BLOCK[1]).min(most));
            encoder.dispatchThreads_threadsPerThreadgroup(line(job.sums()), group);
        }
        encoder.endEncoding();
        Ok(())
    }
}

impl HeldField for Parallel {
    fn run(&self, job: &Job<'_>, results: &mut [f32]) -> Result<f64> {
        autoreleasepool(|_| {
            let program = self.device.parallel_program(&job.definitions())?;
            let places = Places::new(self.device.gpu(), job)?;
            let commands = self.device.command_buffer()?;
            let stopwatch = Stopwatch::new(self.device.gpu());
            self.encode(&commands, &program, job, &places, &stopwatch)?;
            finish(&commands, places.planes.length())?;
            let from = if job.wanted == Wanted::Sums { &places.sums } else { &places.planes };
            from.read(results);
            let mut timings = self.timings.lock().unwrap_or_else(PoisonError::into_inner);
            timings.compile_seconds = program.compile_seconds;
            Ok(stopwatch.seconds(self.device.gpu(), &commands))
        })
    }

    fn timings(&self) -> Option<Timings> {
        Some(*self.timings.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
