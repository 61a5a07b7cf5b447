//! NVIDIA's run-time compiler, loaded when it is there. Needs neither a GPU nor CUDA's headers.
#![allow(unsafe_code, reason = "a C library, loaded by name")]

use std::ffi::{CString, c_char, c_int, c_void};

use libloading::Library;
use libtest_mimic::Failed;

type Program = *mut c_void;

/// NVRTC.
pub(super) struct Nvrtc(Library);

impl Nvrtc {
    /// The library, by the loader's usual names. It loads a second one itself, so its folder must be on the loader's
    /// path.
    pub(super) fn load() -> Result<Self, String> {
        for name in ["libnvrtc.so", "libnvrtc.so.13", "libnvrtc.so.12"] {
            // SAFETY: loading NVRTC runs its initialisers, which have no preconditions.
            if let Ok(library) = unsafe { Library::new(name) } {
                return Ok(Self(library));
            }
        }
        Err("no NVRTC on the loader's path".to_owned())
    }

    /// Compiles CUDA C++ that includes one header, to PTX.
    pub(super) fn ptx(&self, source: &str, header_name: &str, header: &str) -> Result<String, Failed> {
        let [source, header_name, header] = [source, header_name, header].map(CString::new);
        let (source, header_name, header) = (source?, header_name?, header?);
        let options = [c"--gpu-architecture=compute_75", c"--std=c++17"];
        let mut program: Program = std::ptr::null_mut();
        // SAFETY: signatures as in nvrtc.h; the strings outlive the calls; `program` is made by the first call, and
        // destroyed after its last use. An early return leaks it, and fails the test.
        unsafe {
            let create = self.0.get::<CreateProgram>(c"nvrtcCreateProgram")?;
            let (headers, names) = ([header.as_ptr()], [header_name.as_ptr()]);
            let made = create(
                &raw mut program,
                source.as_ptr(),
                std::ptr::null(),
                1,
                headers.as_ptr(),
                names.as_ptr(),
            );
            succeeded("nvrtcCreateProgram", made)?;
            let compile = self.0.get::<CompileProgram>(c"nvrtcCompileProgram")?;
            let compiled =
                compile(program, options.len() as c_int, options.map(std::ffi::CStr::as_ptr).as_ptr());
            let (what, size, text) = if compiled == 0 {
                ("PTX", c"nvrtcGetPTXSize", c"nvrtcGetPTX")
            } else {
                ("log", c"nvrtcGetProgramLogSize", c"nvrtcGetProgramLog")
            };
            let mut length = 0;
            succeeded(what, self.0.get::<GetSize>(size)?(program, &raw mut length))?;
            let mut bytes = vec![0_u8; length];
            succeeded(what, self.0.get::<GetText>(text)?(program, bytes.as_mut_ptr().cast()))?;
            self.0.get::<DestroyProgram>(c"nvrtcDestroyProgram")?(&raw mut program);
            let text = String::from_utf8_lossy(&bytes).into_owned();
            if compiled == 0 { Ok(text) } else { Err(text.into()) }
        }
    }
}

type CreateProgram = unsafe extern "C" fn(
    *mut Program,
    *const c_char,
    *const c_char,
    c_int,
    *const *const c_char,
    *const *const c_char,
) -> c_int;
type CompileProgram = unsafe extern "C" fn(Program, c_int, *const *const c_char) -> c_int;
type GetSize = unsafe extern "C" fn(Program, *mut usize) -> c_int;
type GetText = unsafe extern "C" fn(Program, *mut c_char) -> c_int;
type DestroyProgram = unsafe extern "C" fn(*mut Program) -> c_int;

fn succeeded(what: &str, code: c_int) -> Result<(), Failed> {
    if code == 0 { Ok(()) } else { Err(format!("{what}: NVRTC error {code}").into()) }
}
