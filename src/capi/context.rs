//! Contexts: which engine runs, on how many threads.

use std::ffi::{c_char, c_void};

use crate::Context;
use crate::capi::boundary::guard;
use crate::capi::handle::{self, Opaque};
use crate::capi::status::DrrStatus;
use crate::capi::{memory, options};
use crate::engine::{Backend, DeviceChoice};
use crate::error::{Error, Result};
use crate::planner::Costs;

/// An engine: one of the DRR_BACKEND constants. Other values are refused.
pub type DrrBackend = u32;

/// The fastest engine that this machine has: Metal, CUDA or the CPU's.
pub const DRR_BACKEND_AUTO: DrrBackend = 0;
/// float32 on all cores. Always there.
pub const DRR_BACKEND_CPU: DrrBackend = 1;
/// float64, without shortcuts: slow, and what the other engines are measured against. Always there.
pub const DRR_BACKEND_REFERENCE: DrrBackend = 2;
/// float32 on an NVIDIA GPU. There when NVIDIA's driver and run-time compiler (libcuda, libnvrtc) of CUDA 12 or later are.
pub const DRR_BACKEND_CUDA: DrrBackend = 3;
/// float32 on an Apple GPU.
pub const DRR_BACKEND_METAL: DrrBackend = 4;

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
    /// The GPU, an id<MTLDevice>, which the context keeps; for other engines than Metal's NULL. Default NULL: the
    /// system's default.
    pub metal_device: *mut c_void,
    /// Which of the GPUs that NVIDIA's driver lists; for engines of the CPU 0. Default 0.
    pub device_index: usize,
    /// What methods cost on this machine, which a scene's tolerance_hu chooses by: the text that `drr tradeoff --write-timings`
    /// writes. It is only read during drr_context_create. Default NULL: built-in rates.
    pub timings: *const c_char,
}

// SAFETY: repr(C), no padding (asserted), starts with its size, integers and raw pointers only.
unsafe impl options::Options for DrrContextOptions {
    const SIZES: &'static [usize] = &[OPTIONS_SIZE];
    fn defaults() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            backend: DRR_BACKEND_AUTO,
            thread_count: 0,
            metal_device: std::ptr::null_mut(),
            device_index: 0,
            timings: std::ptr::null(),
        }
    }
}

const OPTIONS_SIZE: usize = size_of::<[usize; 4]>() + 8;

const _: () = assert!(size_of::<DrrContextOptions>() == OPTIONS_SIZE);

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

/// The engines that C programs can name.
const ENGINES: [(DrrBackend, Backend); 4] = [
    (DRR_BACKEND_CPU, Backend::Cpu),
    (DRR_BACKEND_REFERENCE, Backend::Reference),
    (DRR_BACKEND_CUDA, Backend::Cuda),
    (DRR_BACKEND_METAL, Backend::Metal),
];

/// # Safety
/// `options.metal_device` and `options.timings` are as their descriptions say.
unsafe fn create(options: &DrrContextOptions) -> Result<Context> {
    let threads = options.thread_count as usize;
    // SAFETY: the caller's promise is the same.
    let choice = unsafe { DeviceChoice::index(options.device_index).with_metal(options.metal_device) };
    let made = match ENGINES.iter().find(|(code, _)| *code == options.backend) {
        Some(&(_, backend)) => Context::on_device(backend, threads, choice),
        None if options.backend == DRR_BACKEND_AUTO => Context::best(threads, choice),
        None => {
            let valid = "one of the DRR_BACKEND constants, 0 … 4";
            return Err(Error::invalid("options.backend", options.backend, valid));
        }
    };
    let made = made.map_err(|error| error.called("threads", "thread_count").of("options"))?;
    if options.timings.is_null() {
        return Ok(made);
    }
    // SAFETY: the caller's promise is the same.
    let timings = unsafe { memory::read_text("options.timings", options.timings)? };
    Costs::from_json(timings).map(|costs| made.with_costs(costs)).map_err(|error| error.of("options"))
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
/// with DRR_STATUS_UNSUPPORTED when the threads cannot be started or the engine is not there: the message says what is
/// missing. DRR_BACKEND_AUTO is always there. Any thread.
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
        // SAFETY: the C caller's device is as described.
        let made = unsafe { create(&options)? };
        // SAFETY: `context` is not null and aligned; the C caller passes a place for one handle.
        unsafe { context.write(handle::create(made)) };
        Ok(())
    })
}

/// Which engine a context has: DRR_BACKEND_AUTO never. Writes `*backend` on success only. Fails with
/// DRR_STATUS_INVALID_ARGUMENT. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_context_backend(
    context: *const DrrContext,
    backend: *mut DrrBackend,
) -> DrrStatus {
    guard(|| {
        memory::check("backend", backend, 1)?;
        // SAFETY: the C caller passes a handle that stays alive during the call.
        let context = unsafe { handle::borrow("context", context)? };
        let code = ENGINES.iter().find(|(_, engine)| *engine == context.backend());
        let code = code.map_or(DRR_BACKEND_AUTO, |&(code, _)| code);
        // SAFETY: `backend` is not null and aligned; the C caller passes a place for one value.
        unsafe { backend.write(code) };
        Ok(())
    })
}

/// The name of the context's GPU, such as "NVIDIA H100 80GB HBM3"; empty for engines of the CPU. NULL, with a message,
/// when the handle is refused.
///
/// The string belongs to the context and lives as long. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_context_device_name(context: *const DrrContext) -> *const c_char {
    let mut name = std::ptr::null();
    guard(|| {
        // SAFETY: the C caller passes a handle that stays alive as long as it uses the string.
        name = unsafe { handle::borrow("context", context)? }.device_name().as_ptr();
        Ok(())
    });
    name
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
