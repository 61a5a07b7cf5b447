//! The device that a context's engine runs on.

#[cfg(target_vendor = "apple")]
use std::sync::Arc;

use crate::engine::Backend;
#[cfg(target_vendor = "apple")]
use crate::engine::metal;
use crate::error::{Error, Result};

/// A device that projectors share.
#[derive(Clone)]
pub(crate) enum Device {
    /// The engine runs on the host.
    None,
    /// An Apple GPU.
    #[cfg(target_vendor = "apple")]
    Metal(Arc<metal::Device>),
}

impl Device {
    /// The device that an engine runs on unless another is named.
    ///
    /// # Errors
    /// `Unsupported` when this build or this machine does not have the engine.
    pub(crate) fn of(backend: Backend) -> Result<Self> {
        match backend {
            Backend::Reference | Backend::Cpu => Ok(Self::None),
            Backend::Host if cfg!(feature = "host") => Ok(Self::None),
            #[cfg(target_vendor = "apple")]
            Backend::Metal => Ok(Self::Metal(Arc::new(metal::Device::system_default()?))),
            other => {
                let text = format!("this library is built without the engine {}", other.name());
                Err(Error::Unsupported(text))
            }
        }
    }
}
