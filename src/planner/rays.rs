//! Rays of the expected views that effects are judged by, cast again and again.

use std::sync::Arc;

use crate::accuracy::{Estimate, FLOOR, Sample};
use crate::context::Context;
use crate::effects::{FocalSpot, Taps};
use crate::engine::{Layers, SILENT};
use crate::error::Result;
use crate::exposure::{from_point, pose_of};
use crate::geometry::DetectorPose;
use crate::method::Algorithm;
use crate::planner::expected;
use crate::projector::{Projector, ViewRequest};
use crate::scene::Scene;
use crate::volume::Volume;

/// How many, about.
const RAYS: usize = 600;
/// Decides which.
const SEED: u64 = 3;

/// Rays of a sample of the expected views, without effects.
pub(super) struct Rays {
    sample: Sample,
    projector: Projector,
}

/// Separable kernels with their parts, along columns and rows.
type Kernels = Vec<(f64, [Taps; 2])>;

impl Rays {
    pub(super) fn new(context: &Context, volume: &Arc<Volume>, scene: &Scene) -> Result<Self> {
        let sample = Sample::new(&expected::views(scene, volume), scene.detector, RAYS, SEED);
        let scene =
            Scene { bone: None, ..scene.with_method(Algorithm::Joseph.into()) }.of_rays(sample.size());
        Ok(Self { projector: Projector::new(&context.on_cpu(), volume.clone(), scene)?, sample })
    }

    fn cast(&self, views: &[ViewRequest]) -> Result<impl Iterator<Item = f64> + use<>> {
        let only = Layers { intensity: true, ..Layers::default() };
        Ok(self.projector.project(views, only, SILENT)?.intensity.into_iter().map(f64::from))
    }

    /// Intensities of a point source.
    pub(super) fn seen_from_centre(&self) -> Result<Vec<f64>> {
        Ok(self.cast(&self.sample.views([0.0; 2]))?.collect())
    }

    /// Mean intensities over the focal spot.
    pub(super) fn seen_from_points(&self, spot: &FocalSpot, counts: [usize; 2]) -> Result<Vec<f64>> {
        let mut mean = vec![0.0; self.sample.rays()];
        for (offset, part) in spot.offsets(counts) {
            let moved = |request: ViewRequest| from_point(&request.view, offset).map(ViewRequest::from);
            let views = self.sample.views([0.0; 2]).into_iter().map(moved).collect::<Result<Vec<_>>>()?;
            mean.iter_mut().zip(self.cast(&views)?).for_each(|(sum, own)| *sum += part * own);
        }
        Ok(mean)
    }

    /// Intensities blurred by kernels that depend on the view and on the pixels' pitch, mm.
    pub(super) fn convolved(
        &self,
        effect: &str,
        kernels: impl Fn(&DetectorPose, [f64; 2]) -> Result<Kernels>,
    ) -> Result<Vec<f64>> {
        let stride = self.sample.stride() as f64;
        let views = self.sample.views([0.0; 2]);
        let pixels = self.sample.rays() / views.len();
        let mut mean = vec![0.0; self.sample.rays()];
        for (place, (v, request)) in mean.chunks_mut(pixels).zip(views.iter().enumerate()) {
            let pose = pose_of(&request.view, &format!("scene.effects.{effect}"))?;
            let pitch = [pose.column_step, pose.row_step].map(|step| step.length() / stride);
            for (part, [columns, rows]) in kernels(pose, pitch)? {
                let of_rows = rows.weights();
                for (i, of_column) in columns.weights() {
                    for (j, of_row) in &of_rows {
                        let view = self.sample.views([f64::from(i), f64::from(*j)]).swap_remove(v);
                        let part = part * of_column * of_row;
                        place.iter_mut().zip(self.cast(&[view])?).for_each(|(sum, own)| *sum += part * own);
                    }
                }
            }
        }
        Ok(mean)
    }

    /// Errors of the line integral in HU-equivalents over the rays above the floor.
    pub(super) fn hu(&self, own: &[f64], right: &[f64]) -> Option<Estimate> {
        let i0 = self.projector.scene().spectral_model().map_or(1.0, |model| model.i0());
        let p = |intensity: f64| -(intensity / i0).ln();
        let floor = FLOOR * right.iter().map(|&i| p(i)).filter(|p| p.is_finite()).fold(0.0, f64::max);
        let replicates = self.sample.split(own).zip(self.sample.split(right)).map(|(own, right)| {
            let rays = own.iter().zip(right).map(move |(&own, &right)| (p(own), p(right)));
            rays.filter(move |(_, right)| *right > floor && right.is_finite())
                .map(|(own, right)| 1000.0 * (own - right) / right)
        });
        Estimate::of(replicates, self.sample.part())
    }
}
