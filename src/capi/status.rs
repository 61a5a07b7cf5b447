//! Status codes and the message of the last failure.

use std::ffi::c_char;

use crate::capi::boundary;
use crate::error::Error;

/// What a call came to: one of the DRR_STATUS constants. A later version may add codes; anything but DRR_STATUS_OK
/// is a failure, after which nothing that the call would have written has been written.
pub type DrrStatus = u32;

/// The call did what it says.
pub const DRR_STATUS_OK: DrrStatus = 0;
/// An argument is NULL, misaligned, not finite or outside its range. The message names it, its value and what is
/// valid.
pub const DRR_STATUS_INVALID_ARGUMENT: DrrStatus = 1;
/// The request is valid, but this build, this machine or this engine cannot serve it.
pub const DRR_STATUS_UNSUPPORTED: DrrStatus = 2;
/// An allocation was refused.
pub const DRR_STATUS_OUT_OF_MEMORY: DrrStatus = 3;
/// A defect of the library. The process can go on; please report the message. The handles that the call was given are
/// poisoned: later calls with them fail in the same way, except drr_projector_describe and the handle's own _destroy.
/// What was made from them before is not affected.
pub const DRR_STATUS_INTERNAL: DrrStatus = 4;
/// The caller's DrrProgress function answered false.
pub const DRR_STATUS_CANCELLED: DrrStatus = 5;

/// A GPU or its driver failed: lost, reset, or an internal error. What was made with its context may be unusable from
/// now on; a new context can tell whether the GPU is.
pub const DRR_STATUS_DEVICE: DrrStatus = 6;

/// A file is not there, cannot be read, is damaged, or is not what it claims to be. The message begins with its path.
pub const DRR_STATUS_FILE: DrrStatus = 7;

/// The status that stands for an error.
pub(super) fn of(error: &Error) -> DrrStatus {
    match error {
        Error::InvalidArgument { .. } => DRR_STATUS_INVALID_ARGUMENT,
        Error::Unsupported(_) => DRR_STATUS_UNSUPPORTED,
        Error::OutOfMemory { .. } => DRR_STATUS_OUT_OF_MEMORY,
        Error::Cancelled => DRR_STATUS_CANCELLED,
        Error::Device(_) => DRR_STATUS_DEVICE,
        Error::File { .. } => DRR_STATUS_FILE,
        Error::Poisoned { .. } => DRR_STATUS_INTERNAL,
    }
}

/// The name of `status`, such as "DRR_STATUS_OK", or "unknown status". A static string; never NULL. Any thread.
#[unsafe(no_mangle)]
pub extern "C" fn drr_status_name(status: DrrStatus) -> *const c_char {
    let name = match status {
        DRR_STATUS_OK => c"DRR_STATUS_OK",
        DRR_STATUS_INVALID_ARGUMENT => c"DRR_STATUS_INVALID_ARGUMENT",
        DRR_STATUS_UNSUPPORTED => c"DRR_STATUS_UNSUPPORTED",
        DRR_STATUS_OUT_OF_MEMORY => c"DRR_STATUS_OUT_OF_MEMORY",
        DRR_STATUS_INTERNAL => c"DRR_STATUS_INTERNAL",
        DRR_STATUS_CANCELLED => c"DRR_STATUS_CANCELLED",
        DRR_STATUS_DEVICE => c"DRR_STATUS_DEVICE",
        DRR_STATUS_FILE => c"DRR_STATUS_FILE",
        _ => c"unknown status",
    };
    name.as_ptr()
}

/// Why the last failing call of this thread failed, in UTF-8: the argument, its value and the valid range. Empty
/// before the first failure; a call that succeeds leaves it alone. Never NULL.
///
/// Owned by the library and valid until the next failing call of this thread or the thread's end. Each thread has
/// its own.
#[unsafe(no_mangle)]
pub extern "C" fn drr_last_error_message() -> *const c_char {
    boundary::last_message()
}
