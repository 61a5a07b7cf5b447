//! A projector: one volume, one scene, one plan, one engine.

use std::sync::Arc;

use crate::allocation::reserved;
use crate::engine::cpu::Cpu;
#[cfg(feature = "host")]
use crate::engine::host::Host;
#[cfg(target_vendor = "apple")]
use crate::engine::metal::{self, Metal};
use crate::engine::reference::Reference;
use crate::engine::{Backend, Device, Engine, Images, Job, Layers, Progress, Report, ViewJob};
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::physics::SpectralModel;
use crate::plan::Plan;
use crate::raycast::Beam;
use crate::scene::{Algorithm, Scene, check_i0};
use crate::shared::DrrAddress;
use crate::volume::Volume;

/// Where projectors run: an engine and its threads. Cheap to clone; may be used from many threads at once.
#[derive(Clone)]
pub struct Context {
    backend: Backend,
    device: Device,
    threads: Arc<rayon::ThreadPool>,
}

/// Most threads of a context.
pub const MAX_THREADS: usize = 1024;

impl Context {
    /// A context with its own threads; 0 means one per core.
    pub fn new(backend: Backend, threads: usize) -> Result<Self> {
        Self::on(backend, Device::of(backend)?, threads)
    }

    /// A context whose engine runs on one device.
    fn on(backend: Backend, device: Device, threads: usize) -> Result<Self> {
        if threads > MAX_THREADS {
            return Err(Error::invalid("threads", threads, format!("0 (one per core) … {MAX_THREADS}")));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let threads =
            pool.map_err(|error| Error::Unsupported(format!("threads cannot be started: {error}")))?;
        Ok(Self { backend, device, threads: Arc::new(threads) })
    }

    /// A context on an Apple GPU of the caller's choice, whose contexts share what it holds.
    #[cfg(target_vendor = "apple")]
    pub fn on_metal(device: Arc<metal::Device>, threads: usize) -> Result<Self> {
        Self::on(Backend::Metal, Device::Metal(device), threads)
    }

    /// The Apple GPU, when the engine runs on one.
    #[cfg(target_vendor = "apple")]
    pub fn metal(&self) -> Option<&Arc<metal::Device>> {
        match &self.device {
            Device::Metal(device) => Some(device),
            Device::None => None,
        }
    }

    /// The engine.
    pub fn backend(&self) -> Backend {
        self.backend
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads.current_num_threads()
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
    /// GPU addresses of such tables, spectrum and mass attenuation, for an engine whose GPU reads them; 0: none.
    pub lut_addresses: [DrrAddress; 2],
}

impl From<View> for ViewRequest {
    fn from(view: View) -> Self {
        Self { view, early_exit: false, spectral: None, lut_addresses: [0, 0] }
    }
}

impl Projector {
    /// Plans `scene` for `volume` and makes the context's engine ready.
    pub fn new(context: &Context, volume: Arc<Volume>, scene: Scene) -> Result<Self> {
        let plan = Plan::new(&scene, &volume, context.backend)?;
        let engine: Box<dyn Engine> = match (context.backend, &context.device) {
            (Backend::Cpu, _) => Box::new(Cpu::new(volume.clone(), &scene, &plan)?),
            (Backend::Reference, _) => Box::new(Reference::new(volume.clone(), &scene, scene.algorithm)?),
            #[cfg(feature = "host")]
            (Backend::Host, _) => Box::new(context.install(|| Host::new(&volume, &scene, &plan))?),
            #[cfg(target_vendor = "apple")]
            (_, Device::Metal(device)) => {
                Box::new(context.install(|| Metal::new(device, &volume, &scene, &plan))?)
            }
            (other, _) => unreachable!("no context has the engine {}", other.name()),
        };
        Ok(Self { context: context.clone(), volume, scene, plan, engine })
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
    /// may still report them. [`SILENT`](crate::engine::SILENT) hears nothing.
    ///
    /// # Errors
    /// `InvalidArgument` for a view that is not valid or a layer that the scene does not have; `OutOfMemory`;
    /// `Cancelled`.
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

    /// Only a GPU's engine reads from GPU addresses.
    fn check_addresses(&self, addresses: [DrrAddress; 2]) -> Result<()> {
        let backend = self.context.backend;
        if addresses == [0, 0] || matches!(backend, Backend::Cuda | Backend::Metal) {
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
            Ok(ViewJob {
                beam,
                early_exit: request.early_exit,
                spectral,
                lut_addresses: request.lut_addresses,
            })
        };
        let mut jobs = reserved(views.len(), "the views")?;
        for (v, view) in views.iter().enumerate() {
            jobs.push(job(view).map_err(|error| error.of(&format!("views[{v}]")))?);
        }
        Ok(jobs)
    }
}
