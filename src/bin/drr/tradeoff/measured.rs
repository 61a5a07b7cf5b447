//! Times and errors of settings.

use std::time::Instant;

use anyhow::Result;
use drr::accuracy::{Estimate, Measurement, Truth};
use drr::engine::{Backend, Images, Layers, SILENT};
use drr::{Projector, ViewRequest};

use super::Study;
use super::area::Area;
use super::setting::Setting;
use crate::console::Console;

/// All runs of a setting together take no longer, unless two do, s.
const MOST_SECONDS: f64 = 20.0;

/// What is timed.
const LAYERS: Layers =
    Layers { intensity: true, line_integral: false, areal_density: false, bone_path: false };

/// One setting, measured.
pub(super) struct Measured {
    pub(super) setting: Setting,
    /// All runs, s.
    pub(super) seconds: Vec<f64>,
    /// Energies that are summed per ray.
    pub(super) energies: usize,
    /// What the planner's costs predict, s.
    pub(super) predicted: f64,
    /// Against the exact integral along the same rays, with every energy.
    pub(super) errors: Measurement,
    /// Against the mean over the pixel's area, HU, where it was measured.
    pub(super) area: Option<Estimate>,
}

/// Measures all settings; their runs take turns, so that what else the machine does meets them alike.
pub(super) fn all(
    study: &Study<'_>,
    settings: Vec<Setting>,
    truth: &Truth,
    repeat: u32,
    console: Console,
) -> Result<Vec<Measured>> {
    let bar = console.bar("measuring", settings.len() * (repeat as usize + 1));
    let area = Area::new(study)?;
    let mut all = Vec::new();
    for setting in settings {
        let projector = study.projector_of(&setting)?;
        // One energy has no fewer.
        if setting.method.energies != projector.plan().method.energies {
            continue;
        }
        let images = cast(study, &setting, truth, &projector)?;
        let energies = projector
            .plan()
            .quadrature
            .as_ref()
            .map_or(projector.plan().energy_bins, |few| few.nodes().len());
        let effort = study.effort()?;
        let predicted =
            study.setup.context.costs().seconds(&study.setup.context, setting.method, &effort, energies)
                * (setting.supersampling * setting.supersampling) as f64;
        let errors = truth.compare(&images);
        let area = area.error(study, &setting)?;
        all.push((projector, Measured { setting, seconds: Vec::new(), energies, predicted, errors, area }));
        bar.inc(1);
    }
    if study.setup.context.backend() != Backend::Cpu {
        // The first run of a kernel compiles it.
        for (projector, measured) in &all {
            time(study, &measured.setting, projector)?;
        }
    }
    for run in 0..repeat as usize {
        for (projector, measured) in &mut all {
            if run < 2 || measured.seconds.iter().sum::<f64>() < MOST_SECONDS {
                measured.seconds.push(time(study, &measured.setting, projector)?);
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(all.into_iter().map(|(_, measured)| measured).collect())
}

/// Seconds of one projection of all views, by the device's clock where it has one.
fn time(study: &Study<'_>, setting: &Setting, projector: &Projector) -> Result<f64> {
    let requests: Vec<_> = study.poses().into_iter().map(|view| request(view, setting)).collect();
    let start = Instant::now();
    std::hint::black_box(projector.project(&requests, LAYERS, SILENT)?);
    Ok(projector_times(projector).unwrap_or(start.elapsed().as_secs_f64()))
}

fn projector_times(projector: &Projector) -> Option<f64> {
    projector.timings().map(|timings| timings.kernel_seconds)
}

fn request(view: drr::geometry::View, setting: &Setting) -> ViewRequest {
    ViewRequest { early_exit: setting.early_exit, ..view.into() }
}

/// The sample's rays. An early exit shows in the intensity alone: the line integral is made of that.
fn cast(study: &Study<'_>, setting: &Setting, truth: &Truth, projector: &Projector) -> Result<Images<f64>> {
    if !setting.early_exit {
        return Ok(truth.cast(projector)?);
    }
    let scene = drr::Scene { detector: truth.sample().size(), ..study.scene.clone() };
    let projector = study.projector(scene)?;
    let views = truth.sample().views([0.0; 2]);
    let requests: Vec<_> = views.into_iter().map(|view| request(view.view, setting)).collect();
    let mut images = projector.project(&requests, LAYERS, SILENT)?.map(|&x| f64::from(x));
    let i0 = study.scene.spectral_model()?.i0();
    images.line_integral = images.intensity.iter().map(|intensity| -(intensity / i0).ln()).collect();
    Ok(images)
}
