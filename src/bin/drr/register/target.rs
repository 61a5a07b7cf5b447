//! The images to which the CT is registered.

use std::ops::ControlFlow;

use anyhow::{Context as _, Result};
use drr::alignment::Misalignment;
use drr::engine::Layers;
use drr::geometry::{RigidMotion, View};
use drr::parallel::ViewParameters;
use drr::registration::RegistrationView;
use drr::{Algorithm, Projector, ViewRequest};
use glam::DVec3;

use super::{Arguments, Study};
use crate::console::Console;
use crate::line_integrals::{photon_noise, read_line_integrals};
use crate::views::Views;

/// Measured images, or simulated ones.
pub(super) struct Target {
    /// Line integrals of each view.
    pub(super) images: Vec<Vec<f32>>,
    /// Where the object is, where that is known.
    pub(super) truth: Option<RigidMotion>,
}

impl Target {
    /// What `--measured` has, or what is simulated of a hidden motion.
    pub(super) fn new(study: &Study<'_>, console: Console) -> Result<Self> {
        let Study { arguments, views, .. } = study;
        if let Some(path) = &arguments.measured {
            let pixels = views.size[0] * views.size[1];
            let images = read_line_integrals(path, pixels * views.poses.len())?;
            let images = images.chunks_exact(pixels).map(<[f32]>::to_vec).collect();
            return Ok(Self { images, truth: None });
        }
        let truth = hidden(arguments)?;
        Ok(Self { images: simulate(study, &truth, console)?, truth: Some(truth) })
    }

    /// For a registrar.
    pub(super) fn views<'a>(&'a self, views: &Views) -> Vec<RegistrationView<'a, f32>> {
        let view = |(&pose, image): (_, &'a Vec<f32>)| RegistrationView { pose, measured: image, mask: None };
        views.poses.iter().zip(&self.images).map(view).collect()
    }
}

/// Line integrals of each view of the moved object, by the exact integral, with noise.
fn simulate(study: &Study<'_>, truth: &RigidMotion, console: Console) -> Result<Vec<Vec<f32>>> {
    let Study { arguments, context, volume, scene, views } = *study;
    let noise = photon_noise(arguments.photons, arguments.seed)?;
    let projector = Projector::new(context, volume.clone(), scene.clone()).context("--materials")?;
    let pivot = volume.grid().centre();
    let moved = |pose| ViewRequest::from(View::Pose(truth.seen_from(pose, pivot)));
    let requests: Vec<_> = views.poses.iter().map(moved).collect();
    let bar = console.bar("simulating", projector.rays(&requests));
    let progress = |rays: usize| {
        bar.inc(rays as u64);
        ControlFlow::Continue(())
    };
    let layers = Layers { line_integral: true, ..Layers::default() };
    let exact = projector.reference(Algorithm::Exact, &requests, layers, &progress)?;
    bar.finish_and_clear();
    let image = |view: usize| {
        let mut image = exact.view(&exact.line_integral, view).to_vec();
        if let Some(noise) = &noise {
            context.install(|| noise.apply(view, views.size[0], &mut image));
        }
        image.into_iter().map(|p| p as f32).collect()
    };
    Ok((0..views.poses.len()).map(image).collect())
}

/// The hidden motion: each parameter uniform within its largest.
fn hidden(arguments: &Arguments) -> Result<RigidMotion> {
    let Arguments { max_degrees: degrees, max_mm: mm, seed, .. } = *arguments;
    let errors = Misalignment { degrees, mm, seed };
    errors.validate().context("--max-degrees, --max-mm")?;
    // One draw has the translations of a parallel beam, which sees none along y: that is the second draw's first.
    let draw = |n: usize| errors.applied(n, &ViewParameters::default());
    let (ViewParameters { alpha, beta, phi, dx: x, dz: z }, ViewParameters { dx: y, .. }) =
        (draw(0), draw(1));
    Ok(RigidMotion { angles: [alpha, beta, phi], translation: DVec3::new(x, y, z) })
}
