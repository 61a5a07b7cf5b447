//! What holds for every call.

use std::ffi::CStr;

use drr::capi::status::{
    DRR_STATUS_INVALID_ARGUMENT, DRR_STATUS_OK, DRR_STATUS_OUT_OF_MEMORY, DRR_STATUS_UNSUPPORTED, DrrStatus,
    drr_last_error_message,
};

/// The message of this thread's last failure.
fn message() -> String {
    // SAFETY: the message is never null, ends in NUL, and this thread does not fail while it is copied.
    let message = unsafe { CStr::from_ptr(drr_last_error_message()) };
    message.to_str().expect("UTF-8").to_owned()
}

/// Whether the call succeeded. If not, it must say why, and not that the library is at fault.
pub(super) fn succeeded(status: DrrStatus) -> bool {
    let failures = [DRR_STATUS_INVALID_ARGUMENT, DRR_STATUS_UNSUPPORTED, DRR_STATUS_OUT_OF_MEMORY];
    if status == DRR_STATUS_OK {
        return true;
    }
    let message = message();
    assert!(failures.contains(&status), "status {status}: {message}");
    assert!(!message.is_empty());
    false
}

/// A handle made by `create`, given where to write it. What it held before is not changed by a call that fails.
pub(super) fn made<O>(create: impl FnOnce(*mut *mut O) -> DrrStatus) -> Option<*mut O> {
    let before = std::ptr::dangling_mut::<O>();
    let mut handle = before;
    if succeeded(create(&raw mut handle)) {
        assert!(!handle.is_null() && handle != before);
        return Some(handle);
    }
    assert_eq!(handle, before, "written by a call that failed");
    None
}
