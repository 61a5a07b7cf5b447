//! `drr tradeoff`: what accuracy costs in time, on the user's own scene and machine.

mod area;
mod measured;
mod pictures;
mod report;
mod setting;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use drr::accuracy::{Sample, Truth};
use drr::engine::Backend;
use drr::formats::write_text;
use drr::geometry::View;
use drr::planner::{Choice, Costs, Effort, Rates, Timed};
use drr::volume::Volume;
use drr::{Algorithm, Context, Method, Projector, Scene, Tolerance};

use crate::console::Console;
use crate::inputs::{Inputs, Setup};
use crate::output::prepare;
use crate::times::median;
use crate::views::Views;
use measured::Measured;
use pictures::Pictures;
use report::Report;
use setting::Setting;

/// Rays that errors are measured on, about.
const RAYS: usize = 3000;
/// Decides which; not the planner's and not the certificate's.
const SEED: u64 = 3;

#[derive(Debug, Args)]
#[command(after_help = "\
Every method that the engine has is timed on all views (intensity only) and measured on a sample of their rays against the
exact integral of the interpolated voxels with every energy, in float64. Of Siddon, which takes voxels as constant, and of
distance_driven, which also takes the mean over the pixel, the difference of model is measured. The chosen method is the planner's for --preset or --tolerance-hu [default: standard].

Files in DIR: tradeoff.json, tradeoff.svg, tradeoff.png (error against time), error_chosen.png, error_joseph.png and
error_siddon.png (signed errors of the chosen method, of Joseph's rule and of Siddon's lengths).")]
pub(crate) struct Arguments {
    #[command(flatten)]
    inputs: Inputs,
    /// Folder for the files; it is made where it is missing
    #[arg(long, short, value_name = "DIR", default_value = "drr-tradeoff", help_heading = "Output")]
    output: PathBuf,
    /// Runs of every method; methods that take long get fewer, but two
    #[arg(long, value_name = "N", default_value = "7", help_heading = "Output")]
    #[arg(value_parser = clap::value_parser!(u32).range(2..))]
    repeat: u32,
    /// Write what methods cost on this machine, for --timings
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    write_timings: Option<PathBuf>,
    /// Print the JSON instead of the table
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// `drr tradeoff`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.json);
    let setup = arguments.inputs.setup()?;
    let engine = setup.context.backend();
    if engine == Backend::Reference {
        bail!("--engine is reference; valid: an engine that has something to trade: cpu, host, cuda, metal");
    }
    if setup.method != Algorithm::Joseph.into() {
        bail!("a method is given; valid: none, because tradeoff measures them all");
    }
    if arguments.inputs.supersampling() > 1 {
        bail!(
            "--supersample is given; valid: none, because tradeoff measures one, 2x2 and 3x3 rays per pixel"
        );
    }
    if arguments.inputs.has_effects() {
        bail!(
            "an effect or a second detector layer is given; valid: none, because tradeoff measures the rays; drr effects \
             measures effects"
        );
    }
    let volume = Arc::new(setup.load(console)?.volume);
    let views = setup.views(&volume)?;
    prepare(&arguments.output)?;
    let scene = Scene { tolerance: None, ..setup.scene(&views) };
    let tolerance = setup.scene(&views).tolerance.unwrap_or(Tolerance::STANDARD);
    let study = Study { setup: &setup, volume: &volume, views: &views, scene, tolerance };

    let (choice, planning_seconds) = study.choose()?;
    let truth = study.truth()?;
    let measured = study.measure(&choice, &truth, arguments.repeat, console)?;
    let report = Report::new(&study, measured, choice, planning_seconds);
    write_text(&arguments.output.join("tradeoff.json"), &(report.to_json().to_string() + "\n"))?;
    Pictures { study: &study, report: &report, folder: &arguments.output }.write(console)?;
    if let Some(path) = &arguments.write_timings {
        write_text(path, &(study.costs(&report.measured)?.to_json() + "\n")).context("--write-timings")?;
    }
    if arguments.json {
        Console::answer(report.to_json());
    }
    console.say(report.table());
    console
        .say(format_args!("wrote   tradeoff.json, chart and error maps in {}", arguments.output.display()));
    Ok(ExitCode::SUCCESS)
}

/// What is studied.
struct Study<'a> {
    setup: &'a Setup<'a>,
    volume: &'a Arc<Volume>,
    views: &'a Views,
    /// Without a tolerance.
    scene: Scene,
    tolerance: Tolerance,
}

impl Study<'_> {
    /// What the planner makes of the tolerance, and how long it takes.
    fn choose(&self) -> Result<(Choice, f64)> {
        let scene = Scene { tolerance: Some(self.tolerance), ..self.scene.clone() };
        let start = Instant::now();
        let projector = self.projector(scene)?;
        let seconds = start.elapsed().as_secs_f64();
        let choice = projector.plan().choice.clone().context("a tolerance leads to a choice")?;
        Ok((choice, seconds))
    }

    fn projector(&self, scene: Scene) -> Result<Projector> {
        self.setup.projector_of(self.volume.clone(), scene)
    }

    /// Of a setting on the whole detector.
    fn projector_of(&self, setting: &Setting) -> Result<Projector> {
        let (method, supersampling) = (setting.method, setting.supersampling);
        self.projector(Scene { method, supersampling, ..self.scene.clone() })
    }

    fn poses(&self) -> Vec<View> {
        self.views.poses.iter().map(|&pose| View::Pose(pose)).collect()
    }

    fn truth(&self) -> Result<Truth> {
        let sample = Sample::new(&self.poses(), self.scene.detector, RAYS, SEED);
        Ok(Truth::new(&self.setup.context, self.volume, &self.scene, sample)?)
    }

    fn effort(&self) -> Result<Effort> {
        Ok(Effort::new(&self.poses(), self.volume.grid(), &self.scene)?)
    }

    /// Every setting, the chosen one included.
    fn measure(
        &self,
        choice: &Choice,
        truth: &Truth,
        repeat: u32,
        console: Console,
    ) -> Result<Vec<Measured>> {
        let mut settings = Setting::all(self.setup.context.backend());
        let chosen = choice.chosen().map(|candidate| candidate.method);
        if let Some(method) = chosen.filter(|method| settings.iter().all(|s| s.method != *method)) {
            settings.push(Setting::of(method));
        }
        measured::all(self, settings, truth, repeat, console)
    }

    /// Rates fitted to the measured times.
    fn costs(&self, measured: &[Measured]) -> Result<Costs> {
        let context = &self.setup.context;
        let engine = context.backend();
        let one_ray = measured.iter().filter(|m| m.setting.supersampling == 1 && !m.setting.early_exit);
        let times: Vec<_> = one_ray
            .map(|m| Timed {
                method: m.setting.method,
                energies: m.energies,
                seconds: median(&m.seconds) * context.work_threads() as f64,
            })
            .collect();
        let built_in = Costs::default();
        let like =
            built_in.rates(engine).or(built_in.rates(Backend::Cpu)).context("there are built-in rates")?;
        Ok(Costs::new(machine(context), engine, Rates::fitted(&times, &self.effort()?, like)))
    }

    /// Whether a method is the chosen one.
    fn is_chosen(choice: &Choice, setting: &Setting) -> bool {
        let chosen = choice.chosen().map(|candidate| candidate.method);
        setting.supersampling == 1 && !setting.early_exit && chosen == Some(setting.method)
    }
}

/// What the engine runs on, in words.
pub(crate) fn machine(context: &Context) -> String {
    match context.device_name().to_string_lossy() {
        device if device.is_empty() => format!("{} thread(s) of this machine", context.threads()),
        device => device.into_owned(),
    }
}

/// Joseph's rule with nothing else given up.
fn joseph() -> Method {
    Algorithm::Joseph.into()
}
