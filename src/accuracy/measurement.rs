//! What is right for the rays of a sample, and how far a projector is from it.

use std::sync::Arc;

use serde::Serialize;

use crate::accuracy::{Estimate, Sample};
use crate::context::Context;
use crate::engine::{Images, Layers, SILENT};
use crate::error::Result;
use crate::geometry::Grid;
use crate::method::{Algorithm, Method};
use crate::projector::{Projector, ViewRequest};
use crate::raycast::Beam;
use crate::scene::Scene;
use crate::volume::Volume;

/// Rays below this part of the largest line integral are left out of relative errors.
pub const FLOOR: f64 = 0.05;

/// The part of the rays that counts as steep: those where the line integral changes fastest across the detector.
const STEEP: f64 = 0.1;

/// What is measured.
const LAYERS: Layers =
    Layers { intensity: true, line_integral: true, areal_density: false, bone_path: false };

/// What is right for the rays of a sample, with all energies.
pub struct Truth {
    sample: Sample,
    right: Images<f64>,
    i0: f64,
    floor: f64,
    /// |∇p| across the rays, per mm near the volume's centre; `None` where it is not steep.
    steepness: Vec<Option<f64>>,
}

/// The errors of a projector over the rays of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Measurement {
    /// Of the line integral in HU-equivalents, 1000 (p − `p_ref`)/`p_ref`, over rays with `p_ref` above the floor.
    pub hu: Option<Estimate>,
    /// Displacement of edges, mm near the volume's centre: what would have to be moved, and how far, for the error of the
    /// line integral to come of nothing else. Over the tenth of those rays where the image is steepest.
    pub mm: Option<Estimate>,
    /// ‖p − `p_ref`‖/‖`p_ref`‖ over all rays.
    pub relative_l2: f64,
    /// Largest |p − `p_ref`|.
    pub max_line_integral: f64,
    /// Largest |I − `I_ref`|/I0.
    pub max_intensity: f64,
}

impl Truth {
    /// The exact integrals of the interpolated volume along the rays of `sample`, in float64. Of the scene only the
    /// physics matters.
    ///
    /// # Errors
    /// As [`Projector::new`] and [`Projector::project`].
    pub fn new(context: &Context, volume: &Arc<Volume>, scene: &Scene, sample: Sample) -> Result<Self> {
        let exact = |views: &[ViewRequest], joseph: &Projector| {
            joseph.reference(Algorithm::Exact, views, LAYERS, SILENT)
        };
        Self::of(context, volume, scene, sample, exact)
    }

    /// What a method of the engine `cpu` gives for many rays, in a small part of the time: right up to its own error.
    ///
    /// # Errors
    /// As [`Truth::new`].
    pub(crate) fn of_method(
        context: &Context,
        volume: &Arc<Volume>,
        scene: &Scene,
        sample: Sample,
        method: Method,
    ) -> Result<Self> {
        let cast = |views: &[ViewRequest], joseph: &Projector| {
            let scene = joseph.scene().with_method(method);
            let projector = Projector::new(&context.on_cpu(), volume.clone(), scene)?;
            Ok(projector.project(views, LAYERS, SILENT)?.map(|&x| f64::from(x)))
        };
        Self::of(context, volume, scene, sample, cast)
    }

    fn of(
        context: &Context,
        volume: &Arc<Volume>,
        scene: &Scene,
        sample: Sample,
        cast: impl Fn(&[ViewRequest], &Projector) -> Result<Images<f64>>,
    ) -> Result<Self> {
        let scene = scene.with_method(Algorithm::Joseph.into());
        let scene = Scene { detector: sample.size(), supersampling: 1, bone: None, ..scene };
        let joseph = Projector::new(&context.on_cpu(), volume.clone(), scene)?;
        let right = cast(&sample.views([0.0; 2]), &joseph)?;
        let largest = right.line_integral.iter().copied().filter(|p| p.is_finite()).fold(0.0, f64::max);
        let i0 = joseph.scene().spectral_model()?.i0();
        let mut truth = Self { floor: FLOOR * largest, i0, steepness: Vec::new(), right, sample };
        truth.steepness = truth.steepness(&joseph)?;
        Ok(truth)
    }

    /// The rays.
    pub fn sample(&self) -> &Sample {
        &self.sample
    }

    /// The p above which relative errors are taken.
    pub fn floor(&self) -> f64 {
        self.floor
    }

    /// Intensities and line integrals of the rays.
    pub(crate) fn right(&self) -> &Images<f64> {
        &self.right
    }

    /// Whether a ray is above the floor.
    pub(crate) fn is_seen(&self, ray: usize) -> bool {
        let p = self.right.line_integral[ray];
        p.is_finite() && p > self.floor
    }

    /// |∇p| across a ray, per mm near the volume's centre; `None` where it is not steep.
    pub(crate) fn steepness_of(&self, ray: usize) -> Option<f64> {
        self.steepness[ray]
    }

    /// The same rays, cast with a projector's engine and plan.
    ///
    /// # Errors
    /// As [`Projector::project`].
    pub fn cast(&self, projector: &Projector) -> Result<Images<f64>> {
        let projector = projector.with_detector(self.sample.size())?;
        let images = projector.project(&self.sample.views([0.0; 2]), LAYERS, SILENT)?;
        Ok(images.map(|&x| f64::from(x)))
    }

    /// The same rays, cast in float64 with the projector's algorithm and all energies.
    ///
    /// # Errors
    /// As [`Projector::project`].
    pub fn cast_twin(&self, projector: &Projector) -> Result<Images<f64>> {
        let projector = projector.with_detector(self.sample.size())?;
        let algorithm = projector.plan().method.algorithm;
        projector.reference(algorithm, &self.sample.views([0.0; 2]), LAYERS, SILENT)
    }

    /// The errors of line integrals and intensities of the same rays.
    pub fn compare(&self, images: &Images<f64>) -> Measurement {
        let pairs = || images.line_integral.iter().zip(&self.right.line_integral);
        let finite = || pairs().filter(|(_, reference)| reference.is_finite());
        let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
        let norm = squares(&mut finite().map(|(_, reference)| *reference));
        let off = squares(&mut finite().map(|(p, reference)| p - reference));
        let intensities = images.intensity.iter().zip(&self.right.intensity);
        Measurement {
            hu: self.hu(images, &self.right),
            mm: self
                .estimate(images, &self.right, |error, _, steepness| steepness.map(|per_mm| error / per_mm)),
            relative_l2: if norm > 0.0 { (off / norm).sqrt() } else { 0.0 },
            max_line_integral: finite().map(|(p, reference)| (p - reference).abs()).fold(0.0, f64::max),
            max_intensity: intensities.map(|(i, exact)| (i - exact).abs() / self.i0).fold(0.0, f64::max),
        }
    }

    /// In HU-equivalents, against any images of the same rays.
    pub fn hu(&self, images: &Images<f64>, reference: &Images<f64>) -> Option<Estimate> {
        self.estimate(images, reference, |error, reference, _| Some(1000.0 * error / reference))
    }

    /// An error by its difference of p, the right p and the steepness there, over the rays above the floor.
    fn estimate(
        &self,
        images: &Images<f64>,
        reference: &Images<f64>,
        error: impl Fn(f64, f64, Option<f64>) -> Option<f64> + Copy,
    ) -> Option<Estimate> {
        let [right, own] = [&reference.line_integral, &images.line_integral].map(|p| self.sample.split(p));
        let replicates = right.zip(own).zip(self.sample.split(&self.steepness));
        let replicates = replicates.map(|((right, own), steepness)| {
            let rays = right.iter().zip(own).zip(steepness);
            let seen = rays.filter(|((right, _), _)| right.is_finite() && **right > self.floor);
            seen.filter_map(move |((right, own), &steepness)| error(own - right, *right, steepness))
        });
        Estimate::of(replicates, self.sample.part())
    }

    /// By the differences to the pixels to the right and below.
    fn steepness(&self, joseph: &Projector) -> Result<Vec<Option<f64>>> {
        let only = Layers { line_integral: true, ..Layers::default() };
        let cast = |views: &[ViewRequest]| joseph.project(views, only, SILENT).map(|i| i.line_integral);
        let views = self.sample.views([0.0; 2]);
        let here = cast(&views)?;
        let mut squares = vec![0.0; here.len()];
        for to in [[1.0, 0.0], [0.0, 1.0]] {
            let neighbours = self.sample.views(to);
            let there = cast(&neighbours)?;
            let apart = distances([&views, &neighbours], joseph.volume().grid(), self.sample.size())?;
            for (k, square) in squares.iter_mut().enumerate() {
                *square += (f64::from(there[k] - here[k]) / apart[k]).powi(2);
            }
        }
        let mut seen: Vec<f64> = squares
            .iter()
            .zip(&self.right.line_integral)
            .filter(|(square, p)| square.is_finite() && **p > self.floor)
            .map(|(square, _)| *square)
            .collect();
        let rank = ((1.0 - STEEP) * seen.len() as f64) as usize;
        let steep = if seen.is_empty() { 0.0 } else { *seen.select_nth_unstable_by(rank, f64::total_cmp).1 };
        Ok(squares
            .into_iter()
            .map(|square| (square >= steep && square > 0.0).then(|| square.sqrt()))
            .collect())
    }
}

/// Distance from each ray of one list of views to that of the other, near the volume's centre, mm.
fn distances(views: [&[ViewRequest]; 2], grid: &Grid, size: [usize; 2]) -> Result<Vec<f64>> {
    let mut all = Vec::new();
    for (here, there) in views[0].iter().zip(views[1]) {
        let (here, there) = (Beam::new(&here.view, grid, size)?, Beam::new(&there.view, grid, size)?);
        let pixels = (0..size[1]).flat_map(|j| (0..size[0]).map(move |i| (i as f64, j as f64)));
        all.extend(pixels.map(|(i, j)| here.ray(i, j).distance(&there.ray(i, j), grid)));
    }
    Ok(all)
}
