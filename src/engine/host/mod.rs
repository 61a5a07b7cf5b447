//! The kernel text as host code: the very lines that a GPU runs, compiled by this machine's C++ compiler.
#![allow(unsafe_code, reason = "calls what a C++ compiler made")]

mod parallel;
mod program;

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::allocation::filled;
use crate::engine::gpu::{DeviceVoxels, Layout, Prepared, Slab, Views};
use crate::engine::{Engine, Images, Job, Passed, Progress, SignalsJob};
use crate::error::Result;
use crate::plan::Plan;
use crate::scene::Scene;
use crate::volume::Volume;
pub(crate) use parallel::Parallel;
use program::{HostImages, HostSignals, HostSpectra, HostVoxels, Program};

/// Most rays that one thread casts between two reports of its progress, unless a single pixel has more.
const REPORTED: usize = 1024;

/// The kernel on the host, ready for one scene and one volume.
pub struct Host {
    prepared: Prepared,
    voxels: Stored,
    density_of_value: Vec<f32>,
    occupied: Vec<u8>,
}

/// The volume as the kernel reads it.
enum Stored {
    Coded(Vec<u16>),
    Dense(Vec<f32>, Vec<u8>),
}

impl Host {
    /// Ready to project `volume` as `scene` and `plan` say.
    ///
    /// # Errors
    /// `Unsupported` for a volume that is too large; `OutOfMemory`.
    pub fn new(volume: &Volume, scene: &Scene, plan: &Plan) -> Result<Self> {
        let voxels = DeviceVoxels::new(volume)?;
        let count = voxels.framed().iter().product();
        let coded = voxels.layout() == Layout::Coded;
        let mut stored = if coded {
            Stored::Coded(filled(count, 0, "the kernel's voxels")?)
        } else {
            Stored::Dense(
                filled(count, 0.0, "the kernel's densities")?,
                filled(count, 0, "the kernel's labels")?,
            )
        };
        voxels.slabs(volume, |first, slab| {
            match (&mut stored, slab) {
                (Stored::Coded(all), Slab::Coded(codes)) => {
                    all[first..first + codes.len()].copy_from_slice(codes);
                }
                (Stored::Dense(densities, labels), Slab::Dense(density, label)) => {
                    densities[first..first + density.len()].copy_from_slice(density);
                    labels[first..first + label.len()].copy_from_slice(label);
                }
                _ => unreachable!("slabs are laid out as the voxels say"),
            }
            Ok(())
        })?;
        Ok(Self {
            prepared: Prepared::new(volume, &voxels, scene, plan)?,
            voxels: stored,
            density_of_value: voxels.density_of_value().to_vec(),
            occupied: voxels.occupancy(volume)?,
        })
    }
}

impl Engine for Host {
    fn project(&self, job: &Job<'_>) -> Result<Images<f32>> {
        let (size, materials) = (self.prepared.size, self.prepared.materials);
        let mut images = Images::zeroed(size, job.views.len(), materials, job.layers)?;
        let at_once = self.prepared.most_views;
        for (n, some) in job.views.chunks(at_once).enumerate() {
            let views = self.prepared.views(some, job.layers);
            let images = HostImages::from_view(&mut images, n * at_once);
            self.run(&views, images, None, &job.progress)?;
        }
        Ok(images)
    }

    fn has_signals(&self) -> bool {
        true
    }

    fn signals(&self, job: &SignalsJob<'_>) -> Result<Option<(Images<f32>, Passed)>> {
        let Some(at_once) = self.prepared.views_of_signals(job) else { return Ok(None) };
        let (size, materials) = (self.prepared.size, self.prepared.materials);
        let mut images = Images::zeroed(size, job.views.len(), materials, job.layers)?;
        let mut passed = Passed::zeroed(job, size)?;
        for (n, some) in job.views.chunks(at_once).enumerate() {
            let views = self.prepared.signals(some, job);
            let images = HostImages::from_view(&mut images, n * at_once);
            let first = n * at_once * job.rows.len() * size[0] * size[1];
            let signals = HostSignals {
                before: job.before.as_ptr(),
                passing: passed.passing[first..].as_mut_ptr(),
                open: passed.open.as_mut_ptr(),
            };
            self.run(&views, images, Some(signals), &job.progress)?;
        }
        Ok(Some((images, passed)))
    }
}

impl Host {
    /// Casts all rays of some views.
    fn run(
        &self,
        views: &Views,
        images: HostImages,
        signals: Option<HostSignals>,
        progress: &Progress<'_>,
    ) -> Result<()> {
        let [width, height] = self.prepared.size;
        let program = Program::of(&views.definitions)?;
        let call = Call { engine: self, program, views, images, signals };
        let piece = (REPORTED / self.prepared.rays_per_pixel).max(1);
        (0..views.beams.len() * height).into_par_iter().try_for_each(|row| {
            (0..width).step_by(piece).try_for_each(|first| {
                let columns = first..(first + piece).min(width);
                call.pixels([row / height, row % height], columns.clone());
                progress.finished(columns.len() * self.prepared.rays_per_pixel)
            })
        })
    }
}

/// What one call of the kernel reads and writes.
struct Call<'a> {
    engine: &'a Host,
    program: Arc<Program>,
    views: &'a Views,
    images: HostImages,
    signals: Option<HostSignals>,
}

impl Call<'_> {
    fn pixels(&self, view_and_row: [usize; 2], columns: Range<usize>) {
        let spectra = HostSpectra {
            weight: self.views.spectra.weights.as_ptr(),
            attenuation: self.views.spectra.attenuation.as_ptr(),
        };
        let occupied = self.engine.occupied.as_ptr().cast();
        let voxels = match &self.engine.voxels {
            Stored::Coded(codes) => {
                HostVoxels([codes.as_ptr().cast(), occupied, self.engine.density_of_value.as_ptr().cast()])
            }
            Stored::Dense(density, label) => {
                HostVoxels([density.as_ptr().cast(), label.as_ptr().cast(), occupied])
            }
        };
        // SAFETY: the arrays are as long as the launch says, and outlive the call; a pixel is written by one call only.
        unsafe {
            let places = (&self.images, self.signals.as_ref());
            self.program.project(self.views, &voxels, &spectra, places, view_and_row, columns);
        }
    }
}
