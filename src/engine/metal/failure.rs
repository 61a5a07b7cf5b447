//! Metal's errors as the library's.

use objc2::runtime::ProtocolObject;
use objc2_foundation::NSError;
use objc2_metal::{MTLCommandBuffer, MTLCommandBufferError, MTLCommandBufferStatus};

use crate::error::{Error, Result};

/// What Metal refused, in its words.
pub(super) fn refused(what: &str, error: &NSError) -> Error {
    Error::Unsupported(format!("{what}: {}", error.localizedDescription()))
}

/// What Metal refused without a word.
pub(super) fn none(what: &str) -> impl FnOnce() -> Error {
    move || Error::Unsupported(format!("Metal gives no {what}"))
}

/// Whether a completed command buffer did what it was to do. `bytes` are those of its results.
///
/// # Errors
/// `OutOfMemory`; `Device`, with Metal's words, when the GPU was lost, faulted or took too long.
pub(super) fn check(commands: &ProtocolObject<dyn MTLCommandBuffer>, bytes: usize) -> Result<()> {
    if commands.status() != MTLCommandBufferStatus::Error {
        return Ok(());
    }
    let Some(error) = commands.error() else {
        return Err(Error::Device("the GPU failed without a reason".into()));
    };
    if error.code() == MTLCommandBufferError::OutOfMemory.0.cast_signed() {
        return Err(Error::OutOfMemory { what: "a projection on the GPU".into(), bytes });
    }
    Err(Error::Device(format!("the GPU failed: {}", error.localizedDescription())))
}
