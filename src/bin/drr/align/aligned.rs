//! Views that were aligned.

use std::ops::ControlFlow;
use std::time::Instant;

use anyhow::{Context as _, Result};
use drr::Context;
use drr::alignment::{Alignment, AlignmentOptions, Pyramid};
use drr::parallel::{Quadrature, RaySelection, ViewParameters};

use super::observed::Observed;
use super::scene::Scene;
use crate::console::Console;
use crate::rms::rmse;

/// Pixels and voxels of the coarsest level's shortest side, at least.
const FEWEST: usize = 24;
/// Levels where the arguments do not say.
const MOST_LEVELS: usize = 3;

/// One view's alignment.
pub(super) struct Aligned {
    pub(super) alignment: Alignment,
    pub(super) seconds: f64,
    /// Root mean squares of measured − projected line integrals, before and after.
    pub(super) residuals: [f64; 2],
    /// Projections, before and after.
    pub(super) images: [Vec<f32>; 2],
}

/// Levels that fit the geometry.
pub(super) fn levels(scene: &Scene) -> usize {
    let [nu, nv] = scene.geometry.detector;
    let side = scene.geometry.dimensions.into_iter().fold(nu.min(nv), usize::min);
    (1..MOST_LEVELS).take_while(|level| side >> level >= FEWEST).count() + 1
}

/// All views, one after the other: each evaluation uses all threads.
pub(super) fn align(
    scene: &Scene,
    views: &[Observed],
    levels: usize,
    uniform: bool,
    context: &Context,
    console: Console,
) -> Result<Vec<Aligned>> {
    let pyramid = Pyramid::new(context, scene.geometry, Quadrature::Steps, &scene.volume, levels)?;
    let bar = console.bar("aligning", views.len() * levels);
    let aligned = views.iter().enumerate().map(|(n, view)| {
        let start = Instant::now();
        let mut level = 0;
        let mut report = |now: usize, _: &drr::alignment::Step<{ ViewParameters::COUNT }>| {
            bar.inc((now - level) as u64);
            level = now;
            ControlFlow::Continue(())
        };
        let options = AlignmentOptions { photons: !uniform, ..AlignmentOptions::default() };
        let alignment = pyramid.align_view(&view.image, None, &view.nominal, &options, &mut report);
        let alignment = alignment.with_context(|| format!("view {n}"))?;
        let seconds = start.elapsed().as_secs_f64();
        bar.inc(1);
        let projected =
            |at: &ViewParameters| pyramid.finest().forward_project_view(at, RaySelection::default());
        let images = [projected(&view.nominal)?, projected(&alignment.parameters)?];
        let residuals = [0, 1].map(|k| rmse(&view.image, &images[k]));
        Ok(Aligned { alignment, seconds, residuals, images })
    });
    let aligned = aligned.collect::<Result<_>>();
    bar.finish_and_clear();
    aligned
}
