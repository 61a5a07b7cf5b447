//! A projector: one volume, one scene, one plan, one engine.

use std::ffi::c_void;
use std::sync::Arc;

use crate::accuracy::Certificate;
use crate::allocation::reserved;
use crate::context::Context;
use crate::engine::cpu::Cpu;
#[cfg(feature = "host")]
use crate::engine::host::Host;
use crate::engine::reference::Reference;
use crate::engine::{
    Backend, DeviceOutputs, Engine, Images, Job, Layers, Progress, Report, SILENT, Timings, ViewJob,
};
use crate::error::{Error, Result};
use crate::exposure::{Exposure, Focus, March, RayCaster, Sample, StageTimes};
use crate::geometry::View;
use crate::method::Algorithm;
use crate::physics::SpectralModel;
use crate::plan::Plan;
use crate::planner::{self, Reach};
use crate::raycast::Beam;
use crate::scene::{Scene, check_i0};
use crate::shared::DrrAddress;
use crate::volume::Volume;

/// Projects one volume as one scene says. Immutable: may be used from many threads at once.
pub struct Projector {
    context: Context,
    volume: Arc<Volume>,
    scene: Scene,
    /// The scene with what the plan left of its effects.
    simulated: Scene,
    plan: Plan,
    engine: Box<dyn Engine>,
}

/// One view, and what is special about it.
#[derive(Debug, Clone)]
pub struct ViewRequest {
    /// Where the rays are.
    pub view: View,
    /// Whether a ray may stop once every energy bin is attenuated below e⁻¹⁵. Only the intensity can change, by at
    /// most e⁻¹⁵·I0; when other layers that the stop would change are asked for, rays are not stopped. Nor are rays that
    /// the engine `cpu` casts side by side: Joseph's, where pixels are dense.
    pub early_exit: bool,
    /// Spectral tables of this view alone, which views may share; `None`: the scene's.
    pub spectral: Option<Arc<SpectralModel>>,
    /// GPU addresses of such tables, spectrum and mass attenuation, which the engine `metal` reads in
    /// [`Projector::encode`]; 0: none.
    pub lut_addresses: [DrrAddress; 2],
    /// Pixels from one ray of the view to the next, at least 1: more where it has only some pixels of a detector, every
    /// `stride`th of every `stride`th row. They are that much narrower than their distances, for algorithms that ask.
    pub stride: usize,
    /// Which view it is, counted from 0: with the seed it decides the noise. `None`: its place among the views of the call.
    /// A view has the same images in every call that gives it the same number, whatever other views are in it.
    pub number: Option<usize>,
}

impl From<View> for ViewRequest {
    fn from(view: View) -> Self {
        Self { view, early_exit: false, spectral: None, lut_addresses: [0, 0], stride: 1, number: None }
    }
}

impl ViewRequest {
    /// # Errors
    /// `InvalidArgument` for a stride of 0.
    pub(crate) fn checked_stride(&self) -> Result<usize> {
        if self.stride == 0 { Err(Error::invalid("stride", 0, "at least 1")) } else { Ok(self.stride) }
    }
}

impl Projector {
    /// Plans `scene` for `volume` and makes the context's engine ready. A tolerance, or few energies, are planned by casting
    /// some of the rays of the scene's expected views.
    ///
    /// # Errors
    /// `InvalidArgument` for a scene that is not valid or does not fit the volume, and for a tolerance that no method
    /// keeps; `Unsupported` for what the engine does not have; `OutOfMemory`; `Device` when a GPU fails.
    pub fn new(context: &Context, volume: Arc<Volume>, scene: Scene) -> Result<Self> {
        let plan = planner::plan(context, &volume, &scene)?;
        Self::planned(context, volume, scene, plan)
    }

    /// As [`Projector::new`], for a caller who knows what rays will meet, of a scene without a tolerance.
    pub fn with_reach(context: &Context, volume: Arc<Volume>, scene: Scene, reach: &Reach) -> Result<Self> {
        scene.validate()?;
        context.look_into(&volume)?;
        let plan = Plan::new(&scene, &volume, context.backend(), reach.quadrature(&scene)?)?;
        Self::planned(context, volume, scene, plan)
    }

    /// The same plan, without effects, for one ray per pixel of a detector of another size.
    pub(crate) fn with_detector(&self, size: [usize; 2]) -> Result<Self> {
        Self::planned(&self.context, self.volume.clone(), self.scene.of_rays(size), self.plan.of_rays(size))
    }

    pub(crate) fn planned(context: &Context, volume: Arc<Volume>, scene: Scene, plan: Plan) -> Result<Self> {
        let simulated = Scene { effects: plan.effects.clone(), ..scene.clone() };
        // Effects take the areal densities of single rays.
        let rays = simulated.ray_grid();
        let engine = if simulated.has_effects() {
            Self::engine(context, &volume, &scene.of_rays(rays), &plan.of_rays(rays))?
        } else {
            Self::engine(context, &volume, &simulated, &plan)?
        };
        Ok(Self { context: context.clone(), volume, scene, simulated, plan, engine })
    }

    fn engine(
        context: &Context,
        volume: &Arc<Volume>,
        scene: &Scene,
        plan: &Plan,
    ) -> Result<Box<dyn Engine>> {
        Ok(match context.backend() {
            Backend::Cpu => Box::new(context.install(|| Cpu::new(volume.clone(), scene, plan))?),
            Backend::Reference => Box::new(Reference::new(volume.clone(), scene, plan.method.algorithm)?),
            #[cfg(feature = "host")]
            Backend::Host => Box::new(context.install(|| Host::new(volume, scene, plan))?),
            _ => context.install(|| context.device().engine(volume, scene, plan))?,
        })
    }

    pub(crate) fn context(&self) -> &Context {
        &self.context
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The volume.
    pub fn volume(&self) -> &Arc<Volume> {
        &self.volume
    }

    /// Projects `views`. `progress` is called from the context's threads, also from several at once, with the number of
    /// rays finished since its last call, also none: after every few hundred rays' worth of a thread's work. Answering
    /// [`ControlFlow::Break`](std::ops::ControlFlow::Break) cancels: each thread finishes at most 1024 more rays, and
    /// may still report them. An engine on a GPU reports after every few views, and stops there.
    /// [`SILENT`](crate::engine::SILENT) hears nothing.
    ///
    /// # Errors
    /// `InvalidArgument` for a view that is not valid or a layer that the scene does not have; `OutOfMemory`;
    /// `Cancelled`; `Device` when a GPU fails.
    pub fn project(
        &self,
        views: &[ViewRequest],
        layers: Layers,
        progress: Report<'_>,
    ) -> Result<Images<f32>> {
        Ok(self.project_timed(views, layers, progress)?.0)
    }

    /// As [`Projector::project`], with what the stages of a scene with effects took.
    ///
    /// # Errors
    /// As [`Projector::project`].
    pub fn project_timed(
        &self,
        views: &[ViewRequest],
        layers: Layers,
        progress: Report<'_>,
    ) -> Result<(Images<f32>, StageTimes)> {
        if self.simulated.has_effects() {
            let algorithm = self.plan.method.algorithm;
            return self.develop(algorithm, views, layers, progress, &*self.engine);
        }
        let views = self.jobs(views, layers)?;
        let job = Job { views: &views, layers, progress: Progress::new(progress) };
        let images = self.context.install(|| self.engine.project(&job))?;
        Ok((images, StageTimes::default()))
    }

    /// Casts the rays of `views` and keeps what they met: images of other spectra, detectors and effects after the march can
    /// be had of it at a small part of the time. It has the path through bone where the scene has bone. `progress` as in
    /// [`Projector::project`].
    ///
    /// # Errors
    /// As [`Projector::project`]; also for a view with tables of its own.
    pub fn expose(&self, views: &[ViewRequest], progress: Report<'_>) -> Result<Exposure<f32>> {
        let bone_path = self.scene.bone.is_some();
        let march = self.march(self.plan.method.algorithm, bone_path, progress);
        if self.simulated.has_effects() || self.scene.supersampling == 1 {
            return march.expose(views, &*self.engine);
        }
        let rays = self.with_detector(self.scene.ray_grid())?;
        march.expose(views, &*rays.engine)
    }

    fn march<'a>(&'a self, algorithm: Algorithm, bone_path: bool, progress: Report<'a>) -> March<'a> {
        March {
            context: &self.context,
            volume: &self.volume,
            asked: &self.scene,
            scene: &self.simulated,
            focus: self.plan.focus.as_ref().map_or(Focus::Points, |choice| choice.focus),
            algorithm,
            bone_path,
            developed: None,
            progress,
        }
    }

    /// Exposes and develops one view after the other: no more than one view's rays are held. Engines that sum over energies
    /// themselves return signals instead of areal densities.
    fn develop<T: Sample>(
        &self,
        algorithm: Algorithm,
        views: &[ViewRequest],
        layers: Layers,
        progress: Report<'_>,
        caster: &(impl RayCaster<T> + ?Sized),
    ) -> Result<(Images<T>, StageTimes)> {
        self.scene.check_layers(layers)?;
        let (materials, times) = (self.scene.materials.names().len(), StageTimes::default());
        let (size, detector_layers) = (self.scene.detector, self.scene.layers());
        let mut all = Images::of_layers(size, views.len(), materials, detector_layers, layers)?;
        let march = March { developed: Some(layers), ..self.march(algorithm, layers.bone_path, progress) };
        for v in 0..views.len() {
            let exposure = times.of("ray march", || march.expose_nth(views, v, caster))?;
            let (images, stages) = exposure.developed(&self.simulated, layers)?;
            times.add_all(&stages);
            all.put(v, &images);
        }
        Ok((all, times))
    }

    /// Rays that are cast for `views`: what [`Projector::project`] reports in all.
    pub fn rays(&self, views: &[ViewRequest]) -> usize {
        let march = self.march(self.plan.method.algorithm, false, SILENT);
        views.iter().map(|view| march.rays(&view.view)).sum()
    }

    /// Puts the projection of `views` into a queue of the device's, and returns without waiting for it. What the call
    /// is given beside queue and outputs is free again when it returns. The first call with new layers compiles a
    /// kernel.
    ///
    /// # Safety
    /// `queue` and `outputs` are as [`DeviceOutputs`] says.
    ///
    /// # Errors
    /// `Unsupported` for engines of the CPU; otherwise as [`Projector::project`].
    #[allow(unsafe_code, reason = "queue and outputs are the caller's, and believed")]
    pub unsafe fn encode(
        &self,
        views: &[ViewRequest],
        queue: *mut c_void,
        outputs: &DeviceOutputs,
    ) -> Result<()> {
        if self.simulated.has_effects() {
            let text = "effects and second detector layers are developed on the CPU after the march, so that no queue can \
                        hold them: project the scene, or encode one without them";
            return Err(Error::Unsupported(text.into()));
        }
        let layers = outputs.layers();
        let views = self.jobs(views, layers)?;
        let job = Job { views: &views, layers, progress: Progress::new(SILENT) };
        // SAFETY: the caller's promise is the same.
        unsafe { self.engine.encode(&job, queue, outputs) }
    }

    /// How wrong images of these views are; see [`Certificate`].
    ///
    /// # Errors
    /// As [`Projector::project`]; `Unsupported` for a volume in a texture.
    pub fn certify(&self, views: &[View]) -> Result<Certificate> {
        Certificate::new(self, views)
    }

    /// What the engine's device measured so far; `None` for engines of the CPU, which the caller can time.
    pub fn timings(&self) -> Option<Timings> {
        self.engine.timings()
    }

    /// Seconds of the kernel that has the specification's own inner loop, one accumulator per energy along the ray, for
    /// as many of the views as one launch takes: what areal densities save. `None` for engines without it, and with effects.
    ///
    /// # Errors
    /// As [`Projector::project`].
    pub fn specification_loop(&self, views: &[ViewRequest]) -> Result<Option<f64>> {
        if views.is_empty() || self.simulated.has_effects() {
            return Ok(None);
        }
        let layers = Layers { intensity: true, ..Layers::default() };
        self.engine.specification_loop(&self.jobs(views, layers)?)
    }

    /// Bytes per second, read and written, of one copy between two buffers of the device as large as the volume's;
    /// `None` for engines of the CPU.
    ///
    /// # Errors
    /// `OutOfMemory` when the device has no room for the copy.
    pub fn copy_bandwidth(&self) -> Result<Option<f64>> {
        self.engine.copy_bandwidth()
    }

    /// Projects `views` in float64 with the reference engine and any algorithm: the fast algorithm's twin, or
    /// [`Algorithm::Exact`]. `progress` and errors as in [`Projector::project`].
    pub fn reference(
        &self,
        algorithm: Algorithm,
        views: &[ViewRequest],
        layers: Layers,
        progress: Report<'_>,
    ) -> Result<Images<f64>> {
        if self.simulated.has_effects() {
            let rays = self.scene.of_rays(self.scene.ray_grid());
            let engine = Reference::new(self.volume.clone(), &rays, algorithm)?;
            return Ok(self.develop(algorithm, views, layers, progress, &engine)?.0);
        }
        let views = self.jobs(views, layers)?;
        let job = Job { views: &views, layers, progress: Progress::new(progress) };
        let engine = Reference::new(self.volume.clone(), &self.scene, algorithm)?;
        self.context.install(|| engine.project_f64(&job))
    }

    /// The other engines read tables before they project.
    fn check_addresses(&self, addresses: [DrrAddress; 2]) -> Result<()> {
        let backend = self.context.backend();
        if addresses == [0, 0] || backend == Backend::Metal {
            return Ok(());
        }
        let value = format!("{addresses:#x?}");
        Err(Error::invalid("lut_addresses", value, format!("[0, 0] on the engine {}", backend.name())))
    }

    fn jobs(&self, views: &[ViewRequest], layers: Layers) -> Result<Vec<ViewJob>> {
        self.scene.check_layers(layers)?;
        let materials = self.scene.materials.names().len();
        let job = |request: &ViewRequest| {
            let spectral = request.spectral.clone();
            if let Some(given) = spectral.as_ref().map(|model| model.materials()).filter(|&m| m != materials)
            {
                return Err(Error::invalid(
                    "materials of the view's tables",
                    given,
                    format!("{materials}, the scene's"),
                ));
            }
            spectral.as_ref().map_or(Ok(()), |model| check_i0(model.i0()))?;
            self.check_addresses(request.lut_addresses)?;
            let beam = Beam::new(&request.view, self.volume.grid(), self.scene.detector)?;
            let beam = beam.of_parts(request.checked_stride()?);
            let lut_addresses = request.lut_addresses;
            Ok(ViewJob { beam, early_exit: request.early_exit, spectral, lut_addresses })
        };
        let mut jobs = reserved(views.len(), "the views")?;
        for (v, view) in views.iter().enumerate() {
            jobs.push(job(view).map_err(|error| error.of(&format!("views[{v}]")))?);
        }
        Ok(jobs)
    }
}
