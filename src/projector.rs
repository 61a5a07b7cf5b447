//! A projector: one volume, one scene, one plan, one engine.

use std::any::Any;
use std::ffi::{CStr, c_void};
use std::ptr::NonNull;
use std::sync::Arc;

use crate::accuracy::Certificate;
use crate::allocation::reserved;
use crate::engine::cpu::Cpu;
#[cfg(feature = "host")]
use crate::engine::host::Host;
use crate::engine::reference::Reference;
use crate::engine::{
    Backend, Device, DeviceChoice, DeviceOutputs, Engine, Images, Job, Layers, Progress, Report, SILENT,
    Timings, ViewJob, unsupported_queues,
};
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::method::Algorithm;
use crate::physics::SpectralModel;
use crate::plan::Plan;
use crate::planner::{self, Cache, Costs, Reach};
use crate::raycast::Beam;
use crate::scene::{Scene, check_i0};
use crate::shared::DrrAddress;
use crate::volume::Volume;

/// Where projectors run: an engine and its threads. Cheap to clone; may be used from many threads at once.
#[derive(Clone)]
pub struct Context {
    backend: Backend,
    device: Device,
    threads: Arc<rayon::ThreadPool>,
    costs: Arc<Costs>,
    plans: Arc<Cache>,
}

/// Most threads of a context.
pub const MAX_THREADS: usize = 1024;

impl Context {
    /// A context with its own threads; 0 means one per core. An engine with devices runs on its first.
    pub fn new(backend: Backend, threads: usize) -> Result<Self> {
        Self::on_device(backend, threads, DeviceChoice::default())
    }

    /// A context of the best engine that is there: on a GPU where one can be used.
    pub fn best(threads: usize, choice: DeviceChoice) -> Result<Self> {
        let [others @ .., always_there] = Backend::BEST_FIRST;
        for backend in others {
            match Self::on_device(backend, threads, choice) {
                Err(Error::Unsupported(_)) => {}
                made => return made,
            }
        }
        Self::on_device(always_there, threads, choice)
    }

    /// As [`Context::new`], on the device of one's choice.
    ///
    /// # Errors
    /// `Unsupported`, with what is missing, when the engine is not there or its threads cannot be started;
    /// `InvalidArgument` for a device that it does not have.
    pub fn on_device(backend: Backend, threads: usize, choice: DeviceChoice) -> Result<Self> {
        if threads > MAX_THREADS {
            return Err(Error::invalid("threads", threads, format!("0 (one per core) … {MAX_THREADS}")));
        }
        let device = Device::open(backend, choice)?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let threads =
            pool.map_err(|error| Error::Unsupported(format!("threads cannot be started: {error}")))?;
        let (costs, plans) = (Arc::default(), Arc::default());
        Ok(Self { backend, device, threads: Arc::new(threads), costs, plans })
    }

    /// The engine.
    pub fn backend(&self) -> Backend {
        self.backend
    }

    /// The name of the engine's device; empty for engines of the CPU.
    pub fn device_name(&self) -> &CStr {
        self.device.name()
    }

    /// The version of the device's driver, in words; empty for engines of the CPU.
    pub fn device_driver(&self) -> String {
        self.device.driver()
    }

    /// A 3D texture of int16 HU that a pipeline of the caller's has on the GPU, for [`Volume::from_texture`]; it is kept
    /// alive. Its texels are read when views are projected, and must not be written meanwhile.
    ///
    /// # Errors
    /// `Unsupported` unless the engine is `metal`; `InvalidArgument` when it is not an `MTLTextureType3D` of
    /// `MTLPixelFormatR16Sint` with `MTLTextureUsageShaderRead`, of these dimensions, on the context's GPU.
    ///
    /// # Safety
    /// If the engine is `metal`, `texture` is null or an `id<MTLTexture>`.
    #[allow(unsafe_code, reason = "the pointer is believed")]
    pub unsafe fn texture(
        &self,
        texture: *mut c_void,
        dimensions: [usize; 3],
    ) -> Result<Arc<dyn Any + Send + Sync>> {
        let null = || Error::invalid("texture", "NULL", "a texture");
        // SAFETY: the caller's promise is the same.
        unsafe { self.device.texture(NonNull::new(texture).ok_or_else(null)?, dimensions) }
    }

    /// Whether the engine has queues to put a projection into.
    ///
    /// # Errors
    /// `Unsupported` when it has none: on the CPU.
    pub(crate) fn check_queues(&self) -> Result<()> {
        if matches!(self.device, Device::None) { Err(unsupported_queues()) } else { Ok(()) }
    }

    pub(crate) fn device(&self) -> &Device {
        &self.device
    }

    /// The same context, whose planner believes these costs.
    #[must_use]
    pub fn with_costs(self, costs: Costs) -> Self {
        Self { costs: Arc::new(costs), plans: Arc::default(), ..self }
    }

    /// What its planner believes.
    pub fn costs(&self) -> &Costs {
        &self.costs
    }

    pub(crate) fn plans(&self) -> &Cache {
        &self.plans
    }

    /// The engine `cpu` on the same threads.
    pub(crate) fn on_cpu(&self) -> Self {
        Self { backend: Backend::Cpu, device: Device::None, plans: Arc::default(), ..self.clone() }
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads.current_num_threads()
    }

    /// Threads that an engine of the CPU works on; 1 for engines of a device.
    pub fn work_threads(&self) -> usize {
        if self.backend.has_device() { 1 } else { self.threads() }
    }

    /// Runs `work`, whose parallel parts then use this context's threads.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.threads.install(work)
    }
}

/// Projects one volume as one scene says. Immutable: may be used from many threads at once.
pub struct Projector {
    context: Context,
    volume: Arc<Volume>,
    scene: Scene,
    plan: Plan,
    engine: Box<dyn Engine>,
}

/// One view, and what is special about it.
#[derive(Debug, Clone)]
pub struct ViewRequest {
    /// Where the rays are.
    pub view: View,
    /// Whether a ray may stop once every energy bin is attenuated below e⁻¹⁵. Only the intensity can change, by at
    /// most e⁻¹⁵·I0; when other layers that the stop would change are asked for, rays are not stopped.
    pub early_exit: bool,
    /// Spectral tables of this view alone, which views may share; `None`: the scene's.
    pub spectral: Option<Arc<SpectralModel>>,
    /// GPU addresses of such tables, spectrum and mass attenuation, which the engine `metal` reads in
    /// [`Projector::encode`]; 0: none.
    pub lut_addresses: [DrrAddress; 2],
}

impl From<View> for ViewRequest {
    fn from(view: View) -> Self {
        Self { view, early_exit: false, spectral: None, lut_addresses: [0, 0] }
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
        let plan = Plan::new(&scene, &volume, context.backend, reach.quadrature(&scene)?)?;
        Self::planned(context, volume, scene, plan)
    }

    /// The same plan for one ray per pixel of a detector of another size.
    pub(crate) fn with_detector(&self, size: [usize; 2]) -> Result<Self> {
        let scene = Scene { detector: size, supersampling: 1, ..self.scene.clone() };
        let plan = Plan { detector: size, supersampling: 1, ..self.plan.clone() };
        Self::planned(&self.context, self.volume.clone(), scene, plan)
    }

    pub(crate) fn planned(context: &Context, volume: Arc<Volume>, scene: Scene, plan: Plan) -> Result<Self> {
        let engine: Box<dyn Engine> = match context.backend {
            Backend::Cpu => Box::new(context.install(|| Cpu::new(volume.clone(), &scene, &plan))?),
            Backend::Reference => Box::new(Reference::new(volume.clone(), &scene, plan.method.algorithm)?),
            #[cfg(feature = "host")]
            Backend::Host => Box::new(context.install(|| Host::new(&volume, &scene, &plan))?),
            _ => context.install(|| context.device.engine(&volume, &scene, &plan))?,
        };
        Ok(Self { context: context.clone(), volume, scene, plan, engine })
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
    /// rays finished since its last call: after every few hundred rays of a thread. Answering
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
        let views = self.jobs(views, layers)?;
        let job = Job { views: &views, layers, progress: Progress::new(progress) };
        self.context.install(|| self.engine.project(&job))
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
    /// as many of the views as one launch takes: what areal densities save. `None` for engines without it.
    ///
    /// # Errors
    /// As [`Projector::project`].
    pub fn specification_loop(&self, views: &[ViewRequest]) -> Result<Option<f64>> {
        if views.is_empty() {
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
        let views = self.jobs(views, layers)?;
        let job = Job { views: &views, layers, progress: Progress::new(progress) };
        let engine = Reference::new(self.volume.clone(), &self.scene, algorithm)?;
        self.context.install(|| engine.project_f64(&job))
    }

    /// The other engines read tables before they project.
    fn check_addresses(&self, addresses: [DrrAddress; 2]) -> Result<()> {
        let backend = self.context.backend;
        if addresses == [0, 0] || backend == Backend::Metal {
            return Ok(());
        }
        let value = format!("{addresses:#x?}");
        Err(Error::invalid("lut_addresses", value, format!("[0, 0] on the engine {}", backend.name())))
    }

    fn jobs(&self, views: &[ViewRequest], layers: Layers) -> Result<Vec<ViewJob>> {
        if layers.bone_path && self.scene.bone.is_none() {
            return Err(Error::invalid(
                "bone_path",
                "asked for",
                "only when the scene says which material is bone",
            ));
        }
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
