//! A phantom as a volume, and the views it is seen in.

use std::sync::Arc;

use anyhow::{Context as _, Result};
use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, View};
use drr::phantom::Phantom;
use drr::physics::{Calibration, DensitySegment, MAX_HU, MIN_HU, SpectralModel, Thresholds};
use drr::volume::{Classification, Volume, VolumeBuilder};
use drr::{Algorithm, Context, Projector, Scene, ViewRequest};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::console::Console;

const SAD_MM: f64 = 1000.0;
const SDD_MM: f64 = 1500.0;
/// Width of the detector, mm: 720 pixels of 0.9 mm.
const WIDTH_MM: f64 = 648.0;

/// A phantom, its volume, and everything needed to project both.
pub(super) struct Stand {
    pub(super) phantom: Phantom,
    volume: Arc<Volume>,
    context: Context,
    calibration: Calibration,
}

/// Line integrals of both views on one detector, and where they were seen.
pub(super) struct Shadows {
    pub(super) poses: [DetectorPose; 2],
    pub(super) width: usize,
    /// One image per view, row by row.
    pub(super) line_integrals: [Vec<f64>; 2],
}

impl Stand {
    pub(super) fn new(phantom: Phantom, size: [usize; 3], threads: usize, console: Console) -> Result<Self> {
        let grid = phantom.grid(size).context("--size")?;
        let how =
            Classification { calibration: linear()?, thresholds: Thresholds::named(Thresholds::DEFAULT)? };
        let context = Context::new(Backend::Cpu, threads).context("--threads")?;
        let bar = console.bar("voxelising", size[2]);
        let volume = context.install(|| {
            let mut builder = VolumeBuilder::int16(grid, &how, true)?;
            phantom.voxelise(&grid, |_, hu, labels| {
                bar.inc(1);
                builder.push_int16(hu, Some(labels))
            })?;
            builder.finish()
        })?;
        bar.finish_and_clear();
        Ok(Self { phantom, volume: Arc::new(volume), context, calibration: how.calibration })
    }

    fn scene(algorithm: Algorithm, pixels: usize) -> Result<Scene> {
        Ok(Scene { method: algorithm.into(), ..Scene::new([pixels; 2])? })
    }

    fn poses(&self, pixels: usize) -> [DetectorPose; 2] {
        let pitch = WIDTH_MM / pixels as f64;
        DetectorPose::stereo_pair(self.volume.grid(), SAD_MM, SDD_MM, pitch, [pixels; 2])
    }

    /// The volume projected onto pixels × pixels, by the fast engine where it can.
    pub(super) fn project(&self, algorithm: Algorithm, pixels: usize) -> Result<Shadows> {
        let poses = self.poses(pixels);
        let views = poses.map(|pose| ViewRequest::from(View::Pose(pose)));
        let layers = Layers { line_integral: true, ..Layers::default() };
        let values: Vec<f64> = if algorithm == Algorithm::Exact {
            // Any algorithm will do for a projector that only lends its volume and scene.
            let projector = self.projector(Algorithm::Joseph, pixels)?;
            projector.reference(algorithm, &views, layers, SILENT)?.line_integral
        } else {
            let images = self.projector(algorithm, pixels)?.project(&views, layers, SILENT)?;
            images.line_integral.into_iter().map(f64::from).collect()
        };
        let (first, second) = values.split_at(pixels * pixels);
        Ok(Shadows { poses, width: pixels, line_integrals: [first.to_vec(), second.to_vec()] })
    }

    fn projector(&self, algorithm: Algorithm, pixels: usize) -> Result<Projector> {
        Ok(Projector::new(&self.context, self.volume.clone(), Self::scene(algorithm, pixels)?)?)
    }

    /// The phantom's own line integrals on the same detector, in closed form.
    pub(super) fn closed_form(&self, pixels: usize) -> Result<Shadows> {
        let model = Self::scene(Algorithm::Joseph, pixels)?.spectral_model()?;
        let poses = self.poses(pixels);
        let image = |pose: &DetectorPose| -> Result<Vec<f64>> {
            let pixel = |n: usize| self.line_integral(&model, pose, (n % pixels) as f64, (n / pixels) as f64);
            self.context.install(|| (0..pixels * pixels).into_par_iter().map(pixel).collect())
        };
        Ok(Shadows { poses, width: pixels, line_integrals: [image(&poses[0])?, image(&poses[1])?] })
    }

    fn line_integral(&self, model: &SpectralModel, pose: &DetectorPose, i: f64, j: f64) -> Result<f64> {
        let density = |hu: i16| self.calibration.density(f64::from(hu));
        let areal_density =
            self.phantom.areal_densities(pose.source, pose.pixel(i, j), &density, model.materials())?;
        Ok(model.line_integral(&areal_density))
    }
}

impl Shadows {
    /// Distance of two pixels in the plane of the isocentre, mm.
    pub(super) fn pixel_at_isocentre(&self) -> f64 {
        WIDTH_MM / self.width as f64 * SAD_MM / SDD_MM
    }

    /// (p − `p_ref`)/`p_ref` times what `weight` gives for the ends of the ray; rays for which it gives nothing are
    /// left out.
    pub(super) fn relative_differences(
        &self,
        truth: &Self,
        weight: impl Fn(DVec3, DVec3) -> Option<f64>,
    ) -> Vec<f64> {
        let mut differences = Vec::new();
        for (view, pose) in self.poses.iter().enumerate() {
            let pairs = self.line_integrals[view].iter().zip(&truth.line_integrals[view]);
            for (n, (p, reference)) in pairs.enumerate() {
                let pixel = pose.pixel((n % self.width) as f64, (n / self.width) as f64);
                differences
                    .extend(weight(pose.source, pixel).map(|weight| weight * (p - reference) / reference));
            }
        }
        differences
    }
}

/// Density in proportion to HU + 1000, so that a voxel that is half bone has half of its mass: what is measured is the
/// projector and not the calibration's bend at water.
fn linear() -> Result<Calibration> {
    let segment = DensitySegment { first_hu: MIN_HU, end_hu: MAX_HU + 1.0, intercept: 1.0, slope: 1e-3 };
    Ok(Calibration::new("linear", vec![segment])?)
}

/// Column and row, with fractions, of the shadow of a point.
pub(super) fn shadow(pose: &DetectorPose, point: DVec3) -> [f64; 2] {
    let frame = DMat3::from_cols(pose.column_step, pose.row_step, pose.first_pixel - pose.source);
    let p = frame.inverse() * (point - pose.source);
    [p.x / p.z, p.y / p.z]
}
