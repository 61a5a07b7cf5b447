//! One kernel: the text with its definitions, compiled to a shared library and loaded.

use std::ffi::c_void;
use std::io::Write as _;
use std::ops::Range;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Arc, LazyLock};

use libloading::Library;

use crate::engine::Images;
use crate::engine::gpu::wire::{Beam, Channels, Launch};
use crate::engine::gpu::{Definitions, Kernel, Programs, Views};
use crate::error::{Error, Result};

/// `DrrVoxels`: codes, occupancy and, if there is one, the table; or densities, labels and occupancy.
#[repr(C)]
pub(super) struct HostVoxels(pub(super) [*const c_void; 3]);

/// `DrrSpectra`.
#[repr(C)]
pub(super) struct HostSpectra {
    pub(super) weight: *const f32,
    pub(super) attenuation: *const f32,
}

/// `DrrImages`.
#[repr(C)]
pub(super) struct HostImages {
    intensity: *mut f32,
    line_integral: *mut f32,
    areal_density: *mut f32,
    bone_path: *mut f32,
}

// SAFETY: places in images that outlive the calls, each of which writes rows of its own.
unsafe impl Sync for HostImages {}

impl HostImages {
    /// From a view on.
    pub(super) fn from_view(images: &mut Images<f32>, view: usize) -> Self {
        let (pixels, materials) = (images.size[0] * images.size[1], images.materials);
        let from = |image: &mut Vec<f32>, planes: usize| {
            image.get_mut(view * planes * pixels..).unwrap_or_default().as_mut_ptr()
        };
        Self {
            intensity: from(&mut images.intensity, 1),
            line_integral: from(&mut images.line_integral, 1),
            areal_density: from(&mut images.areal_density, materials),
            bone_path: from(&mut images.bone_path, 1),
        }
    }
}

/// `DrrSignals`.
#[repr(C)]
pub(super) struct HostSignals {
    pub(super) before: *const f32,
    pub(super) passing: *mut f32,
    pub(super) open: *mut f32,
}

// SAFETY: as for the images.
unsafe impl Sync for HostSignals {}

/// The kernel's entry point, `shaders/host.cpp`.
type Project = unsafe extern "C" fn(
    *const Launch,
    *const Beam,
    *const HostVoxels,
    *const HostSpectra,
    *const HostImages,
    u32,
    u32,
    u32,
    u32,
);

/// The same with sums by several rows of weights.
type ProjectSignals = unsafe extern "C" fn(
    *const Launch,
    *const Beam,
    *const HostVoxels,
    *const HostSpectra,
    *const HostImages,
    u32,
    u32,
    u32,
    u32,
    *const Channels,
    *const HostSignals,
);

/// Which of them the definitions made.
enum EntryPoint {
    Plain(Project),
    Signals(ProjectSignals),
}

/// A loaded kernel.
pub(super) struct Program {
    project: EntryPoint,
    _library: Library,
}

/// Compiling takes a second, and projectors of a process share their kernels.
static PROGRAMS: LazyLock<Programs<Definitions, Program>> = LazyLock::new(Programs::default);

impl Program {
    /// The kernel of these definitions, compiled if it is new.
    ///
    /// # Errors
    /// `Unsupported`, with the compiler's words, when there is no C++17 compiler or it fails.
    pub(super) fn of(definitions: &Definitions) -> Result<Arc<Self>> {
        PROGRAMS.get(definitions, || Self::compiled(definitions))
    }

    fn compiled(definitions: &Definitions) -> Result<Self> {
        let library = library(Kernel::Projection, definitions)?;
        let name = c"projectPolyenergeticDRR";
        // SAFETY: `shaders/host.cpp` defines it with this signature, which depends on this definition.
        let project = unsafe {
            if definitions.iter().any(|(name, _)| name == "DRR_SIGNALS") {
                library.get::<ProjectSignals>(name).map(|function| EntryPoint::Signals(*function))
            } else {
                library.get::<Project>(name).map(|function| EntryPoint::Plain(*function))
            }
        };
        let project = project.map_err(|error| failed(&error))?;
        Ok(Self { project, _library: library })
    }

    /// Projects some pixels of one row of one view.
    ///
    /// # Safety
    /// Voxels, tables, images and signals, which are there if the views have channels, are as long as the views' launch
    /// says; nobody else reads or writes these pixels.
    pub(super) unsafe fn project(
        &self,
        views: &Views,
        voxels: &HostVoxels,
        spectra: &HostSpectra,
        (images, signals): (&HostImages, Option<&HostSignals>),
        [view, row]: [usize; 2],
        columns: Range<usize>,
    ) {
        let [view, row, first, end] = [view, row, columns.start, columns.end].map(|n| n as u32);
        let (launch, beams) = (&raw const views.launch, views.beams.as_ptr());
        match (&self.project, &views.channels, signals) {
            // SAFETY: by the caller's promise; the kernel was compiled for these views' definitions.
            (EntryPoint::Signals(project), Some(channels), Some(signals)) => unsafe {
                project(launch, beams, voxels, spectra, images, view, row, first, end, channels, signals);
            },
            // SAFETY: as above.
            (EntryPoint::Plain(project), None, None) => unsafe {
                project(launch, beams, voxels, spectra, images, view, row, first, end);
            },
            _ => unreachable!("the definitions say whether there are signals"),
        }
    }
}

pub(super) fn failed(error: &dyn std::fmt::Display) -> Error {
    Error::Unsupported(format!("the host's kernel: {error}"))
}

/// The text with its definitions, compiled and loaded.
///
/// # Errors
/// As [`Program::of`].
pub(super) fn library(kernel: Kernel, definitions: &Definitions) -> Result<Library> {
    let folder = tempfile::tempdir().map_err(|error| failed(&error))?;
    let path = folder.path().join("kernel");
    compile(kernel.host(), definitions, &path)?;
    // SAFETY: the library was compiled from our text a moment ago, and has no initialisers.
    unsafe { Library::new(&path) }.map_err(|error| failed(&error))
}

/// Compiles a text to a shared library at `path`.
fn compile(text: &str, definitions: &Definitions, path: &Path) -> Result<()> {
    let compiler = std::env::var_os("CXX").unwrap_or_else(|| "c++".into());
    let mut command = Command::new(&compiler);
    command.args(["-x", "c++", "-std=c++17", "-O1", "-ffp-contract=off", "-shared", "-fPIC"]);
    // With the machine's own instruction for fused multiply-add, where a compiler knows it by this name.
    #[cfg(target_arch = "x86_64")]
    command.arg("-march=native");
    command.args(definitions.iter().map(|(name, value)| format!("-D{name}={value}")));
    command.arg("-o").arg(path).arg("-");
    let failed = |error: &dyn std::fmt::Display| {
        let text = format!("the host's kernel needs a C++17 compiler; {}: {error}", compiler.display());
        Error::Unsupported(text)
    };
    let child = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
    let mut child = child.map_err(|error| failed(&error))?;
    if let Some(mut input) = child.stdin.take() {
        // A compiler that stops reading says why.
        let _ = input.write_all(text.as_bytes());
    }
    let output = child.wait_with_output().map_err(|error| failed(&error))?;
    if output.status.success() { Ok(()) } else { Err(failed(&String::from_utf8_lossy(&output.stderr))) }
}
