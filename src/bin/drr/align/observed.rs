//! The views that are aligned: simulated ones, whose parameters are known, or measured ones.

use anyhow::{Context as _, Result};
use drr::Context;
use drr::alignment::Misalignment;
use drr::formats::read_views;
use drr::parallel::{ParallelProjector, Quadrature, RaySelection, ViewParameters};

use super::Arguments;
use super::scene::Scene;
use crate::console::Console;
use crate::line_integrals::{photon_noise, read_line_integrals};

/// One view's image, and what is thought of it.
pub(super) struct Observed {
    /// Line integrals, `v*nu + u`.
    pub(super) image: Vec<f32>,
    /// Where the view is thought to be.
    pub(super) nominal: ViewParameters,
    /// Where it is, where that is known.
    pub(super) truth: Option<ViewParameters>,
}

/// What the arguments ask for.
pub(super) fn observed(
    arguments: &Arguments,
    scene: &Scene,
    context: &Context,
    console: Console,
) -> Result<Vec<Observed>> {
    match (&arguments.measured, &arguments.views) {
        (Some(images), Some(views)) => measured(images, views, scene),
        _ => simulated(arguments, scene, context, console),
    }
}

fn measured(images: &std::path::Path, views: &std::path::Path, scene: &Scene) -> Result<Vec<Observed>> {
    let views = read_views(views).context("--views")?;
    let pixels = scene.geometry.pixels();
    let images = read_line_integrals(images, pixels * views.len()).with_context(|| {
        let [nu, nv] = scene.geometry.detector;
        format!("{} views of {nu}x{nv} pixels", views.len())
    })?;
    let view =
        |(image, nominal): (&[f32], ViewParameters)| Observed { image: image.to_vec(), nominal, truth: None };
    Ok(images.chunks_exact(pixels).zip(views).map(view).collect())
}

/// Exact integrals of the interpolated voxels, which are not the sums of samples that views are aligned with; then
/// noise.
fn simulated(
    arguments: &Arguments,
    scene: &Scene,
    context: &Context,
    console: Console,
) -> Result<Vec<Observed>> {
    let misalignment =
        Misalignment { degrees: arguments.max_degrees, mm: arguments.max_mm, seed: arguments.seed };
    misalignment.validate().context("--max-degrees, --max-mm")?;
    let noise = photon_noise(arguments.photons, arguments.seed)?;
    let exact = ParallelProjector::new(context, scene.geometry, Quadrature::Exact, &scene.volume)?;
    let bar = console.bar("simulating", arguments.count);
    let views = (0..arguments.count).map(|view| {
        let phi = (arguments.arc * view as f64 / arguments.count as f64).to_radians();
        let nominal = ViewParameters { phi, ..ViewParameters::default() };
        let truth = misalignment.applied(view, &nominal);
        let image = exact.forward_project_view(&truth, RaySelection::default());
        let mut image = image.with_context(|| format!("view {view}: --arc, --max-degrees, --max-mm"))?;
        if let Some(noise) = &noise {
            context.install(|| noise.apply(view, scene.geometry.detector[0], &mut image));
        }
        bar.inc(1);
        Ok(Observed { image, nominal, truth: Some(truth) })
    });
    let views = views.collect::<Result<_>>();
    bar.finish_and_clear();
    views
}
