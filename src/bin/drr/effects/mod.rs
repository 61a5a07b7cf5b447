//! `drr effects`: what every effect costs beside the plain projection, on the user's own scene and machine.

mod case;
mod cases;
mod measured;
mod pictures;
mod report;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use drr::engine::Backend;
use drr::formats::write_text;
use drr::volume::Volume;
use drr::{Projector, Scene, ViewRequest};

use crate::console::Console;
use crate::inputs::{Inputs, Setup};
use crate::output::prepare;
use crate::views::Views;
use pictures::Pictures;
use report::Report;

#[derive(Debug, Args)]
#[command(after_help = "\
The plain scene and the same with one effect after the other, each with the parameters that the table tells, project
intensity and line integral of all views in turns, so that what else the machine does meets them alike. Effects are left
out of the plain scene: none may be given. Where a tolerance leads to a convolved focal spot, that is measured
beside a plain scene of the same tolerance.

Files in DIR: effects.json, cost.svg and cost.png (time relative to the plain projection), effects.png (what each effect
does to the first view).")]
pub(crate) struct Arguments {
    #[command(flatten)]
    inputs: Inputs,
    /// Folder for the files; it is made where it is missing
    #[arg(long, short, value_name = "DIR", default_value = "drr-effects", help_heading = "Output")]
    output: PathBuf,
    /// Runs of every scene; those that take long get fewer, but two
    #[arg(long, value_name = "N", default_value = "7", help_heading = "Output")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Show what effects.json of another engine or machine has in the same chart
    #[arg(long, value_name = "FILE.json", help_heading = "Output")]
    with: Option<PathBuf>,
    /// Print the JSON instead of the table
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// `drr effects`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.json);
    if arguments.inputs.has_effects() {
        bail!(
            "an effect or a second detector layer is given; valid: none, because effects adds one after the other"
        );
    }
    let setup = arguments.inputs.setup()?;
    if setup.context.backend() == Backend::Reference {
        bail!("--engine is reference; valid: an engine whose time matters: cpu, host, cuda, metal");
    }
    let other = arguments.with.as_deref().map(|path| Report::read(path).context("--with")).transpose()?;
    let volume = Arc::new(setup.load(console)?.volume);
    let views = setup.views(&volume)?;
    prepare(&arguments.output)?;
    let study = Study { setup: &setup, volume: &volume, views: &views, scene: setup.scene(&views) };

    let (cases, left_out) = cases::all(&study)?;
    let (measured, shown) = measured::all(&study, cases, arguments.runs, console)?;
    let report = Report::new(&study, measured, left_out);
    write_text(&arguments.output.join("effects.json"), &(report.to_json()? + "\n"))?;
    let pictures = Pictures { study: &study, report: &report, other: other.as_ref(), shown: &shown };
    pictures.write(&arguments.output)?;
    if arguments.json {
        Console::answer(report.to_json()?);
    }
    console.say(report.table());
    console
        .say(format_args!("wrote   effects.json, chart and contact sheet in {}", arguments.output.display()));
    Ok(ExitCode::SUCCESS)
}

/// What is studied.
struct Study<'a> {
    setup: &'a Setup<'a>,
    volume: &'a Arc<Volume>,
    views: &'a Views,
    /// Without effects.
    scene: Scene,
}

impl Study<'_> {
    fn projector(&self, scene: Scene) -> Result<Projector> {
        self.setup.projector_of(self.volume.clone(), scene)
    }

    fn requests(&self) -> Vec<ViewRequest> {
        self.views.requests()
    }

    /// What is projected, in words.
    fn name(&self) -> String {
        let ([n0, n1, n2], [width, height]) = (self.volume.grid().dimensions(), self.scene.detector);
        format!(
            "{}: {n0}×{n1}×{n2} voxels, {} view(s) of {width}×{height} pixels",
            self.setup.name(),
            self.views.poses.len()
        )
    }
}
