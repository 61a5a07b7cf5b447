//! The device of a context's engine.

use std::ffi::{CStr, c_void};
use std::ptr::NonNull;
use std::sync::Arc;

#[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
use crate::engine::cuda;
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
        if choice.index > 0 && matches!(device, Self::None) {
            let valid = format!("0, because the engine {} runs on the CPU", backend.name());
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
        }
    }

    /// The driver's version, in words; empty for engines of the CPU.
    pub(crate) fn driver(&self) -> String {
        match self {
            Self::None => String::new(),
            #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
            Self::Cuda(device) => device.driver(),
        }
    }

    /// The engine that runs on this device.
    pub(crate) fn engine(&self, volume: &Arc<Volume>, scene: &Scene, plan: &Plan) -> Result<Box<dyn Engine>> {
        match self {
            Self::None => unreachable!(
                "no device is opened for the engine {}: {volume:p}, {scene:p}",
                plan.engine.name()
            ),
            #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
            Self::Cuda(device) => Ok(Box::new(cuda::Cuda::new(device.clone(), volume, scene, plan)?)),
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
        }
    }
}
