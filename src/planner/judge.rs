//! What candidates are measured by: many rays that are cast by a fine march, and the hardest and some others of them that
//! are integrated exactly.

use std::sync::Arc;

use crate::accuracy::{Estimate, Sample, Truth};
use crate::context::Context;
use crate::engine::{Images, Layers, SILENT};
use crate::error::Result;
use crate::method::{Algorithm, Method};
use crate::planner::{Reach, expected};
use crate::projector::{Projector, ViewRequest};
use crate::scene::Scene;
use crate::volume::Volume;

/// Rays that are cast by the yardstick, about. Most of an image's error is at few of its rays, its edges: exact integrals of
/// enough of them would take longer than the projection.
const RAYS: usize = 8000;
/// Decides which.
const SEED: u64 = 1;
/// Of those, the rays where Joseph's rule is furthest from the yardstick that are integrated exactly.
const HARDEST: usize = 400;
/// Replicates of the others, and rays of each.
const OTHERS: [usize; 2] = [8, 50];
/// Step of the march that is the yardstick, voxels.
const STEP: f64 = 0.25;

/// Measures candidates.
pub(super) struct Judge {
    yardstick: Truth,
    reach: Reach,
    /// Places of the rays that are known exactly among the yardstick's: the hardest, then replicates of the others.
    known: Vec<usize>,
    hardest: usize,
    /// Their line integrals.
    exact: Vec<f64>,
    views: Vec<ViewRequest>,
    /// What the yardstick's rays say of all: upper ends of root mean squares over what they are among these rays, of
    /// Joseph's errors, HU and mm.
    margin: [f64; 2],
    /// The yardstick's own errors, HU and mm.
    own: [Option<Estimate>; 2],
}

impl Judge {
    /// Of the views that a scene expects.
    pub(super) fn new(context: &Context, volume: &Arc<Volume>, scene: &Scene) -> Result<Self> {
        let sample = Sample::new(&expected::views(scene, volume), scene.detector, RAYS, SEED);
        let march = Method::from(Algorithm::March { step: STEP });
        let yardstick = Truth::of_method(context, volume, scene, sample, march)?;
        let with = |method: Method| {
            let scene = Scene { bone: None, ..scene.with_method(method) };
            Projector::new(&context.on_cpu(), volume.clone(), scene)
        };
        let joseph = with(Algorithm::Joseph.into())?;
        let layers = Layers { bone_path: false, ..Layers::ALL };
        let rays = yardstick.sample().views([0.0; 2]);
        let images = joseph.with_detector(yardstick.sample().size())?.project(&rays, layers, SILENT)?;
        let (known, hardest) = rays_to_know(&yardstick, &images);
        let views = yardstick.sample().rays_of(&known);
        let only = Layers { line_integral: true, ..Layers::default() };
        let exact =
            joseph.with_detector([1, 1])?.reference(Algorithm::Exact, &views, only, SILENT)?.line_integral;
        let reach = Reach::of(&images);
        let measured = yardstick.compare(&images.map(|&x| f64::from(x)));
        let of_all =
            |error: Option<Estimate>| error.filter(|e| e.rms > 0.0).map_or(1.0, |e| e.rms_high / e.rms);
        let margin = [measured.hu, measured.mm].map(of_all);
        let mut judge = Self { yardstick, reach, known, hardest, exact, views, margin, own: [None; 2] };
        judge.own = judge.exactly(&with(march)?)?;
        Ok(judge)
    }

    /// What the rays reach.
    pub(super) fn reach(&self) -> &Reach {
        &self.reach
    }

    /// The p above which errors count.
    pub(super) fn floor(&self) -> f64 {
        self.yardstick.floor()
    }

    /// Whether no ray meets anything that could be measured.
    pub(super) fn sees_nothing(&self) -> bool {
        self.known.is_empty()
    }

    /// The rays that candidates are measured on, and those that are known exactly.
    pub(super) fn rays(&self) -> [usize; 2] {
        [self.yardstick.sample().rays(), self.known.len()]
    }

    /// The errors of a candidate, HU and mm. Those of a coarser one than the yardstick are no larger than what they are
    /// against the yardstick, and the yardstick's own.
    pub(super) fn measure(&self, candidate: &Projector) -> Result<[Option<Estimate>; 2]> {
        if matches!(candidate.plan().method.algorithm, Algorithm::March { step } if step <= STEP) {
            return self.exactly(candidate);
        }
        let measured = self.yardstick.compare(&self.yardstick.cast(candidate)?);
        let in_all = |error: Option<Estimate>, own: Option<Estimate>| {
            let own = own.unwrap_or_default();
            error.map(|error| Estimate {
                rms_high: error.rms_high + own.rms_high,
                max: error.max + own.max,
                ..error
            })
        };
        Ok([in_all(measured.hu, self.own[0]), in_all(measured.mm, self.own[1])])
    }

    /// The errors by the rays that are known exactly.
    fn exactly(&self, projector: &Projector) -> Result<[Option<Estimate>; 2]> {
        let only = Layers { line_integral: true, ..Layers::default() };
        let own = projector.with_detector([1, 1])?.project(&self.views, only, SILENT)?.line_integral;
        let off = |k: usize| f64::from(own[k]) - self.exact[k];
        let hu = |k: usize| Some(1000.0 * off(k) / self.exact[k]);
        let mm = |k: usize| self.yardstick.steepness_of(self.known[k]).map(|per_mm| off(k) / per_mm);
        let is_steep = |ray: &usize| self.yardstick.steepness_of(*ray).is_some();
        let errors = [self.estimate(hu, |_| true), self.estimate(mm, is_steep)];
        // They are estimated over the yardstick's rays, which are a sample too.
        let of_all =
            |k: usize| errors[k].map(|error| Estimate { rms_high: self.margin[k] * error.rms_high, ..error });
        Ok([of_all(0), of_all(1)])
    }

    /// Of errors of the known rays; `counts` tells which of the yardstick's have one.
    fn estimate(
        &self,
        error: impl Fn(usize) -> Option<f64> + Copy,
        counts: impl Fn(&usize) -> bool,
    ) -> Option<Estimate> {
        let known = 0..self.known.len();
        let hardest = known.clone().take(self.hardest).filter_map(error);
        let others: Vec<usize> = known.skip(self.hardest).collect();
        let replicates = others.chunks(OTHERS[1]).map(|rays| rays.iter().copied().filter_map(error));
        let seen = (0..self.yardstick.sample().rays()).filter(|&ray| self.yardstick.is_seen(ray));
        let of_hardest = self.known[..self.hardest].iter().filter(|ray| counts(ray)).count();
        let unknown = seen.filter(counts).count() - of_hardest;
        let part = if others.len() >= unknown { 1.0 } else { 0.0 };
        Estimate::of_strata(hardest, Estimate::of(replicates, part), unknown)
    }
}

/// The hardest rays, and some of the others in a scattered order; how many are the hardest.
fn rays_to_know(yardstick: &Truth, joseph: &Images<f32>) -> (Vec<usize>, usize) {
    let right = &yardstick.right().line_integral;
    let off = |ray: usize| ((f64::from(joseph.line_integral[ray]) - right[ray]) / right[ray]).abs();
    let mut seen: Vec<usize> = (0..right.len()).filter(|&ray| yardstick.is_seen(ray)).collect();
    seen.sort_by(|&a, &b| off(b).total_cmp(&off(a)));
    let hardest = HARDEST.min(seen.len());
    let others = seen.len() - hardest;
    let wanted = (OTHERS[0] * OTHERS[1]).min(others);
    let mut known = seen[..hardest].to_vec();
    // Every nth of those that are in order of their errors, replicate by replicate.
    let nth = |n: usize| seen[hardest + n * others / wanted.max(1)];
    known.extend((0..OTHERS[0]).flat_map(|r| (r..wanted).step_by(OTHERS[0])).map(nth));
    (known, hardest)
}
