//! A scene and a volume, ready for a kernel; and the views of a job.

use std::sync::Arc;

use crate::engine::gpu::beam::{beam, common_axis};
use crate::engine::gpu::definitions::Definitions;
use crate::engine::gpu::few::Few;
use crate::engine::gpu::spectra::{Spectra, WholeTables};
use crate::engine::gpu::voxels::{Density, DeviceVoxels, FRAME};
use crate::engine::gpu::wire::{Beam, Channels, Launch, columns};
use crate::engine::{Layers, SignalsJob, ViewJob};
use crate::error::{Error, Result};
use crate::method::Algorithm;
use crate::physics::SpectralModel;
use crate::plan::Plan;
use crate::scene::Scene;
use crate::volume::Volume;

/// What does not change from job to job.
#[derive(Debug)]
pub(crate) struct Prepared {
    definitions: Definitions,
    launch: Launch,
    model: Arc<SpectralModel>,
    few: Option<Few>,
    whole_tables: WholeTables,
    bone: Option<u8>,
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Materials of the scene.
    pub materials: usize,
    /// Rays per pixel.
    pub rays_per_pixel: usize,
    /// Most views of one launch.
    pub most_views: usize,
}

/// Some views of a job, as one launch takes them.
#[derive(Debug)]
pub(crate) struct Views {
    pub launch: Launch,
    pub beams: Vec<Beam>,
    pub spectra: Spectra,
    pub definitions: Definitions,
    /// With sums by several rows of weights.
    pub channels: Option<Channels>,
}

impl Prepared {
    /// Of a scene and its plan; `voxels` are how the device holds `volume`.
    ///
    /// # Errors
    /// `Unsupported` when the kernel cannot number a view's pixels; `OutOfMemory`.
    pub(crate) fn new(volume: &Volume, voxels: &DeviceVoxels, scene: &Scene, plan: &Plan) -> Result<Self> {
        let materials = scene.materials.names().len();
        let [width, height, _] = voxels.framed().map(|n| n as u32);
        let stride = [1, width, width * height];
        let mut launch = Launch {
            dimensions: volume.grid().dimensions().map(|n| n as u32),
            bricks: voxels.bricks().map(|n| n as u32),
            stride,
            first_voxel: FRAME as u32 * stride.iter().sum::<u32>(),
            width: scene.detector[0] as u32,
            height: scene.detector[1] as u32,
            millimetres: columns(volume.grid().index_to_world().matrix3),
            step: 1.0.into(),
            ..Launch::default()
        };
        if let Algorithm::March { step } = plan.method.algorithm {
            launch.step = step.into();
        }
        // Of eight times the value, as codes have it.
        match voxels.density() {
            Some(Density::Line { slope }) => launch.scale = (slope / 8.0) as f32,
            Some(Density::Kink { slope, intercept, upper_slope }) => {
                launch.scale = (slope / 8.0) as f32;
                launch.kink = [(8.0 * intercept / slope) as f32, (upper_slope / slope) as f32];
            }
            Some(Density::Table(_)) | None => {}
        }
        let model = Arc::new(scene.spectral_model()?);
        launch.stand_in = std::array::from_fn(|label| voxels.stand_in(label as u8));
        Ok(Self {
            definitions: Definitions::of(plan, materials, voxels),
            launch,
            few: plan.quadrature.as_ref().map(|quadrature| Few::of(quadrature, &model)),
            model,
            whole_tables: WholeTables::of(scene)?,
            bone: scene.bone.filter(|&bone| volume.materials()[usize::from(bone)].labelled),
            size: scene.detector,
            materials,
            rays_per_pixel: scene.supersampling * scene.supersampling,
            most_views: most_views(scene.detector, materials)?,
        })
    }

    /// What a launch for some views takes.
    pub(crate) fn views(&self, views: &[ViewJob], layers: Layers) -> Views {
        // A truncated ray would be seen in every layer but the intensity and, walked on its own, the bone path.
        let may_stop = !layers.line_integral && !layers.areal_density;
        let lines: Vec<_> = views.iter().map(|view| view.beam.lines()).collect();
        let mut spectra = Spectra::default();
        let beams: Vec<_> = views
            .iter()
            .zip(&lines)
            .map(|(view, lines)| {
                let mut beam = beam(lines, view.early_exit && may_stop);
                if view.lut_addresses == [0, 0] {
                    spectra.set(view.spectral.as_ref().unwrap_or(&self.model), &mut beam);
                } else {
                    spectra.make_room(&self.whole_tables, &mut beam);
                }
                if let Some(few) = self.few.as_ref().filter(|_| view.has_the_scene_s_tables()) {
                    spectra.set_few(few, &mut beam);
                }
                beam
            })
            .collect();
        let few = self.few.is_some() && views.iter().any(ViewJob::has_the_scene_s_tables);
        let early_exit = may_stop && views.iter().any(|view| view.early_exit);
        // Without bone in the volume the kernel leaves the layer as it is.
        let bone = self.bone.filter(|_| layers.bone_path);
        let axis = common_axis(&lines, self.size);
        Views {
            launch: Launch { views: views.len() as u32, ..self.launch },
            definitions: self.definitions.for_job(layers, bone, (early_exit, few), axis),
            beams,
            spectra,
            channels: None,
        }
    }

    /// How many views of a job one launch takes; `None` where no kernel is made for its sums.
    pub(crate) fn views_of_signals(&self, job: &SignalsJob<'_>) -> Option<usize> {
        let planes = self.materials.max(job.rows.len()).max(job.materials_before(self.materials));
        // The signals are those of single rays.
        let there = self.rays_per_pixel == 1 && job.fits(self.materials);
        most_views(self.size, planes).ok().filter(|_| there)
    }

    /// What a launch for some views of a job takes.
    pub(crate) fn signals(&self, views: &[ViewJob], job: &SignalsJob<'_>) -> Views {
        let mut prepared = self.views(views, job.layers);
        let before = job.materials_before(self.materials);
        prepared.definitions = prepared.definitions.with_signals(job.rows.len(), before, job.open);
        prepared.channels = Some(prepared.spectra.set_rows(job, self.materials));
        prepared
    }
}

/// The kernel numbers pixels with 32 bits.
fn most_views([width, height]: [usize; 2], materials: usize) -> Result<usize> {
    match u32::MAX as usize / (width * height * materials) {
        0 => Err(Error::Unsupported(format!(
            "{width}×{height} pixels of {materials} materials are too many for GPU engines, which count to 2^32"
        ))),
        most => Ok(most),
    }
}
