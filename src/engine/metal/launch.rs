//! One launch: all that one dispatch of the kernel takes, and how it is encoded.

use std::ptr::NonNull;
use std::sync::Arc;

use objc2::runtime::ProtocolObject;
use objc2_metal::{
    MTLCommandBuffer, MTLCommandEncoder, MTLComputeCommandEncoder, MTLComputePassDescriptor,
    MTLComputePipelineState, MTLSize,
};

use crate::engine::gpu::wire::{Channels as WireChannels, Launch as WireLaunch};
use crate::engine::gpu::{Prepared, Views};
use crate::engine::metal::Device;
use crate::engine::metal::failure::none;
use crate::engine::metal::objects::Buffer;
use crate::engine::metal::outputs::Outputs;
use crate::engine::metal::program::{Program, Variant};
use crate::engine::metal::time::Stopwatch;
use crate::engine::metal::volume::DeviceVolume;
use crate::engine::{SignalsJob, ViewJob};
use crate::error::{Error, Result};
use crate::shared::{DrrBool, DrrFloat3, DrrFloat4x4, ProjectionUniforms};

/// A launch, complete: what can be refused has been granted, and nothing is encoded yet.
pub(super) struct Launch {
    views: Views,
    program: Arc<Program>,
    size: [usize; 2],
    /// Columns and rows of a threadgroup.
    block: [usize; 2],
    /// Of views with tables of their own, which are prepared first.
    uniforms: Option<Buffer>,
    weights: Buffer,
    attenuation: Buffer,
    beams: Buffer,
}

impl Launch {
    /// For some views of a job, whose layers go to `outputs`.
    ///
    /// # Errors
    /// `Unsupported` when the kernel cannot number so many pixels or does not compile; `OutOfMemory`.
    pub(super) fn new(
        device: &Device,
        prepared: &Prepared,
        block: [usize; 2],
        views: &[ViewJob],
        outputs: &Outputs,
    ) -> Result<Self> {
        let (given, most) = (views.len(), prepared.most_views);
        if given > most {
            let text = format!("{given} views are too many for one launch of the GPU: at most {most}");
            return Err(Error::Unsupported(text));
        }
        let own_tables = views.iter().any(|view| view.lut_addresses != [0, 0]);
        let uniforms: Option<Vec<_>> = own_tables.then(|| views.iter().map(uniforms).collect());
        Self::of(device, prepared, block, prepared.views(views, outputs.layers()), uniforms, outputs)
    }

    /// For some views of a job that sums by several rows of weights.
    ///
    /// # Errors
    /// As [`Launch::new`].
    pub(super) fn signals(
        device: &Device,
        prepared: &Prepared,
        block: [usize; 2],
        (views, job): (&[ViewJob], &SignalsJob<'_>),
        outputs: &Outputs,
    ) -> Result<Self> {
        Self::of(device, prepared, block, prepared.signals(views, job), None, outputs)
    }

    /// With the specification's own loop.
    ///
    /// # Errors
    /// As [`Launch::new`].
    pub(super) fn specification_loop(
        device: &Device,
        prepared: &Prepared,
        block: [usize; 2],
        views: &[ViewJob],
        outputs: &Outputs,
    ) -> Result<Self> {
        let mut views = prepared.views(views, outputs.layers());
        views.definitions = views.definitions.with_specification_loop();
        Self::of(device, prepared, block, views, None, outputs)
    }

    fn of(
        device: &Device,
        prepared: &Prepared,
        block: [usize; 2],
        views: Views,
        uniforms: Option<Vec<ProjectionUniforms>>,
        outputs: &Outputs,
    ) -> Result<Self> {
        let gpu = device.gpu();
        let variant = Variant { definitions: views.definitions.clone(), image: outputs.image_kind() };
        Ok(Self {
            program: device.program(&variant)?,
            size: prepared.size,
            block,
            uniforms: uniforms.map(|all| Buffer::of(gpu, &all, "the views")).transpose()?,
            weights: Buffer::of(gpu, &views.spectra.weights, "the spectra")?,
            attenuation: Buffer::of(gpu, &views.spectra.attenuation, "the mass attenuation")?,
            beams: Buffer::of(gpu, &views.beams, "the views' rays")?,
            views,
        })
    }

    /// Seconds that it took to compile its kernels.
    pub(super) fn compile_seconds(&self) -> f64 {
        self.program.compile_seconds
    }

    /// Encodes it as one compute pass.
    ///
    /// # Errors
    /// `Unsupported` when Metal has no encoder for it.
    pub(super) fn encode(
        &self,
        commands: &ProtocolObject<dyn MTLCommandBuffer>,
        volume: &DeviceVolume,
        outputs: &Outputs,
        stopwatch: Option<&Stopwatch>,
    ) -> Result<()> {
        let views = self.views.beams.len();
        if self.views.definitions.iter().all(|(name, _)| name != "DRR_BONE_PATH") {
            outputs.clear_bone_path(commands, views * self.size[0] * self.size[1] * size_of::<f32>())?;
        }
        let pass = MTLComputePassDescriptor::new();
        if let Some(stopwatch) = stopwatch {
            stopwatch.attach(&pass);
        }
        let encoder = commands.computeCommandEncoderWithDescriptor(&pass);
        let encoder = encoder.ok_or_else(none("compute encoder"))?;
        self.bind(&encoder);
        // Dispatches of one pass run one after the other, and see what those before have written.
        if let Some(uniforms) = &self.uniforms {
            encoder.setComputePipelineState(&self.program.prepare_tables);
            // SAFETY: the index of `shaders/drr.metal`; one for each view.
            unsafe { encoder.setBuffer_offset_atIndex(Some(uniforms), 0, 0) };
            let one = MTLSize { width: 1, height: 1, depth: 1 };
            encoder.dispatchThreads_threadsPerThreadgroup(MTLSize { width: views, ..one }, one);
        }
        encoder.setComputePipelineState(&self.program.project);
        volume.bind(&encoder);
        outputs.bind(&encoder);
        let [width, height] = fitting(self.block, self.program.project.maxTotalThreadsPerThreadgroup());
        let grid = MTLSize { width: self.size[0], height: self.size[1], depth: views };
        encoder.dispatchThreads_threadsPerThreadgroup(grid, MTLSize { width, height, depth: 1 });
        encoder.endEncoding();
        Ok(())
    }

    /// Gives both kernels what they share.
    fn bind(&self, encoder: &ProtocolObject<dyn MTLComputeCommandEncoder>) {
        // SAFETY: the indices of `shaders/drr.metal`, whose wire structs are these bytes; arrays as long as the launch says.
        unsafe {
            encoder.setBuffer_offset_atIndex(Some(&self.weights), 0, 1);
            encoder.setBuffer_offset_atIndex(Some(&self.attenuation), 0, 2);
            let launch = NonNull::from(&self.views.launch);
            encoder.setBytes_length_atIndex(launch.cast(), size_of::<WireLaunch>(), 3);
            encoder.setBuffer_offset_atIndex(Some(&self.beams), 0, 4);
            if let Some(channels) = &self.views.channels {
                encoder.setBytes_length_atIndex(
                    NonNull::from(channels).cast(),
                    size_of::<WireChannels>(),
                    13,
                );
            }
        }
    }
}

/// The columns and rows of a threadgroup that has at most so many threads: a kernel with many registers allows fewer.
fn fitting([width, height]: [usize; 2], most: usize) -> [usize; 2] {
    let width = width.min(most);
    [width, height.min(most / width)]
}

/// A view's uniforms, of which the kernel reads the addresses: its rays are in the beam, more exactly.
fn uniforms(view: &ViewJob) -> ProjectionUniforms {
    let [spectrum, mu] = view.lut_addresses;
    ProjectionUniforms {
        modelViewProjectionMatrix: DrrFloat4x4 { columns: [[0.0; 4]; 4] },
        sourcePosition: DrrFloat3 { x: 0.0, y: 0.0, z: 0.0 },
        spectrumLutAddress: spectrum,
        muLutAddress: mu,
        enableEarlyExit: DrrBool(view.early_exit.into()),
        _padding: 0.0,
    }
}
