//! Contexts: which engine runs, on how many threads.

use crate::Context;
use crate::capi::boundary::guard;
use crate::capi::handle::{self, Opaque};
use crate::capi::status::DrrStatus;
use crate::capi::{memory, options};
use crate::engine::Backend;
use crate::error::{Error, Result};

/// An engine: one of the DRR_BACKEND constants. Other values are refused.
pub type DrrBackend = u32;

/// The fastest engine that this machine has.
pub const DRR_BACKEND_AUTO: DrrBackend = 0;
/// float32 on all cores. Always there.
pub const DRR_BACKEND_CPU: DrrBackend = 1;
/// float64, without shortcuts: slow, and what the other engines are measured against. Always there.
pub const DRR_BACKEND_REFERENCE: DrrBackend = 2;

/// How a context is made. Fill it with drr_context_options_init, then change what should differ.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrContextOptions {
    /// Set by drr_context_options_init.
    pub struct_size: usize,
    /// The engine. Default DRR_BACKEND_AUTO.
    pub backend: DrrBackend,
    /// Threads that project, 0 to 1024. Default 0: one per core. The images do not depend on it.
    pub thread_count: u32,
}

// SAFETY: repr(C), no padding (asserted), starts with its size, integers only.
unsafe impl options::Options for DrrContextOptions {
    const SIZES: &'static [usize] = &[size_of::<usize>() + 8];
    fn defaults() -> Self {
        Self { struct_size: size_of::<Self>(), backend: DRR_BACKEND_AUTO, thread_count: 0 }
    }
}

const _: () = assert!(size_of::<DrrContextOptions>() == size_of::<usize>() + 8);

/// An engine and its threads. Immutable: any number of threads may use one at once. What is made from a context
/// keeps it alive, so it may be destroyed as soon as it is no longer named.
pub struct DrrContext {
    _opaque: [u8; 0],
}

impl Opaque for DrrContext {
    type Value = Context;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr ctxt");
    const NAME: &'static str = "DrrContext";
}

fn backend(code: DrrBackend) -> Result<Backend> {
    match code {
        DRR_BACKEND_AUTO | DRR_BACKEND_CPU => Ok(Backend::Cpu),
        DRR_BACKEND_REFERENCE => Ok(Backend::Reference),
        _ => Err(Error::invalid("options.backend", code, "one of the DRR_BACKEND constants, 0 … 2")),
    }
}

/// Fills `*options` with the defaults and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_context_options_init(options: *mut DrrContextOptions) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("options", options) })
}

/// Makes a context and starts its threads.
///
/// `options` is only read during the call; NULL means all defaults. On success `*context` is a new handle, to be
/// given to drr_context_destroy; on failure `*context` is left as it is. Fails with DRR_STATUS_INVALID_ARGUMENT, or
/// with DRR_STATUS_UNSUPPORTED when the threads cannot be started. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_context_create(
    options: *const DrrContextOptions,
    context: *mut *mut DrrContext,
) -> DrrStatus {
    guard(|| {
        memory::check("context", context, 1)?;
        let options = if options.is_null() {
            <DrrContextOptions as options::Options>::defaults()
        } else {
            // SAFETY: the C caller passes a struct of the size that it says.
            unsafe { options::read("options", options)? }
        };
        let made = Context::new(backend(options.backend)?, options.thread_count as usize)
            .map_err(|error| error.called("threads", "options.thread_count"))?;
        // SAFETY: `context` is not null and aligned; the C caller passes a place for one handle.
        unsafe { context.write(handle::create(made)) };
        Ok(())
    })
}

/// Gives a context up; what was made from it stays valid. NULL is nothing. Afterwards the pointer must not be used.
/// Its threads end soon after its last child's end, on their own time: do not unload the library.
///
/// Fails, and changes nothing, for a pointer that is recognised as no live context: another type's handle, and
/// often, but not always, one that has been destroyed before. Any thread, but no other call may be given the handle
/// meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_context_destroy(context: *mut DrrContext) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("context", context) })
}
