//! NVIDIA's driver: whether it is there, what its errors mean, and what it lends.

use std::ffi::CStr;
use std::marker::PhantomData;

use cudarc::driver::{result, sys};
use cudarc::nvrtc;

use crate::error::{Error, Result};

/// Oldest driver and run-time compiler that have every function that is called: cudarc panics for one that is missing.
const OLDEST: i32 = 12;

/// Loads driver and run-time compiler.
///
/// # Errors
/// `Unsupported`, with what is missing.
pub(super) fn start() -> Result<()> {
    let needed = |there: bool, text: &dyn Fn() -> String| {
        if there { Ok(()) } else { Err(Error::Unsupported(text())) }
    };
    // SAFETY: NVIDIA's libraries have initialisers without preconditions. cudarc panics for a library that is missing,
    // so that each is asked for before its first function is called.
    let (driver, compiler) = unsafe { (sys::is_culib_present(), nvrtc::sys::is_culib_present()) };
    needed(driver, &|| "no NVIDIA driver: libcuda.so.1 cannot be loaded".into())?;
    needed(compiler, &|| {
        let text = "no NVIDIA run-time compiler: libnvrtc.so.13 or .12 cannot be loaded; it is part of CUDA, and its \
                    folder must be on the loader's path";
        text.into()
    })?;
    let version = driver_version().map_err(|error| Error::Unsupported(error.to_string()))?;
    let [major, minor] = version;
    needed(major >= OLDEST, &|| {
        format!("NVIDIA's driver is for CUDA {major}.{minor}; {OLDEST}.0 or later is needed")
    })?;
    let (mut major, mut minor) = (0, 0);
    // SAFETY: two places for numbers. Every NVRTC has this function.
    let asked = unsafe { nvrtc::sys::nvrtcVersion(&raw mut major, &raw mut minor) };
    needed(asked.result().is_ok() && major >= OLDEST, &|| {
        format!("NVIDIA's run-time compiler is of CUDA {major}.{minor}; {OLDEST}.0 or later is needed")
    })?;
    result::init().map_err(|error| match error.0 {
        sys::CUresult::CUDA_ERROR_NO_DEVICE => Error::Unsupported("no NVIDIA GPU".into()),
        _ => Error::Unsupported(format!("NVIDIA's driver does not start: {}", words(error))),
    })
}

/// Version of CUDA that the driver is for.
pub(super) fn driver_version() -> Result<[i32; 2]> {
    let mut version = 0;
    // SAFETY: a place for one number. Every driver has this function.
    checked("NVIDIA's driver", unsafe { sys::cuDriverGetVersion(&raw mut version) }.result())?;
    Ok([version / 1000, version % 1000 / 10])
}

/// The driver's name of an error, and its words.
fn words(error: result::DriverError) -> String {
    let text = |text: std::result::Result<&CStr, _>| {
        text.map_or_else(|_| "an unknown error".into(), |text| text.to_string_lossy().into_owned())
    };
    format!("{}, {}", text(error.error_name()), text(error.error_string()))
}

/// A call of the driver's; `what` was wanted is for the message.
pub(super) fn checked<T>(what: &str, called: std::result::Result<T, result::DriverError>) -> Result<T> {
    called.map_err(|error| Error::Device(format!("{what}: {}", words(error))))
}

/// As [`checked`], for `bytes` of memory.
pub(super) fn allocated<T>(
    what: &str,
    bytes: usize,
    called: std::result::Result<T, result::DriverError>,
) -> Result<T> {
    match called {
        Err(error) if error.0 == sys::CUresult::CUDA_ERROR_OUT_OF_MEMORY => {
            Err(Error::OutOfMemory { what: format!("{what} on the GPU"), bytes })
        }
        called => checked(what, called),
    }
}

/// A context that is current on this thread; the one before it is again when this is dropped.
pub(super) struct Current(PhantomData<*mut ()>);

impl Current {
    /// # Safety
    /// The context is alive, and stays so as long as the value.
    pub(super) unsafe fn new(context: sys::CUcontext) -> Result<Self> {
        // SAFETY: alive by the caller's promise.
        checked("the GPU's context", unsafe { sys::cuCtxPushCurrent_v2(context) }.result())?;
        Ok(Self(PhantomData))
    }
}

impl Drop for Current {
    fn drop(&mut self) {
        let mut context = std::ptr::null_mut();
        // SAFETY: it was pushed on this thread, which the value cannot leave. What was pushed after it is popped.
        let _ = unsafe { sys::cuCtxPopCurrent_v2(&raw mut context) };
    }
}

/// A queue of its own, which waits for no other.
pub(super) struct Stream<'a> {
    pub(super) raw: sys::CUstream,
    current: PhantomData<&'a Current>,
}

impl<'a> Stream<'a> {
    pub(super) fn new(_: &'a Current) -> Result<Self> {
        let raw = checked("a stream", result::stream::create(result::stream::StreamKind::NonBlocking))?;
        Ok(Self { raw, current: PhantomData })
    }

    /// Waits until all that was put into it is done. What went wrong on the device since then shows here.
    pub(super) fn finish(&self, what: &str) -> Result<()> {
        // SAFETY: alive.
        checked(what, unsafe { result::stream::synchronize(self.raw) })
    }
}

impl Drop for Stream<'_> {
    fn drop(&mut self) {
        // SAFETY: alive until here. The driver waits with its end for what is in it.
        let _ = unsafe { result::stream::destroy(self.raw) };
    }
}

/// Refuses a stream that is being captured: what the graph would read again later is gone by then.
///
/// # Safety
/// The stream is alive.
pub(super) unsafe fn not_captured(stream: sys::CUstream) -> Result<()> {
    // SAFETY: alive.
    match checked("the queue", unsafe { result::stream::is_capturing(stream) })? {
        sys::CUstreamCaptureStatus::CU_STREAM_CAPTURE_STATUS_NONE => Ok(()),
        _ => Err(Error::invalid("queue", "being captured", "a stream that is not being captured")),
    }
}

/// A moment on a stream.
pub(super) struct Event<'a> {
    raw: sys::CUevent,
    current: PhantomData<&'a Current>,
}

impl<'a> Event<'a> {
    pub(super) fn new(_: &'a Current) -> Result<Self> {
        let raw = checked("an event", result::event::create(sys::CUevent_flags::CU_EVENT_DEFAULT))?;
        Ok(Self { raw, current: PhantomData })
    }

    pub(super) fn record(&self, stream: &Stream<'a>) -> Result<()> {
        // SAFETY: both alive, of one context.
        checked("an event", unsafe { result::event::record(self.raw, stream.raw) })
    }

    /// Seconds from `earlier` to this; both are past.
    pub(super) fn seconds_since(&self, earlier: &Self) -> Result<f64> {
        /// Older drivers do not have the version of it that cudarc calls.
        type Elapsed = unsafe extern "C" fn(*mut f32, sys::CUevent, sys::CUevent) -> sys::CUresult;
        let mut milliseconds = 0.0;
        // SAFETY: the driver's function by its name and type; a place for one number; both events alive.
        let called = unsafe {
            let found = sys::culib().get::<Elapsed>(b"cuEventElapsedTime");
            let elapsed = found.map_err(|error| Error::Device(error.to_string()))?;
            elapsed(&raw mut milliseconds, earlier.raw, self.raw)
        };
        checked("the time between two events", called.result())?;
        Ok(f64::from(milliseconds) / 1000.0)
    }
}

impl Drop for Event<'_> {
    fn drop(&mut self) {
        // SAFETY: alive until here.
        let _ = unsafe { result::event::destroy(self.raw) };
    }
}
