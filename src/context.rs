//! A context: an engine, its device and its threads.

use std::any::Any;
use std::ffi::{CStr, c_void};
use std::ptr::NonNull;
use std::sync::Arc;

use crate::effects::ScatterCache;
use crate::engine::{Backend, Device, DeviceChoice, unsupported_queues};
use crate::error::{Error, Result};
use crate::plan::Plan;
use crate::planner::{Cache, Costs};
use crate::volume::{Volume, Voxels};

/// Where projectors run: an engine and its threads. Cheap to clone; may be used from many threads at once.
#[derive(Clone)]
pub struct Context {
    backend: Backend,
    device: Device,
    threads: Arc<rayon::ThreadPool>,
    costs: Arc<Costs>,
    plans: Arc<Cache>,
    scatter: Arc<ScatterCache>,
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
        let (costs, plans, scatter) = (Arc::default(), Arc::default(), Arc::default());
        Ok(Self { backend, device, threads: Arc::new(threads), costs, plans, scatter })
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

    /// A 3D texture of int16 HU that a pipeline of the caller's has on the GPU, for [`Volume::from_texture`](crate::volume::Volume::from_texture); it is kept
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

    /// Has the context's threads find out what plans of its engine ask of a volume.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn look_into(&self, volume: &Volume) -> Result<()> {
        let is_here = !matches!(volume.voxels(), Voxels::Texture { .. });
        let looks = is_here && Plan::looks_into(self.backend, volume);
        if looks { self.install(|| volume.occupancy().map(|_| ())) } else { Ok(()) }
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

    pub(crate) fn scatter(&self) -> &ScatterCache {
        &self.scatter
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
