//! The float64 engine: each fast algorithm's twin, and the exact integral of the interpolated field.

mod distance_driven;
mod exact;
mod joseph;
mod march;
mod sample;
mod siddon;

use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use crate::allocation::reserved;
use crate::engine::images::PixelValue;
use crate::engine::{Backend, Engine, Images, Job, ViewJob};
use crate::error::Result;
use crate::method::Algorithm;
use crate::physics::{MAX_MATERIALS, SpectralModel};
use crate::raycast::{Footprint, Ray, Span};
use crate::scene::Scene;
use crate::volume::Volume;

/// Most rays that one thread casts between two reports of its progress, unless a single pixel has more. Callers may
/// cancel at each.
const REPORTED: usize = 512;

/// Areal densities along a ray in (g/cm³)·(units of s), by label.
type PerLabel = [f64; MAX_MATERIALS];

/// The float64 engine, ready for one scene and one volume.
pub struct Reference {
    volume: Arc<Volume>,
    algorithm: Algorithm,
    supersampling: usize,
    size: [usize; 2],
    materials: usize,
    bone: Option<u8>,
    spectral: SpectralModel,
}

impl Reference {
    /// Ready to project `volume` as `scene` says, but with the given algorithm.
    ///
    /// # Errors
    /// `InvalidArgument` when the algorithm's parameters are out of range; `Unsupported` for voxels in a texture.
    pub fn new(volume: Arc<Volume>, scene: &Scene, algorithm: Algorithm) -> Result<Self> {
        algorithm.validate()?;
        Backend::Reference.check_reads(&volume)?;
        Ok(Self {
            volume,
            algorithm,
            supersampling: scene.supersampling,
            size: scene.detector,
            materials: scene.materials.names().len(),
            bone: scene.bone,
            spectral: scene.spectral_model()?,
        })
    }

    /// Projects all views of the job in float64.
    pub fn project_f64(&self, job: &Job<'_>) -> Result<Images<f64>> {
        self.run(job, |x| x)
    }

    fn run<T: Copy + Default + Send>(
        &self,
        job: &Job<'_>,
        convert: impl Fn(f64) -> T + Sync,
    ) -> Result<Images<T>> {
        let images = Mutex::new(Images::zeroed(self.size, job.views.len(), self.materials, job.layers)?);
        let [width, height] = self.size;
        let rays = self.supersampling * self.supersampling;
        let piece = (REPORTED / rays).max(1);
        (0..job.views.len() * height).into_par_iter().try_for_each(|n| {
            let (v, j) = (n / height, n % height);
            let mut row = reserved(width, "a row of the detector")?;
            for first in (0..width).step_by(piece) {
                let columns = first..(first + piece).min(width);
                row.extend(columns.clone().map(|i| self.pixel(&job.views[v], job, i, j)));
                job.progress.finished(columns.len() * rays)?;
            }
            images.lock().unwrap_or_else(PoisonError::into_inner).store(v, j, 0..row.len(), &row, &convert);
            Ok(())
        })?;
        Ok(images.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    fn pixel(&self, view: &ViewJob, job: &Job<'_>, column: usize, row: usize) -> PixelValue {
        let n = self.supersampling;
        let offset = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
        let footprints = view.beam.of_parts(n).footprints();
        let cast = |k: usize| {
            let (column, row) = (column as f64 + offset(k % n), row as f64 + offset(k / n));
            let ray = view.beam.ray(column, row);
            self.ray(view, job, &ray, &footprints.of(&ray, column, row))
        };
        let rays: Vec<_> = (0..n * n).map(cast).collect();
        PixelValue::mean(&rays)
    }

    fn ray(&self, view: &ViewJob, job: &Job<'_>, ray: &Ray, footprint: &Footprint) -> PixelValue {
        let spectral = view.spectral.as_deref().unwrap_or(&self.spectral);
        let Some(span) = ray.clip(self.volume.grid().dimensions()) else {
            return PixelValue::vacuum(spectral.i0());
        };
        let areal_density = self.areal_density(ray, footprint, span);
        let seen = &areal_density[..self.materials];
        let bone_path = if job.layers.bone_path { self.bone_path(ray, span) } else { 0.0 };
        PixelValue {
            intensity: spectral.intensity(seen),
            line_integral: spectral.line_integral(seen),
            areal_density,
            bone_path,
        }
    }

    /// Length through bone in mm.
    pub(crate) fn bone_path(&self, ray: &Ray, span: Span) -> f64 {
        let through = |bone| ray.mm_per_slice * siddon::path_through(&self.volume, ray, span, bone);
        self.bone.map_or(0.0, through)
    }

    /// Areal densities in g/cm², by label.
    pub(crate) fn areal_density(&self, ray: &Ray, footprint: &Footprint, span: Span) -> PerLabel {
        let per_slice = match self.algorithm {
            Algorithm::Joseph => joseph::integrate(&self.volume, ray, span),
            Algorithm::March { step } => march::integrate(&self.volume, ray, span, step),
            Algorithm::Siddon => siddon::integrate(&self.volume, ray, span),
            Algorithm::DistanceDriven => distance_driven::integrate(&self.volume, ray, footprint, span),
            Algorithm::Exact => exact::integrate(&self.volume, ray, span),
        };
        // mm to cm: densities are per cm³.
        per_slice.map(|sum| 0.1 * ray.mm_per_slice * sum)
    }
}

impl Engine for Reference {
    fn project(&self, job: &Job<'_>) -> Result<Images<f32>> {
        self.run(job, |x| x as f32)
    }
}

#[cfg(test)]
mod tests;
