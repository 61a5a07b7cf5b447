//! `drr register`: where an object is, from cone-beam images of it and its CT.

mod pictures;
mod report;
mod target;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context as _, Result};
use clap::Args;
use clap::builder::RangedU64ValueParser;
use drr::engine::Backend;
use drr::formats::write_text;
use drr::geometry::RigidMotion;
use drr::pose_gradient::Signal;
use drr::registration::{
    CaptureOptions, CaptureRange, MAX_REGISTRATION_LEVELS, Registrar, Registration, RegistrationOptions,
    RegistrationView, TargetError,
};
use drr::volume::Volume;
use drr::{Context, Scene};

use crate::console::Console;
use crate::ct::CtArguments;
use crate::output::prepare;
use crate::physics::PhysicsArguments;
use crate::value;
use crate::views::{ViewArguments, Views};
use pictures::Pictures;
use report::Report;
use target::Target;

/// Whole numbers.
type Whole = RangedU64ValueParser<usize>;

/// Pixels a side of the coarsest level, at least.
const COARSEST: usize = 20;

#[derive(Debug, Args)]
#[command(mut_arg("size", |size| size.default_value("180x180")))]
#[command(after_help = "\
The CT has moved by x -> R (x - c) + c + t with R = R_y(beta) R_x(alpha) R_z(phi) about its centre c. Its images, of the exact
integral through spectrum and detector and with the noise of photons, are given; from no motion, Levenberg and Marquardt's
method finds all six parameters, on coarse voxels and pixels first, with analytic derivatives through the spectrum. mTRE: the
mean distance of the volume's corners after the motion found and the true one. Depth along the views' common direction is
told by their parallax alone: see its standard deviation.

Files in DIR: register.json, views.png (target, and target - projected before and after), convergence.svg, convergence.png;
with --capture-range also capture_range.svg and capture_range.png.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    ct: CtArguments,
    #[command(flatten)]
    views: ViewArguments,
    #[command(flatten)]
    physics: PhysicsArguments,
    /// Largest hidden angle, degrees
    #[arg(long, value_name = "DEGREES", value_parser = value::finite, default_value = "5", help_heading = "Motion")]
    #[arg(allow_negative_numbers = true)]
    max_degrees: f64,
    /// Largest hidden translation along x, y, z, mm
    #[arg(long, value_name = "MM", value_parser = value::finite, default_value = "10", help_heading = "Motion")]
    #[arg(allow_negative_numbers = true)]
    max_mm: f64,
    /// Photons per pixel where nothing is in the way; 0: no noise
    #[arg(long, value_name = "N", value_parser = value::finite, default_value = "1e4", help_heading = "Motion")]
    #[arg(allow_negative_numbers = true)]
    photons: f64,
    /// Decides the motion, the noise, and the starts of --capture-range
    #[arg(long, value_name = "N", default_value = "1", help_heading = "Motion")]
    seed: u64,
    /// Measured line integrals -ln(I/I0) in place of simulated ones: float32, little-endian, row by row, view after
    /// view
    #[arg(long, value_name = "FILE.f32", help_heading = "Motion")]
    #[arg(conflicts_with_all = ["max_degrees", "max_mm", "photons", "capture_range"])]
    measured: Option<PathBuf>,
    /// Levels, each with voxels and pixels twice as large as the next one's [default: up to 4, with 20 pixels a side or
    /// more]
    #[arg(long, value_name = "N", help_heading = "Method", allow_negative_numbers = true)]
    #[arg(value_parser = Whole::new().range(1..=MAX_REGISTRATION_LEVELS as u64))]
    levels: Option<usize>,
    /// From how far off the motion is found: so many random starts at each of some distances [without a value: 10]
    #[arg(long, value_name = "STARTS", num_args = 0..=1, default_missing_value = "10", help_heading = "Method")]
    #[arg(value_parser = Whole::new().range(1..=10_000), allow_negative_numbers = true)]
    capture_range: Option<usize>,
    /// Those distances: mTRE of the starts, mm
    #[arg(long, value_name = "MM,MM,...", value_delimiter = ',', value_parser = value::positive)]
    #[arg(default_value = "8,16,32,64,128", requires = "capture_range", help_heading = "Method")]
    #[arg(allow_negative_numbers = true)]
    distances: Vec<f64>,
    /// Threads; 0 is one per core
    #[arg(
        long,
        value_name = "N",
        default_value = "0",
        help_heading = "Method",
        allow_negative_numbers = true
    )]
    threads: usize,
    /// Folder for the files; it is made where it is missing
    #[arg(long, short, value_name = "DIR", default_value = "drr-register", help_heading = "Output")]
    output: PathBuf,
    /// Print the JSON instead of the table
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// What was found.
struct Found {
    registration: Registration,
    /// Of each view, without motion and with the motion found.
    images: Vec<[Vec<f32>; 2]>,
    seconds: f64,
    capture: Option<Capture>,
}

/// From how far off the motion is found.
struct Capture {
    range: CaptureRange,
    /// mTRE of a success at most, mm.
    success: f64,
    seconds: f64,
}

/// `drr register`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.json);
    let physics = arguments.physics.physics()?;
    let context = Context::new(Backend::Cpu, arguments.threads).context("--threads")?;
    let volume = context.install(|| arguments.ct.load(&physics.classification, console))?.volume;
    let volume = Arc::new(volume);
    let views = arguments.views.views(volume.grid())?;
    arguments.views.check_outside(volume.grid())?;
    prepare(&arguments.output)?;
    let scene = Scene {
        spectrum: physics.spectrum,
        materials: physics.materials,
        detector_layers: physics.detector_layers.into_iter().take(1).collect(),
        bone: physics.bone,
        ..Scene::new(views.size)?
    };
    let study = Study { arguments, context: &context, volume: &volume, scene: &scene, views: &views };
    let target = Target::new(&study, console)?;
    let found = study.register(&target, console)?;
    let error = TargetError::new(volume.grid(), volume.grid().centre());
    let name = arguments.ct.name();
    let report = Report { name: &name, views: &views, target: &target, found: &found, error: &error };
    write_text(&arguments.output.join("register.json"), &(report.to_json().to_string() + "\n"))?;
    Pictures { report: &report }.write(&arguments.output)?;
    if arguments.json {
        Console::answer(report.to_json());
    }
    if let Some(doubt) = report.doubt() {
        Console::warn(format_args!("the registration did not converge: {doubt}"));
    }
    console.say(report.table());
    console
        .say(format_args!("wrote   register.json, views and convergence in {}", arguments.output.display()));
    Ok(ExitCode::SUCCESS)
}

/// What is registered.
struct Study<'a> {
    arguments: &'a Arguments,
    context: &'a Context,
    volume: &'a Arc<Volume>,
    scene: &'a Scene,
    views: &'a Views,
}

impl Study<'_> {
    fn levels(&self) -> usize {
        let side = self.views.size[0].min(self.views.size[1]);
        self.arguments
            .levels
            .unwrap_or_else(|| (0..4).filter(|level| side >> level >= COARSEST).count().max(1))
    }

    fn register(&self, target: &Target, console: Console) -> Result<Found> {
        let start = Instant::now();
        let registrar = Registrar::new(self.context, self.volume.clone(), self.scene, self.levels());
        let registrar: Registrar<f32> = registrar.context("--levels, --materials")?;
        let views = target.views(self.views);
        let options = RegistrationOptions::default();
        let bar = console.bar("registering", registrar.levels());
        let registration = registrar.register(&views, &RigidMotion::default(), &options, &mut |level, _| {
            bar.set_position(level as u64);
            ControlFlow::Continue(())
        });
        bar.finish_and_clear();
        let views_of = || format!("the {} views", views.len());
        let registration = registration.with_context(views_of)?;
        let seconds = start.elapsed().as_secs_f64();
        let image = |view: &RegistrationView<'_, f32>, motion: &RigidMotion| {
            registrar.finest().project(&view.pose, motion, Signal::LineIntegral)
        };
        let both = |view: &RegistrationView<'_, f32>| -> drr::Result<_> {
            Ok([image(view, &RigidMotion::default())?, image(view, &registration.motion)?])
        };
        let images =
            views.iter().enumerate().map(|(n, view)| both(view).with_context(|| format!("view {n}")));
        let images = images.collect::<Result<_>>()?;
        let capture = match (self.arguments.capture_range, &target.truth) {
            (Some(starts), Some(truth)) => Some(self.capture(&registrar, &views, truth, starts, console)?),
            _ => None,
        };
        Ok(Found { registration, images, seconds, capture })
    }

    fn capture(
        &self,
        registrar: &Registrar<f32>,
        views: &[RegistrationView<'_, f32>],
        truth: &RigidMotion,
        starts: usize,
        console: Console,
    ) -> Result<Capture> {
        let start = Instant::now();
        let distances = self.arguments.distances.clone();
        let bar = console.bar("starting", distances.len() * starts);
        let options =
            CaptureOptions { distances, starts, seed: self.arguments.seed, ..CaptureOptions::default() };
        let range = registrar.capture_range(views, truth, &options, &mut |_, _, _| {
            bar.inc(1);
            ControlFlow::Continue(())
        });
        bar.finish_and_clear();
        Ok(Capture {
            range: range.context("--distances")?,
            success: options.success,
            seconds: start.elapsed().as_secs_f64(),
        })
    }
}
