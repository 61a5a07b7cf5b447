//! `drr align`: views of a parallel beam find where they are.

mod aligned;
mod check;
mod observed;
mod pictures;
mod report;
mod scene;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, Result};
use clap::Args;
use clap::builder::RangedU64ValueParser;
use drr::Context;
use drr::alignment::MAX_LEVELS;
use drr::engine::Backend;
use drr::formats::{write_raw_f32, write_text, write_views};

use crate::console::Console;
use crate::object::ObjectArguments;
use crate::output::prepare;
use crate::value;
use observed::Observed;
use pictures::Pictures;
use report::Report;
use scene::Scene;

/// Whole numbers.
type Whole = RangedU64ValueParser<usize>;

#[derive(Debug, Args)]
#[command(after_help = "\
The beam is parallel, along the volume's second axis, y; the volume moves: R = R_y(beta) R_x(alpha) R_z(phi) about its
centre, then dx and dz. Its attenuation is that of each voxel's material and density at --kev. Views are simulated, as exact
integrals of the interpolated voxels with the noise of photons, at angles phi that are even over --arc, with errors in all
five parameters; or they are measured ones. From the nominal parameters, each is aligned to sums of two samples per voxel by
Levenberg and Marquardt's method, on coarse voxels first; pixels count by the photons that pass. The detector sees the inner
80 % of the volume's height: the ends of a CT are cut.

Files in DIR: aligned.csv (parameters and standard deviations; --views reads it), align.json, views.png (measured views, and
what is left of them before and after), convergence.svg and convergence.png.

--check holds the analytic derivatives of image, loss and JtJ, at random poses of the volume, against central differences in
float64: relative to the largest, 1e-7 in float64 and 1e-4 in float32. Rays of which a sample crosses a face of a voxel within
a difference have a kink there, and must lie between its sides. Exit code 1 when a row fails.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    object: ObjectArguments,
    /// Most voxels a side: means of blocks of the CT's voxels
    #[arg(long, value_name = "N", default_value = "256", help_heading = "Volume")]
    #[arg(value_parser = Whole::new().range(8..=4096), allow_negative_numbers = true)]
    voxels: usize,
    /// Number of simulated views
    #[arg(long, value_name = "N", default_value = "8", help_heading = "Views")]
    #[arg(value_parser = Whole::new().range(1..=10_000), allow_negative_numbers = true)]
    count: usize,
    /// What the views' angles phi go round, degrees; 0: all views are at 0
    #[arg(long, value_name = "DEGREES", value_parser = value::finite, default_value = "180", help_heading = "Views")]
    #[arg(allow_negative_numbers = true)]
    arc: f64,
    /// Largest errors of simulated angles, degrees
    #[arg(long, value_name = "DEGREES", value_parser = value::finite, default_value = "3", help_heading = "Views")]
    #[arg(allow_negative_numbers = true)]
    max_degrees: f64,
    /// Largest errors of simulated translations, mm
    #[arg(long, value_name = "MM", value_parser = value::finite, default_value = "5", help_heading = "Views")]
    #[arg(allow_negative_numbers = true)]
    max_mm: f64,
    /// Photons per pixel where nothing is in the way; 0: no noise
    #[arg(long, value_name = "N", value_parser = value::finite, default_value = "1e5", help_heading = "Views")]
    #[arg(allow_negative_numbers = true)]
    photons: f64,
    /// Decides the errors and the noise, or the poses of --check
    #[arg(long, value_name = "N", default_value = "1", help_heading = "Views")]
    seed: u64,
    /// Measured line integrals, float32, little-endian, rows of +z one after the other, view after view
    #[arg(long, value_name = "FILE.f32", requires = "views", help_heading = "Views")]
    #[arg(conflicts_with_all = ["count", "arc", "max_degrees", "max_mm", "photons", "seed", "raw"])]
    measured: Option<PathBuf>,
    /// Their nominal parameters: columns alpha_degrees,beta_degrees,phi_degrees,dx_mm,dz_mm
    #[arg(long, value_name = "FILE.csv", requires = "measured", help_heading = "Views")]
    views: Option<PathBuf>,
    /// Columns and rows of pixels [default: what covers the volume's width, and 80 % of its height]
    #[arg(long, value_name = "WxH", value_parser = value::size, allow_hyphen_values = true, help_heading = "Views")]
    size: Option<[usize; 2]>,
    /// Distance of pixel centres, mm [default: 256 columns on the volume's width]
    #[arg(long, value_name = "MM", value_parser = value::positive, allow_negative_numbers = true, help_heading = "Views")]
    pixel: Option<f64>,
    /// Levels, each with voxels twice as large as the next one's [default: up to 3, with 24 voxels and pixels a side or
    /// more]
    #[arg(long, value_name = "N", help_heading = "Method", allow_negative_numbers = true)]
    #[arg(value_parser = Whole::new().range(1..=MAX_LEVELS as u64))]
    levels: Option<usize>,
    /// All pixels count alike, instead of by the photons that pass: exp(-p)
    #[arg(long, help_heading = "Method")]
    uniform: bool,
    /// Threads; 0 is one per core
    #[arg(
        long,
        value_name = "N",
        default_value = "0",
        help_heading = "Method",
        allow_negative_numbers = true
    )]
    threads: usize,
    /// Hold the derivatives against differences instead
    #[arg(long, conflicts_with_all = ["measured", "views", "raw"], help_heading = "Method")]
    check: bool,
    #[command(flatten)]
    to: Destination,
}

/// Where results go.
#[derive(Debug, Args)]
struct Destination {
    /// Folder for the files; it is made where it is missing
    #[arg(long, short, value_name = "DIR", default_value = "drr-align", help_heading = "Output")]
    output: PathBuf,
    /// Write the simulated views too: measured.f32 and nominal.csv, for --measured and --views
    #[arg(long, help_heading = "Output")]
    raw: bool,
    /// Print the JSON instead of the table
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// `drr align`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.to.json);
    let context = Context::new(Backend::Cpu, arguments.threads).context("--threads")?;
    let scene = Scene::new(arguments, &context, console)?;
    if arguments.check {
        return check::run(arguments, &scene, &context, console);
    }
    prepare(&arguments.to.output)?;
    let views = observed::observed(arguments, &scene, &context, console)?;
    if arguments.to.raw {
        write_simulated(&arguments.to.output, &views)?;
    }
    let levels = arguments.levels.unwrap_or_else(|| aligned::levels(&scene));
    let aligned = aligned::align(&scene, &views, levels, arguments.uniform, &context, console)?;
    let photons = (arguments.measured.is_none() && arguments.photons > 0.0).then_some(arguments.photons);
    let report = Report::new(scene.text(), photons, levels, &views, &aligned);
    write_text(&arguments.to.output.join("align.json"), &(report.to_json()? + "\n"))?;
    write_text(&arguments.to.output.join("aligned.csv"), &report.csv())?;
    Pictures { scene: &scene, views: &views, aligned: &aligned }.write(&arguments.to.output)?;
    if arguments.to.json {
        Console::answer(report.to_json()?);
    }
    if let Some(doubts) = report.doubts() {
        Console::warn(doubts);
    }
    console.say(report.table());
    console.say(format_args!(
        "wrote   aligned.csv, align.json, views and convergence in {}",
        arguments.to.output.display()
    ));
    Ok(ExitCode::SUCCESS)
}

/// Images and nominal parameters, as `--measured` and `--views` read them.
fn write_simulated(folder: &Path, views: &[Observed]) -> Result<()> {
    let images: Vec<f32> = views.iter().flat_map(|view| view.image.iter().copied()).collect();
    write_raw_f32(&folder.join("measured.f32"), &images)?;
    let nominal: Vec<_> = views.iter().map(|view| view.nominal).collect();
    Ok(write_views(&folder.join("nominal.csv"), &nominal)?)
}
