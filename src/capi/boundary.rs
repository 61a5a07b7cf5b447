//! The one place where errors and panics become a status.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::capi::status::{self, DRR_STATUS_INTERNAL, DRR_STATUS_OK, DrrStatus};
use crate::error::Result;

thread_local! {
    static LAST_MESSAGE: RefCell<CString> = RefCell::default();
}

/// Runs the body of a C function. An error or a panic leaves its message for [`last_message`] and becomes a status.
///
/// Unwind safety: a handle that the body had borrowed is poisoned by the panic, after which only its projector's plan is
/// read, a text that never changes; what the body was making is dropped with it.
pub(super) fn guard(body: impl FnOnce() -> Result<()>) -> DrrStatus {
    let (status, message) = match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => return DRR_STATUS_OK,
        Ok(Err(error)) => (status::of(&error), error.to_string()),
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().copied().map(str::to_owned);
            let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
            let text = text.unwrap_or_else(|| "a panic without a message".to_owned());
            (DRR_STATUS_INTERNAL, format!("internal error: {text}"))
        }
    };
    let message = CString::new(message.replace('\0', "\u{fffd}")).unwrap_or_default();
    // On a thread that is ending the message has nowhere to go; the status still tells.
    let _ = LAST_MESSAGE.try_with(|last| *last.borrow_mut() = message);
    status
}

/// The message of the calling thread's last failure.
pub(super) fn last_message() -> *const c_char {
    LAST_MESSAGE.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use super::*;
    use crate::capi::status::DRR_STATUS_OUT_OF_MEMORY;
    use crate::error::Error;

    fn message() -> String {
        // SAFETY: `last_message` is never null, ends in NUL and stays until this thread fails again.
        unsafe { CStr::from_ptr(last_message()) }.to_string_lossy().into_owned()
    }

    #[test]
    fn panics_and_errors_become_a_status_and_a_message() {
        assert_eq!(message(), "");
        assert_eq!(guard(|| panic!("bin {} of 136", 7)), DRR_STATUS_INTERNAL);
        assert_eq!(message(), "internal error: bin 7 of 136");
        assert_eq!(guard(|| Ok(())), DRR_STATUS_OK);
        assert_eq!(message(), "internal error: bin 7 of 136");
        let refused = || Err(Error::OutOfMemory { what: "a\0b".into(), bytes: 3 });
        assert_eq!(guard(refused), DRR_STATUS_OUT_OF_MEMORY);
        assert_eq!(message(), "out of memory: 3 bytes for a\u{fffd}b");
        let other = std::thread::spawn(message).join().expect("does not panic");
        assert_eq!(other, "", "each thread has its own");
    }
}
