//! The GPU kernels' text as an engine of parallel beams, in float32.

mod wire;

use std::sync::{Mutex, PoisonError};

use crate::allocation::{collected, filled};
use crate::engine::gpu::parallel::{HeldField, Job, Launch, PLANES, PRODUCTS, Wanted};
use crate::engine::{Device, Timings};
use crate::error::{Error, Result};
use crate::normal_equations::NormalEquations;
use crate::parallel::cpu::field::{Field, padded};
use crate::parallel::engine::{Engine, ViewRays};
use crate::parallel::{Jacobian, ParallelGeometry, Quadrature, RaySelection};

/// Most views of one launch: enough rays to fill a GPU.
const VIEWS_AT_ONCE: usize = 16;

/// A field on a device.
pub(super) struct OnDevice {
    geometry: ParallelGeometry,
    field: Box<dyn HeldField>,
    launch: Launch,
    kernel_seconds: Mutex<f64>,
}

impl OnDevice {
    /// # Errors
    /// `Unsupported` for the exact quadrature, and for what is too large.
    pub(super) fn check(geometry: &ParallelGeometry, quadrature: Quadrature) -> Result<()> {
        if quadrature == Quadrature::Exact {
            let text = "GPU engines take sums over steps of parallel beams: the exact quadrature needs the engine cpu";
            return Err(Error::Unsupported(text.into()));
        }
        let voxels = padded(geometry.dimensions).iter().product();
        for (what, count) in [("voxels", voxels), ("derivatives of pixels", geometry.pixels() * PLANES)] {
            if u32::try_from(count).is_err() {
                let text = format!("{count} {what} are too many for GPU engines, which count to 2^32");
                return Err(Error::Unsupported(text));
            }
        }
        Ok(())
    }

    /// Of a geometry that is checked.
    ///
    /// # Errors
    /// `OutOfMemory`; `Device`.
    pub(super) fn new(device: &Device, geometry: ParallelGeometry, field: Field<f32>) -> Result<Self> {
        let (sides, values) = field.into_parts();
        let launch = wire::launch(&geometry, sides);
        Ok(Self { geometry, field: device.field(values)?, launch, kernel_seconds: Mutex::new(0.0) })
    }

    fn job<'a>(&self, views: &[ViewRays<'_>], wanted: Wanted) -> Result<Job<'a>> {
        let RaySelection { mask, lengths } = views[0].rays;
        let mask = mask.map(|mask| collected(mask.iter().map(|&counts| u8::from(counts)), "the mask"));
        Ok(Job {
            launch: Launch { views: views.len() as u32, ..self.launch },
            views: views.iter().map(wire::view).collect::<Result<_>>()?,
            mask: mask.transpose()?,
            intervals: lengths.map(|lengths| wire::intervals(&self.geometry, lengths)).transpose()?,
            measured: None,
            wanted,
        })
    }

    fn run(&self, job: &Job<'_>, results: &mut [f32]) -> Result<()> {
        let seconds = self.field.run(job, results)?;
        self.note(seconds);
        Ok(())
    }

    fn note(&self, seconds: f64) {
        *self.kernel_seconds.lock().unwrap_or_else(PoisonError::into_inner) = seconds;
    }
}

impl Engine<f32> for OnDevice {
    fn project(&self, views: &[ViewRays<'_>], images: &mut [f32]) -> Result<()> {
        let pixels = self.geometry.pixels();
        let at_once = VIEWS_AT_ONCE.min(u32::MAX as usize / pixels);
        let mut seconds = 0.0;
        for (views, images) in views.chunks(at_once).zip(images.chunks_mut(at_once * pixels)) {
            seconds += self.field.run(&self.job(views, Wanted::Images)?, images)?;
        }
        self.note(seconds);
        Ok(())
    }

    fn normal_equations(&self, view: ViewRays<'_>, measured: &[f32]) -> Result<NormalEquations<5>> {
        let job = Job { measured: Some(measured), ..self.job(&[view], Wanted::Sums)? };
        let mut sums = filled(job.results(), 0.0, "the sums")?;
        self.run(&job, &mut sums)?;
        let rays =
            view.rays.mask.map_or(measured.len(), |mask| mask.iter().filter(|counts| **counts).count());
        Ok(equations(&sums, rays))
    }

    fn jacobian(&self, view: ViewRays<'_>, jacobian: &mut Jacobian<f32>) -> Result<()> {
        let job = self.job(&[view], Wanted::Planes)?;
        let mut planes = filled(job.results(), 0.0, "the Jacobian")?;
        self.run(&job, &mut planes)?;
        let (image, derivatives) = planes.split_at(self.geometry.pixels());
        jacobian.image.copy_from_slice(image);
        for (to, from) in jacobian.derivatives.iter_mut().zip(derivatives.chunks(image.len())) {
            to.copy_from_slice(from);
        }
        Ok(())
    }

    fn timings(&self) -> Option<Timings> {
        let kernel_seconds = *self.kernel_seconds.lock().unwrap_or_else(PoisonError::into_inner);
        self.field.timings().map(|timings| Timings { kernel_seconds, ..timings })
    }
}

/// Products of residuals and derivatives, added part after part in float64.
fn equations(sums: &[f32], rays: usize) -> NormalEquations<5> {
    let mut total = [0.0; PRODUCTS];
    for part in sums.chunks(PRODUCTS) {
        for (total, &sum) in total.iter_mut().zip(part) {
            *total += f64::from(sum);
        }
    }
    let mut equations = NormalEquations { loss: 0.5 * total[0], rays, ..NormalEquations::default() };
    equations.gradient.copy_from_slice(&total[1..PLANES]);
    let mut next = total[PLANES..].iter();
    for k in 0..5 {
        for (l, &sum) in (k..5).zip(&mut next) {
            equations.hessian[k][l] = sum;
            equations.hessian[l][k] = sum;
        }
    }
    equations
}
