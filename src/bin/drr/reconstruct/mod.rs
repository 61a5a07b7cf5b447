//! `drr reconstruct`: a volume from its views, iteratively.

mod acquisition;
mod joint;
mod measured;
mod method;
mod pictures;
mod report;
mod slices;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context as _, Result};
use clap::Args;
use drr::Context;
use drr::engine::Backend;
use drr::formats::{write_raw_f32, write_text};
use drr::geometry::Grid;

use crate::console::Console;
use crate::line_integrals::photon_noise;
use crate::object::{Attenuation, ObjectArguments};
use crate::output::prepare;
use crate::value;
use acquisition::{BeamName, Distances, Geometry, simulate};
use joint::JointArguments;
use measured::MeasuredArguments;
use method::MethodArguments;
use report::Report;

#[derive(Debug, Args)]
#[command(after_help = "\
A CT or phantom becomes attenuation at --kev; its views are simulated from its own voxels, 2×2 rays per pixel and four samples
per voxel, with the noise of photons. What is reconstructed are voxels at least as large, the truth being their means: neither
the voxels nor the algorithm are those that made the data. Views of one's own come from --measured.

Files in DIR: reconstruction.nii.gz (HU at --kev: 0 is water, -1000 vacuum), reconstruction.png (truth, first iteration,
result and error in three slices), convergence.svg, convergence.png, reconstruct.json; of simulated views projections.f32 and
views.csv or geometry.json, which --measured, --views and --geometry take.

--joint hides errors in the views, and finds all five parameters of each together with the volume: two rounds in which each
view is shifted by Levenberg and Marquardt's method, then joint steps of Gauss and Newton in volume and views. A motion that
all views have in common cannot be seen; errors are those after the best one. The picture has reconstructions with the views
as they were thought to be, as they were found (aligned.csv) and as they are; the chart has the errors of each round.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    object: ObjectArguments,
    /// Most voxels along a side of what is reconstructed; each is the mean of a block of the CT's
    #[arg(long, value_name = "N", default_value = "96", value_parser = voxels, help_heading = "Volume")]
    voxels: usize,
    #[command(flatten)]
    views: ViewArguments,
    #[command(flatten)]
    measured: MeasuredArguments,
    #[command(flatten)]
    method: MethodArguments,
    #[command(flatten)]
    joint: JointArguments,
    /// Threads; 0 is one per core
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        default_value = "0",
        help_heading = "Method"
    )]
    threads: usize,
    /// Folder for the files; it is made where it is missing
    #[arg(long, short, value_name = "DIR", default_value = "drr-reconstruct", help_heading = "Output")]
    output: PathBuf,
    /// Print the JSON instead of the table
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Voxels of vacuum around an object whose views are aligned with it: a CT's ends are cut, and smoothing moves them
/// out.
const JOINT_MARGIN: usize = 4;

/// A phantom's voxels a side to each that is reconstructed.
const VOXELS: usize = 2;

/// Views that are simulated.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Simulated views")]
struct ViewArguments {
    /// How rays run
    #[arg(long, value_enum, default_value = "parallel")]
    beam: BeamName,
    /// Number of views
    #[arg(long, value_name = "N", default_value = "60", value_parser = views, allow_negative_numbers = true)]
    count: usize,
    /// Distance from the source of a cone beam to the axis of rotation, mm
    #[arg(long, value_name = "MM", value_parser = value::positive, allow_negative_numbers = true, default_value = "1000")]
    sad: f64,
    /// Distance from the source of a cone beam to the detector, mm
    #[arg(long, value_name = "MM", value_parser = value::positive, allow_negative_numbers = true, default_value = "1500")]
    sdd: f64,
    /// Photons per pixel where nothing is in the way; 0: no noise
    #[arg(long, value_name = "N", value_parser = value::finite, allow_negative_numbers = true, default_value = "1e5")]
    photons: f64,
    /// Decides the noise, and hidden errors
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
}

fn views(text: &str) -> Result<usize, String> {
    within(text, 2, 10_000)
}

fn voxels(text: &str) -> Result<usize, String> {
    within(text, 4, 1024)
}

fn within(text: &str, least: usize, most: usize) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (least..=most).contains(&n) => Ok(n),
        _ => Err(format!("expected a whole number, {least} to {most}")),
    }
}

/// Line integrals, and where they are thought to be from.
#[derive(Clone)]
pub(super) struct Scan {
    pub(super) name: String,
    pub(super) geometry: Geometry,
    /// Where they are from, if that is elsewhere.
    pub(super) hidden: Option<Geometry>,
    /// Of what is reconstructed.
    pub(super) grid: Grid,
    /// `(view*rows + row)*columns + column`.
    pub(super) data: Vec<f32>,
    /// On that grid, where it is known.
    pub(super) truth: Option<Attenuation>,
    /// The X-rays' energy, keV.
    pub(super) kev: f64,
    /// Linear attenuation coefficient of water, 1/mm.
    pub(super) water: f64,
    /// Loading and simulating, s.
    pub(super) seconds: f64,
}

/// `drr reconstruct`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.json);
    arguments.method.validate(arguments.is_parallel())?;
    arguments.joint.validate(arguments.is_parallel())?;
    let context = Context::new(Backend::Cpu, arguments.threads).context("--threads")?;
    prepare(&arguments.output)?;
    let scan = arguments.scan(&context, console)?;
    console.say(format_args!("{}: {}", scan.name, scan.describe()));
    let (json, table) = if arguments.joint.joint {
        let joint = arguments.joint.solve(&context, &scan, &arguments.method, console)?;
        let report = joint::Report { scan: &scan, method: &arguments.method, joint: &joint };
        report.write(&arguments.output)?;
        (report.to_json(), report.table())
    } else {
        let found = arguments.method.reconstruct(&context, &scan, console)?;
        let report = Report { scan: &scan, method: &arguments.method, found: &found };
        report.write(&arguments.output)?;
        (report.to_json(), report.table())
    };
    write_text(&arguments.output.join("reconstruct.json"), &(json.to_string() + "\n"))?;
    if arguments.json {
        Console::answer(json);
    }
    console.say(table);
    console.say(format_args!(
        "wrote   reconstruction.nii.gz, reconstruction.png, convergence.svg, convergence.png, reconstruct.json in {}",
        arguments.output.display()
    ));
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    fn is_parallel(&self) -> bool {
        self.measured.is_parallel().unwrap_or(self.views.beam == BeamName::Parallel)
    }

    /// What is reconstructed from; simulated views are written beside the result.
    fn scan(&self, context: &Context, console: Console) -> Result<Scan> {
        if let Some(scan) = self.measured.scan(&self.object)? {
            return Ok(scan);
        }
        let start = Instant::now();
        // What moves, and is smoothed, stays inside.
        let margin = if self.joint.joint { JOINT_MARGIN } else { 0 };
        let object = context.install(|| self.object.load(self.voxels, VOXELS, console))?;
        let truth = object.means(self.voxels, margin)?;
        let grid = truth.grid;
        let ViewArguments { beam, count, sad, sdd, photons, seed } = self.views;
        let geometry = Geometry::around(&grid, beam, count, Distances { sad, sdd })?;
        let noise = photon_noise(photons, seed)?;
        let hidden = self.joint.joint.then(|| self.joint.hidden(&geometry, seed)).transpose()?;
        let views = hidden.as_ref().unwrap_or(&geometry);
        let data = simulate(context, &object, self.object.kev, (views, &grid), noise, console)?;
        write_raw_f32(&self.output.join("projections.f32"), &data)?;
        geometry.write(&self.output)?;
        let seconds = start.elapsed().as_secs_f64();
        let (name, kev, water) = (self.object.name(), self.object.kev, self.object.water()?);
        Ok(Scan { name, geometry, hidden, grid, data, truth: Some(truth), kev, water, seconds })
    }
}

impl Scan {
    /// In words.
    pub(super) fn describe(&self) -> String {
        let [n0, n1, n2] = self.grid.dimensions();
        format!("{n0}×{n1}×{n2} voxels from {}", self.geometry.describe())
    }

    /// Attenuation in HU at its energy: 0 is water, −1000 vacuum.
    pub(super) fn hu(&self, attenuation: &[f32]) -> Vec<f32> {
        attenuation.iter().map(|&value| (1000.0 * (f64::from(value) / self.water - 1.0)) as f32).collect()
    }
}
