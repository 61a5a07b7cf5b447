//! The device of a context's engine.

use std::any::Any;
use std::ffi::{CStr, c_void};
use std::ptr::NonNull;
use std::sync::Arc;

#[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
use crate::engine::cuda;
use crate::engine::gpu::parallel::HeldField;
#[cfg(feature = "host")]
use crate::engine::host;
#[cfg(target_vendor = "apple")]
use crate::engine::metal::{self, Metal};
use crate::engine::{Backend, Engine};
use crate::error::{Error, Result};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::volume::Volume;

/// Which of an engine's devices.
#[derive(Debug, Clone, Copy, Default)]
pub struct DeviceChoice {
    index: usize,
    metal: Option<NonNull<c_void>>,
}

impl DeviceChoice {
    /// The nth device that the engine's driver lists. Engines of the CPU have the 0th only.
    pub fn index(index: usize) -> Self {
        Self { index, metal: None }
    }

    /// An `id<MTLDevice>` of the caller's; null, the system's default. Null for other engines.
    ///
    /// # Safety
    /// `device` is null or an object of that type.
    #[must_use]
    #[allow(unsafe_code, reason = "the pointer is believed")]
    pub unsafe fn with_metal(self, device: *mut c_void) -> Self {
        Self { metal: NonNull::new(device), ..self }
    }
}

/// A device that has been opened.
#[derive(Clone)]
pub(crate) enum Device {
    /// The engine runs on the CPU.
    None,
    /// An NVIDIA GPU.
    #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
    Cuda(Arc<cuda::Device>),
    /// An Apple GPU.
    #[cfg(target_vendor = "apple")]
    Metal(Arc<metal::Device>),
}

impl Device {
    /// Opens the device of an engine.
    ///
    /// # Errors
    /// `Unsupported`, with what is missing, when the engine is not there; `InvalidArgument` for a choice it does not have.
    pub(crate) fn open(backend: Backend, choice: DeviceChoice) -> Result<Self> {
        let device = match backend {
            #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
            Backend::Cuda => Self::Cuda(cuda::Device::open(choice.index)?),
            #[cfg(target_vendor = "apple")]
            Backend::Metal => Self::Metal(Arc::new(metal::Device::open(choice.metal)?)),
            Backend::Reference | Backend::Cpu => Self::None,
            #[cfg(feature = "host")]
            Backend::Host => Self::None,
            other => {
                let name = other.name();
                let text = format!("this library is built without the engine {name}");
                return Err(Error::Unsupported(text));
            }
        };
        if choice.metal.is_some() && backend != Backend::Metal {
            let valid = format!("NULL, because the engine is {}", backend.name());
            return Err(Error::invalid("metal_device", "not NULL", valid));
        }
        if choice.index > 0 && backend != Backend::Cuda {
            let on_cpu = matches!(device, Self::None);
            let why = if on_cpu { "runs on the CPU" } else { "is given a GPU and not its number" };
            let valid = format!("0, because the engine {} {why}", backend.name());
            return Err(Error::invalid("device_index", choice.index, valid));
        }
        Ok(device)
    }

    /// The device's name; empty for engines of the CPU.
    pub(crate) fn name(&self) -> &CStr {
        match self {
            Self::None => c"",
            #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
            Self::Cuda(device) => device.name(),
            #[cfg(target_vendor = "apple")]
            Self::Metal(device) => device.name(),
        }
    }

    /// The driver's version, in words; empty for engines of the CPU.
    pub(crate) fn driver(&self) -> String {
        match self {
            Self::None => String::new(),
            #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
            Self::Cuda(device) => device.driver(),
            #[cfg(target_vendor = "apple")]
            Self::Metal(_) => metal::Device::driver(),
        }
    }

    /// The engine that runs on this device.
    pub(crate) fn engine(&self, volume: &Arc<Volume>, scene: &Scene, plan: &Plan) -> Result<Box<dyn Engine>> {
        let _ = (volume, scene, plan);
        match self {
            Self::None => unreachable!("engines of the CPU need no device"),
            #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
            Self::Cuda(device) => Ok(Box::new(cuda::Cuda::new(device.clone(), volume, scene, plan)?)),
            #[cfg(target_vendor = "apple")]
            Self::Metal(device) => Ok(Box::new(Metal::new(device, volume, scene, plan)?)),
        }
    }

    /// A field with a border, z fastest, on this device, for parallel beams.
    ///
    /// # Errors
    /// `OutOfMemory`; `Device`.
    #[cfg_attr(
        not(feature = "host"),
        allow(clippy::needless_pass_by_value, reason = "the engine host keeps them")
    )]
    pub(crate) fn field(&self, values: Vec<f32>) -> Result<Box<dyn HeldField>> {
        match self {
            #[cfg(feature = "host")]
            Self::None => Ok(Box::new(host::Parallel::new(values))),
            #[cfg(not(feature = "host"))]
            Self::None => unreachable!("engines of the CPU need no device: {}", values.len()),
            #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
            Self::Cuda(device) => Ok(Box::new(cuda::Parallel::new(device, &values)?)),
            #[cfg(target_vendor = "apple")]
            Self::Metal(device) => Ok(Box::new(metal::Parallel::new(device, &values)?)),
        }
    }

    /// A texture of the caller's on this device, kept alive, for
    /// [`Volume::from_texture`](crate::volume::Volume::from_texture).
    ///
    /// # Errors
    /// `Unsupported` when the device is not Metal's; `InvalidArgument` when the texture does not fit the dimensions.
    ///
    /// # Safety
    /// `texture` is an `id<MTLTexture>` when the device is Metal's.
    #[allow(unsafe_code, reason = "the pointer is believed")]
    pub(crate) unsafe fn texture(
        &self,
        texture: NonNull<c_void>,
        dimensions: [usize; 3],
    ) -> Result<Arc<dyn Any + Send + Sync>> {
        let _ = (texture, dimensions);
        match self {
            #[cfg(target_vendor = "apple")]
            Self::Metal(device) => {
                // SAFETY: the caller's promise.
                let texture = unsafe { metal::Texture::retained(device, texture, dimensions)? };
                Ok(Arc::new(texture))
            }
            _ => Err(Error::Unsupported("only the engine metal reads a texture".into())),
        }
    }

    /// The floats at an address of the device; `None` for [`Device::None`], whose addresses are the process's own.
    ///
    /// # Errors
    /// `InvalidArgument`, which calls the address `argument`, when there is no such memory on the device.
    #[allow(unsafe_code, reason = "the address is the caller's, and believed")]
    pub(crate) unsafe fn floats(
        &self,
        argument: &str,
        address: u64,
        count: usize,
    ) -> Option<Result<Vec<f32>>> {
        let _ = (argument, address, count);
        match self {
            Self::None => None,
            #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
            // SAFETY: the caller's promise is the same.
            Self::Cuda(device) => Some(unsafe { device.floats(argument, address, count) }),
            #[cfg(target_vendor = "apple")]
            Self::Metal(_) => unreachable!("an Apple GPU reads them itself"),
        }
    }
}
