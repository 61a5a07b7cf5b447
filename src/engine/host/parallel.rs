//! The kernel text of parallel beams as host code.

use std::sync::{Arc, LazyLock};

use libloading::Library;
use rayon::prelude::*;

use crate::allocation::filled;
use crate::engine::Timings;
use crate::engine::gpu::parallel::{HeldField, Interval, Job, Launch, View, Wanted};
use crate::engine::gpu::{Definitions, Kernel, Programs};
use crate::engine::host::program::{failed, library};
use crate::error::Result;

/// `DrrParallelRays`.
#[repr(C)]
struct Rays {
    field: *const f32,
    mask: *const u8,
    interval: *const Interval,
    measured: *const f32,
}

// SAFETY: places that nobody writes while they are read.
unsafe impl Sync for Rays {}

/// Where planes go.
struct Planes(*mut f32);

// SAFETY: each thread writes pixels of its own.
unsafe impl Sync for Planes {}

/// The entry points of `shaders/parallel.cpp`.
type Project = unsafe extern "C" fn(*const Launch, *const View, *const Rays, *mut f32, u32, u32, u32, u32);
type Sum = unsafe extern "C" fn(*const Launch, *const f32, *mut f32);

/// A loaded kernel.
struct Program {
    project: Project,
    sum: Sum,
    _library: Library,
}

static PROGRAMS: LazyLock<Programs<Definitions, Program>> = LazyLock::new(Programs::default);

impl Program {
    fn compiled(definitions: &Definitions) -> Result<Self> {
        let library = library(Kernel::Parallel, definitions)?;
        // SAFETY: `shaders/parallel.cpp` defines them with these signatures.
        let (project, sum) = unsafe {
            let project = library.get::<Project>(c"projectParallel").map_err(|error| failed(&error))?;
            let sum = library.get::<Sum>(c"sumParallel").map_err(|error| failed(&error))?;
            (*project, *sum)
        };
        Ok(Self { project, sum, _library: library })
    }
}

/// A field in the host's memory.
pub(crate) struct Parallel {
    field: Vec<f32>,
}

impl Parallel {
    /// Of values with a border, z fastest.
    pub(crate) fn new(field: Vec<f32>) -> Self {
        Self { field }
    }

    fn cast(&self, program: &Program, job: &Job<'_>, planes: &mut [f32]) {
        let pointer = |values: Option<&[f32]>| values.map_or(std::ptr::null(), <[f32]>::as_ptr);
        let rays = Rays {
            field: self.field.as_ptr(),
            mask: job.mask.as_ref().map_or(std::ptr::null(), Vec::as_ptr),
            interval: job.intervals.as_ref().map_or(std::ptr::null(), Vec::as_ptr),
            measured: pointer(job.measured),
        };
        let (rays, planes) = (&rays, &Planes(planes.as_mut_ptr()));
        let Launch { width, height, views, .. } = job.launch;
        (0..views * width).into_par_iter().for_each(|n| {
            let (launch, first, place) = (&raw const job.launch, job.views.as_ptr(), planes.0);
            // SAFETY: the arrays are as long as the launch says and outlive the call; a column of a view is written by one
            // call only.
            unsafe { (program.project)(launch, first, rays, place, n / width, n % width, 0, height) };
        });
    }
}

impl HeldField for Parallel {
    fn run(&self, job: &Job<'_>, results: &mut [f32]) -> Result<f64> {
        let program: Arc<Program> =
            PROGRAMS.get(&job.definitions(), || Program::compiled(&job.definitions()))?;
        if job.wanted == Wanted::Sums {
            let mut planes = filled(job.rays(), 0.0, "the planes")?;
            self.cast(&program, job, &mut planes);
            // SAFETY: planes and results are as long as the launch says.
            unsafe { (program.sum)(&raw const job.launch, planes.as_ptr(), results.as_mut_ptr()) };
        } else {
            self.cast(&program, job, results);
        }
        Ok(0.0)
    }

    fn timings(&self) -> Option<Timings> {
        None
    }
}
