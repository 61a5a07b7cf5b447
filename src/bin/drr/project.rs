//! `drr project`, and `drr` alone.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use drr::engine::{Backend, Layers};
use drr::geometry::View;
use drr::planner::Effort;
use drr::{Projector, ViewRequest};

use crate::certificate;
use crate::console::Console;
use crate::inputs::Inputs;
use crate::output::{LayerName, Output, Rendered, layers, prepare};
use crate::value::{prefixed, seconds};

/// Where files go unless the user says otherwise.
const DEFAULT_FOLDER: &str = "drr-output";

#[derive(Debug, Args)]
#[command(after_help = "\
Files in DIR, N counting views from 0: viewN.exr (float32 layers; geometry, physics and method as attributes),
radiograph.png (the first 6 images side by side, bone bright, head up), plan.json; with --raw also viewN_LAYER.f32 and
viewN_areal_density_MATERIAL.f32 (little-endian, row by row, pixel (i,j) at j*width + i), or .f64, not rounded, with
--engine reference. Of a detector with two layers intensity and line integral are intensity.LAYER, line_integral.LAYER
(raw: viewN_intensity_LAYER.f32), and both are in the picture. A file appears under its name only when it is complete.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    inputs: Inputs,
    /// Folder for the files; it is made where it is missing
    #[arg(long, short, value_name = "DIR", default_value = DEFAULT_FOLDER, help_heading = "Output")]
    output: PathBuf,
    /// Layers of the images
    #[arg(long, value_enum, value_name = "A,B,...", value_delimiter = ',', help_heading = "Output")]
    #[arg(default_value = "intensity,line_integral")]
    layers: Vec<LayerName>,
    /// Write every layer of every view also as a raw array
    #[arg(long, help_heading = "Output")]
    raw: bool,
    /// Do not cast rays again in float64 to measure the error
    #[arg(long, help_heading = "Output")]
    no_check: bool,
}

/// `drr project`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let setup = arguments.inputs.setup()?;
    if setup.physics.bone.is_none() && arguments.layers.contains(&LayerName::BonePath) {
        bail!("--layers: bone_path needs a material that is bone: one with \"bone\" in its name, or label 3");
    }
    let loaded = setup.load(console)?;
    let loading = (loaded.reading + loaded.classifying).as_secs_f64();
    let volume = Arc::new(loaded.volume);
    let views = setup.views(&volume)?;
    let projector = setup.projector(volume, &views)?;
    prepare(&arguments.output)?;
    console.say(format_args!("{}: {}", arguments.inputs.ct.name(), projector.plan().to_string().trim_end()));

    let requests = views.requests();
    // The picture is made of line integrals, also when no file has them.
    let wanted = Layers { line_integral: true, ..layers(&arguments.layers) };
    let start = Instant::now();
    let (rendered, stages) = render(&projector, setup.context.backend(), &requests, wanted, console)?;
    let projecting = start.elapsed().as_secs_f64();
    let poses: Vec<View> = requests.iter().map(|request| request.view).collect();
    let effort = Effort::new(&poses, projector.volume().grid(), projector.scene())?;
    // Each point of a focal spot has rays of its own.
    let rays = projector.rays(&requests) as f64;
    let samples = effort.samples(projector.plan().method.algorithm) * rays / effort.rays;
    console.say(format_args!(
        "time    loaded in {}, {} view(s) projected in {} by {} on {} with {} thread(s): {}rays/s, {}samples/s",
        seconds(loading),
        views.poses.len(),
        seconds(projecting),
        projector.plan().method,
        setup.context.backend().name(),
        setup.context.threads(),
        prefixed(rays / projecting),
        prefixed(samples / projecting),
    ));
    if !stages.is_empty() {
        let stages: Vec<_> = stages.iter().map(|(name, s)| format!("{name} {}", seconds(*s))).collect();
        console.say(format_args!("        of which {}", stages.join(", ")));
    }
    if samples == 0.0 {
        Console::warn("no ray meets the volume: are --origin, --sad, --sdd or --geometry as they should be?");
    }
    let mut layers = arguments.layers.clone();
    let mut seen = Vec::new();
    layers.retain(|layer| {
        !seen.contains(layer) && {
            seen.push(*layer);
            true
        }
    });
    let layers = &layers;
    let output = Output { setup: &setup, projector: &projector, views: &views, layers, rendered: &rendered };
    output.write(&arguments.output, arguments.raw)?;
    if !arguments.no_check && !console.is_quiet() {
        let certificate = projector.certify(&poses)?;
        console.say(certificate::lines(&certificate, projector.plan()));
        let allowed = projector.scene().tolerance.map_or(f64::INFINITY, |tolerance| tolerance.hu);
        if let Some(hu) = certificate.total.hu.filter(|hu| hu.rms > allowed) {
            Console::warn(format_args!(
                "{:.3} HU are more than the {allowed} that are allowed: on these rays, others than the method was chosen by",
                hu.rms
            ));
        }
    }
    console.say(format_args!("wrote   {}", contents(&arguments.output, views.poses.len())));
    Ok(ExitCode::SUCCESS)
}

/// `drr` alone: every layer of two views of the CT that the command carries.
pub(crate) fn main_job(console: Console) -> Result<ExitCode> {
    let layers = LayerName::value_variants().to_vec();
    let output = DEFAULT_FOLDER.into();
    run(&Arguments { inputs: Inputs::default(), output, layers, raw: false, no_check: false }, console)
}

/// The images, and what the stages of a scene with effects took.
fn render(
    projector: &Projector,
    backend: Backend,
    views: &[ViewRequest],
    layers: Layers,
    console: Console,
) -> Result<(Rendered, Vec<(&'static str, f64)>)> {
    let bar = console.bar("projecting", projector.rays(views));
    let progress = |rays: usize| {
        bar.inc(rays as u64);
        ControlFlow::Continue(())
    };
    let rendered = if backend == Backend::Reference {
        let algorithm = projector.plan().method.algorithm;
        (Rendered::Double(projector.reference(algorithm, views, layers, &progress)?), Vec::new())
    } else {
        let (images, times) = projector.project_timed(views, layers, &progress)?;
        (Rendered::Single(images), times.seconds())
    };
    bar.finish_and_clear();
    Ok(rendered)
}

fn contents(folder: &Path, views: usize) -> String {
    let images = if views == 1 { "view0.exr".into() } else { format!("view0 ... view{}.exr", views - 1) };
    format!("{images}, radiograph.png, plan.json in {}", folder.display())
}
