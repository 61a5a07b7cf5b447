//! A projector: one volume, one scene, one plan, one engine.

use std::sync::Arc;

use crate::engine::cpu::Cpu;
use crate::engine::reference::Reference;
use crate::engine::{Backend, Engine, Images, Job, Layers, ViewJob};
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::physics::SpectralModel;
use crate::plan::Plan;
use crate::raycast::Beam;
use crate::scene::{Algorithm, Scene, check_i0};
use crate::volume::Volume;

/// Where projectors run: an engine and its threads. Cheap to clone; may be used from many threads at once.
#[derive(Clone)]
pub struct Context {
    backend: Backend,
    threads: Arc<rayon::ThreadPool>,
}

/// Most threads of a context.
pub const MAX_THREADS: usize = 1024;

impl Context {
    /// A context with its own threads; 0 means one per core.
    pub fn new(backend: Backend, threads: usize) -> Result<Self> {
        if threads > MAX_THREADS {
            return Err(Error::invalid("threads", threads, format!("0 (one per core) … {MAX_THREADS}")));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let threads =
            pool.map_err(|error| Error::Unsupported(format!("threads cannot be started: {error}")))?;
        Ok(Self { backend, threads: Arc::new(threads) })
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
    /// Spectral tables of this view alone; `None`: the scene's.
    pub spectral: Option<SpectralModel>,
}

impl From<View> for ViewRequest {
    fn from(view: View) -> Self {
        Self { view, early_exit: false, spectral: None }
    }
}

impl Projector {
    /// Plans `scene` for `volume` and makes the context's engine ready.
    pub fn new(context: &Context, volume: Arc<Volume>, scene: Scene) -> Result<Self> {
        let plan = Plan::new(&scene, &volume, context.backend)?;
        let engine: Box<dyn Engine> = match context.backend {
            Backend::Cpu => Box::new(Cpu::new(volume.clone(), &scene, &plan)?),
            Backend::Reference => Box::new(Reference::new(volume.clone(), &scene, scene.algorithm)?),
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

    /// Projects `views`. `progress` is called from any thread with the number of rays finished since its last call.
    pub fn project(
        &self,
        views: &[ViewRequest],
        layers: Layers,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Images<f32>> {
        let views = self.jobs(views, layers)?;
        let job = Job { views: &views, layers, progress };
        self.context.install(|| self.engine.project(&job))
    }

    /// Projects `views` in float64 with the reference engine and any algorithm: the fast algorithm's twin, or
    /// [`Algorithm::Exact`].
    pub fn reference(
        &self,
        algorithm: Algorithm,
        views: &[ViewRequest],
        layers: Layers,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Images<f64>> {
        let views = self.jobs(views, layers)?;
        let job = Job { views: &views, layers, progress };
        let engine = Reference::new(self.volume.clone(), &self.scene, algorithm)?;
        self.context.install(|| engine.project_f64(&job))
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
            if let Some(given) = spectral.as_ref().map(SpectralModel::materials).filter(|&m| m != materials) {
                return Err(Error::invalid(
                    "materials of the view's tables",
                    given,
                    format!("{materials}, the scene's"),
                ));
            }
            spectral.as_ref().map_or(Ok(()), |model| check_i0(model.i0()))?;
            let beam = Beam::new(&request.view, self.volume.grid(), self.scene.detector)?;
            Ok(ViewJob { beam, early_exit: request.early_exit, spectral })
        };
        let views = views.iter().map(job).enumerate();
        views.map(|(v, job)| job.map_err(|error| error.of(&format!("views[{v}]")))).collect()
    }
}
