//! `drr project`, and `drr` alone.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use drr::engine::{Backend, Layers};
use drr::geometry::View;
use drr::planner::Effort;
use drr::{Projector, ViewRequest};

use crate::batch::{Batch, Shard};
use crate::certificate;
use crate::console::Console;
use crate::inputs::{Inputs, Setup};
use crate::output::{LayerName, Output, Rendered, layers, prepare};
use crate::value::{prefixed, seconds};
use crate::views::Views;

/// Where files go unless the user says otherwise.
const DEFAULT_FOLDER: &str = "drr-output";

#[derive(Debug, Args)]
#[command(after_help = format!("{FILES}\n--views, for any number of views: drr project --help."))]
#[command(after_long_help = format!("{FILES}\n\n{BATCH}"))]
pub(crate) struct Arguments {
    #[command(flatten)]
    inputs: Inputs,
    /// Make part I of N of the rows of --views: row k, from 0, is in part (k mod N) + 1
    #[arg(long, value_name = "I/N", requires = "views", help_heading = "Views")]
    shard: Option<Shard>,
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

    let poses: Vec<View> = views.poses.iter().map(|&pose| View::Pose(pose)).collect();
    let effort = Effort::new(&poses, projector.volume().grid(), projector.scene())?;
    let output = Output::new(&setup, &projector, &arguments.output, &arguments.layers, arguments.raw);
    let job = Job { setup: &setup, projector: &projector, views: &views, output: &output };
    let layers = layers(&arguments.layers);
    let wrote = if arguments.inputs.views.is_table() {
        let shard = arguments.shard.unwrap_or(Shard::WHOLE);
        Batch { job, shard, layers }.run(loading, console)?
    } else {
        job.run(layers, &effort, loading, console)?
    };
    if effort.slices == 0.0 {
        Console::warn(
            "no ray meets the volume: are --origin, --sad, --sdd, --views or --geometry as they should be?",
        );
    }
    if !arguments.no_check && !console.is_quiet() {
        certify(&projector, &poses, console)?;
    }
    console.say(format_args!("wrote   {wrote} in {}", arguments.output.display()));
    Ok(ExitCode::SUCCESS)
}

/// `drr` alone: every layer of two views of the CT that the command carries.
pub(crate) fn main_job(console: Console) -> Result<ExitCode> {
    let layers = LayerName::value_variants().to_vec();
    let (inputs, output) = (Inputs::default(), DEFAULT_FOLDER.into());
    run(&Arguments { inputs, shard: None, output, layers, raw: false, no_check: false }, console)
}

/// What is projected, and where to.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) setup: &'a Setup<'a>,
    pub(crate) projector: &'a Projector,
    pub(crate) views: &'a Views,
    pub(crate) output: &'a Output<'a>,
}

impl Job<'_> {
    /// Projects all views together and writes them, with a picture. What was written, in words.
    fn run(self, layers: Layers, effort: &Effort, loading: f64, console: Console) -> Result<String> {
        let Self { setup, projector, views, output } = self;
        let requests = views.requests();
        // The picture is made of line integrals, also when no file has them.
        let wanted = Layers { line_integral: true, ..layers };
        let start = Instant::now();
        let (rendered, stages) = self.render(&requests, wanted, console)?;
        let projecting = start.elapsed().as_secs_f64();
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
        let named: Vec<_> = (0..views.poses.len()).map(|view| views.named(view)).collect();
        for (place, view) in named.iter().enumerate() {
            output.write_view(view, &rendered, place)?;
        }
        output.write_picture(views, &rendered.images)?;
        output.write_plan()?;
        let first = &named[0].name;
        Ok(match &named[1..] {
            [] => format!("{first}.exr, radiograph.png, plan.json"),
            [.., last] => format!("{first} ... {}.exr, radiograph.png, plan.json", last.name),
        })
    }

    /// The images, and what the stages of a scene with effects took.
    fn render(
        self,
        views: &[ViewRequest],
        layers: Layers,
        console: Console,
    ) -> Result<(Rendered, Vec<(&'static str, f64)>)> {
        let projector = self.projector;
        let bar = console.bar("projecting", projector.rays(views));
        let progress = |rays: usize| {
            bar.inc(rays as u64);
            ControlFlow::Continue(())
        };
        let rendered = if self.setup.context.backend() == Backend::Reference {
            let algorithm = projector.plan().method.algorithm;
            (projector.reference(algorithm, views, layers, &progress)?.into(), Vec::new())
        } else {
            let (images, times) = projector.project_timed(views, layers, &progress)?;
            (images.into(), times.seconds())
        };
        bar.finish_and_clear();
        Ok(rendered)
    }
}

/// Measures the error on some rays of some views, and says it.
fn certify(projector: &Projector, poses: &[View], console: Console) -> Result<()> {
    let certificate = projector.certify(poses)?;
    console.say(certificate::lines(&certificate, projector.plan()));
    let allowed = projector.scene().tolerance.map_or(f64::INFINITY, |tolerance| tolerance.hu);
    if let Some(hu) = certificate.total.hu.filter(|hu| hu.rms > allowed) {
        Console::warn(format_args!(
            "{:.3} HU are more than the {allowed} that are allowed: on these rays, others than the method was chosen by",
            hu.rms
        ));
    }
    Ok(())
}

/// What is written.
const FILES: &str = "\
Files in DIR, N counting views from 0: viewN.exr (float32 layers; geometry, physics and method as attributes),
radiograph.png (the first 6 images side by side, bone bright, head up), plan.json; with --raw also viewN_LAYER.f32 and
viewN_areal_density_MATERIAL.f32 (little-endian, row by row, pixel (i,j) at j*width + i), or .f64, not rounded, with
--engine reference. Of a detector with two layers intensity and line integral are intensity.LAYER, line_integral.LAYER
(raw: viewN_intensity_LAYER.f32), and both are in the picture. A file appears under its name only when it is complete.";

/// Many views; tests/command/batch.rs runs the example.
const BATCH: &str = "\
Many views: --views FILE.csv has one per row, for example

  name,angle_degrees,sad_mm,offset_z_mm
  case1_a,-6,1000,0
  case1_b,6.5,1010,-12.5

They are projected and written a few at a time, so that memory does not grow with their number: NAME.exr, or
view000000.exr, view000001.exr, ... without a column name; plan.json; made_of.json; no picture. Row k, counted from 0,
has the bytes of a call of its own with the same pose and --first-view k: noise follows from the seed and this number,
whatever else is made beside it. What --tolerance-hu, --preset, --few-energies and --focal-spot decide is decided for
all rows, in every shard.

A run that was stopped goes on where it was: views that are there are not made again. A file that was made of another
CT, scene, method or pose than its row asks for is not replaced, but an error; so is a folder whose made_of.json, which
the first process writes, says something else. Several processes may fill one folder, each with its shard of the rows:

  # Two processes on one machine
  drr project --ct chest.nii --views views.csv --output out --threads 8 --shard 1/2 &
  drr project --ct chest.nii --views views.csv --output out --threads 8 --shard 2/2 &
  wait

  # GNU parallel
  seq 8 | parallel drr project --ct chest.nii --views views.csv --output out --shard {}/8

  # Slurm: a script, and a folder that all machines see
  #SBATCH --array=1-50
  drr project --ct chest.nii --views views.csv --output out --shard $SLURM_ARRAY_TASK_ID/50

For Ray and others a shard is a task; one that failed is started again. --shard K/N, with N the number of rows, makes
row K-1 alone. Bytes are the same for any number of threads; processors of different kinds may round differently.";
