//! One kernel: the text with its definitions, compiled by NVIDIA's run-time compiler and loaded.

use std::ffi::{CString, c_char};
use std::time::Instant;

use cudarc::driver::{result, sys};
use cudarc::nvrtc;

use crate::engine::cuda::driver::checked;
use crate::engine::gpu::{Definitions, Kernel};
use crate::error::{Error, Result};

/// What the compiler makes, for a compute capability: 90 is 9.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    /// Instructions of such a device.
    Cubin(u32),
    /// What the driver of such a device or a later one compiles further.
    Ptx(u32),
}

impl Target {
    /// The best that the run-time compiler has for a device.
    ///
    /// # Errors
    /// `Unsupported` when the device is older than all that the compiler knows.
    pub(super) fn of(capability: u32) -> Result<Self> {
        let known = known().map_err(|error| unsupported(&error))?;
        Self::among(&known, capability).ok_or_else(|| {
            let least = known.first().copied().unwrap_or_default();
            unsupported(&format!(
                "knows GPUs from compute capability {}.{} on; this one's is {}.{}",
                least / 10,
                least % 10,
                capability / 10,
                capability % 10
            ))
        })
    }

    /// Of the capabilities that a compiler knows, ascending.
    fn among(known: &[u32], capability: u32) -> Option<Self> {
        if known.contains(&capability) {
            return Some(Self::Cubin(capability));
        }
        known.iter().rfind(|&&known| known < capability).map(|&known| Self::Ptx(known))
    }

    fn option(self) -> String {
        match self {
            Self::Cubin(capability) => format!("--gpu-architecture=sm_{capability}"),
            Self::Ptx(capability) => format!("--gpu-architecture=compute_{capability}"),
        }
    }
}

fn unsupported(error: &dyn std::fmt::Display) -> Error {
    Error::Unsupported(format!("NVIDIA's run-time compiler: {error}"))
}

/// The compute capabilities that the run-time compiler knows, ascending.
fn known() -> std::result::Result<Vec<u32>, nvrtc::result::NvrtcError> {
    let mut count = 0;
    // SAFETY: a place for one number.
    unsafe { nvrtc::sys::nvrtcGetNumSupportedArchs(&raw mut count) }.result()?;
    let mut known = vec![0; count.max(0) as usize];
    // SAFETY: places for as many numbers as the compiler said.
    unsafe { nvrtc::sys::nvrtcGetSupportedArchs(known.as_mut_ptr()) }.result()?;
    Ok(known.into_iter().map(|capability| capability as u32).collect())
}

/// A text that the run-time compiler has been given.
struct Source {
    raw: nvrtc::sys::nvrtcProgram,
    /// The compiler may go on reading it.
    _text: CString,
}

impl Source {
    fn new(kernel: Kernel) -> Result<Self> {
        let text = CString::new(kernel.cuda()).map_err(|error| unsupported(&error))?;
        let raw =
            nvrtc::result::create_program(&text, Some(c"drr.cu")).map_err(|error| unsupported(&error))?;
        Ok(Self { raw, _text: text })
    }

    /// What the compiler says of its last run.
    fn log(&self) -> String {
        // SAFETY: the program is alive.
        let log = unsafe { nvrtc::result::get_program_log(self.raw) }.unwrap_or_default();
        let bytes: Vec<u8> = log.iter().map(|&c| c as u8).take_while(|&byte| byte != 0).collect();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// What the compiler has made.
    fn image(&self, target: Target) -> std::result::Result<Vec<c_char>, nvrtc::result::NvrtcError> {
        if let Target::Ptx(_) = target {
            // SAFETY: the program is alive and compiled. The text ends in NUL.
            return unsafe { nvrtc::result::get_ptx(self.raw) };
        }
        let mut size = 0;
        // SAFETY: as above; a place for one number, then for as many bytes as it says.
        unsafe {
            nvrtc::sys::nvrtcGetCUBINSize(self.raw, &raw mut size).result()?;
            let mut image = vec![0; size];
            nvrtc::sys::nvrtcGetCUBIN(self.raw, image.as_mut_ptr()).result()?;
            Ok(image)
        }
    }
}

impl Drop for Source {
    fn drop(&mut self) {
        // SAFETY: alive until here.
        let _ = unsafe { nvrtc::result::destroy_program(self.raw) };
    }
}

/// The kernel's text compiled for blocks of `threads`.
///
/// # Errors
/// `Unsupported`, with the compiler's words.
pub(super) fn compiled(
    kernel: Kernel,
    definitions: &Definitions,
    threads: u32,
    target: Target,
) -> Result<Vec<c_char>> {
    let source = Source::new(kernel)?;
    // As `shaders/dialect.h` promises: nothing is contracted, flushed or approximated.
    let arithmetic = ["--std=c++17", "--fmad=false", "--ftz=false", "--prec-div=true", "--prec-sqrt=true"];
    let mut options = arithmetic.map(str::to_owned).to_vec();
    options.push(target.option());
    options.push(format!("-DDRR_GROUP={threads}"));
    options.extend(definitions.iter().map(|(name, value)| format!("-D{name}={value}")));
    // SAFETY: the program is alive.
    unsafe { nvrtc::result::compile_program(source.raw, &options) }
        .map_err(|error| unsupported(&format!("{error}\n{}", source.log())))?;
    source.image(target).map_err(|error| unsupported(&error))
}

/// A loaded kernel.
pub(super) struct Program {
    module: sys::CUmodule,
    pub(super) function: sys::CUfunction,
    pub(super) compile_seconds: f64,
    /// Of a thread.
    pub(super) registers: u32,
    /// Memory of a thread beside its registers.
    pub(super) local_bytes: u32,
}

// SAFETY: module and function may be used from any thread, and are not changed.
unsafe impl Send for Program {}
// SAFETY: as above.
unsafe impl Sync for Program {}

impl Program {
    /// Compiles a kernel and loads it into the context that is current.
    pub(super) fn new(
        kernel: Kernel,
        definitions: &Definitions,
        threads: u32,
        target: Target,
    ) -> Result<Self> {
        use sys::CUfunction_attribute as Attribute;
        let start = Instant::now();
        let image = compiled(kernel, definitions, threads, target)?;
        // SAFETY: a cubin, or a text that ends in NUL; both only read during the call.
        let module =
            checked("loading the kernel", unsafe { result::module::load_data(image.as_ptr().cast()) })?;
        let mut program = Self {
            module,
            function: std::ptr::null_mut(),
            compile_seconds: 0.0,
            registers: 0,
            local_bytes: 0,
        };
        let name = CString::new(kernel.entry_point()).map_err(|error| unsupported(&error))?;
        // SAFETY: the module is loaded.
        program.function = checked("the kernel", unsafe { result::module::get_function(module, name) })?;
        let attribute = |which| {
            // SAFETY: the function is of a loaded module.
            let value = unsafe { result::function::get_function_attribute(program.function, which) };
            checked("the kernel's registers", value).map(|value| value as u32)
        };
        let registers = attribute(Attribute::CU_FUNC_ATTRIBUTE_NUM_REGS)?;
        let local_bytes = attribute(Attribute::CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES)?;
        (program.registers, program.local_bytes) = (registers, local_bytes);
        program.compile_seconds = start.elapsed().as_secs_f64();
        Ok(program)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // SAFETY: loaded, and nothing that uses it is still to run: its context's end comes after.
        let _ = unsafe { result::module::unload(self.module) };
    }
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;
    use crate::engine::gpu::parallel::Job;

    /// Whether the run-time compiler is there. Where every tool is required, it has to be.
    fn compiler() -> bool {
        // SAFETY: NVRTC's initialisers have no preconditions.
        let there = unsafe { nvrtc::sys::is_culib_present() };
        let required = std::env::var_os("DRR_REQUIRE_ALL_TOOLS").is_some_and(|value| value == "1");
        assert!(there || !required, "no NVRTC on the loader's path");
        if !there {
            eprintln!("not tested: no NVRTC on the loader's path");
        }
        there
    }

    /// How many of the definitions go on to instructions, which takes longer.
    const THOROUGH: usize = 7;

    #[test]
    fn every_specialisation_compiles_and_needs_no_float64() {
        if !compiler() {
            return;
        }
        let parallel = [Kernel::Parallel, Kernel::ParallelSums]
            .map(|kernel| Job::covering().into_iter().map(move |definitions| (kernel, definitions)));
        let cone = Definitions::covering().into_iter().map(|definitions| (Kernel::Projection, definitions));
        let all: Vec<_> = cone.chain(parallel.into_iter().flatten()).collect();
        all.par_iter().enumerate().for_each(|(n, (kernel, definitions))| {
            let target = if n % THOROUGH == 0 { Target::Cubin(90) } else { Target::Ptx(75) };
            let image = compiled(*kernel, definitions, 256, target)
                .unwrap_or_else(|e| panic!("{definitions:?}: {e}"));
            let bytes: Vec<u8> = image.iter().map(|&c| c as u8).collect();
            if let Target::Cubin(_) = target {
                assert_eq!(bytes[..4], *b"\x7fELF", "{definitions:?}");
                return;
            }
            let text = String::from_utf8_lossy(&bytes);
            assert!(text.contains(&format!(".entry {}(", kernel.entry_point())), "{definitions:?}");
            // By name, a product and a sum in one rounding are written so; float64 is slow on most devices.
            assert!(!text.contains(".f64"), "{definitions:?}");
            assert!(!text.contains("mad.f32") && !text.contains(".ftz"), "{definitions:?}");
        });
    }

    #[test]
    fn what_the_compiler_refuses_is_told_in_its_words() {
        if !compiler() {
            return;
        }
        let error = compiled(Kernel::Projection, &Definitions::covering()[0], 0, Target::Ptx(12))
            .expect_err("no such device");
        assert!(error.to_string().contains("gpu-architecture"), "{error}");
    }

    #[test]
    fn a_device_gets_its_own_instructions_or_those_of_the_last_before_it() {
        let known = [75, 80, 90];
        assert_eq!(Target::among(&known, 90), Some(Target::Cubin(90)));
        assert_eq!(Target::among(&known, 103), Some(Target::Ptx(90)));
        assert_eq!(Target::among(&known, 70), None);
    }
}
