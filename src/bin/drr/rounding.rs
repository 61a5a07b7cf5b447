//! `drr rounding`: how the error of a sum along a ray grows with its length, for each way of adding, and what each
//! costs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use drr::engine::{Backend, Layers, SILENT};
use drr::formats::write_text;
use drr::geometry::{DetectorPose, Grid, View};
use drr::physics::{Calibration, Thresholds};
use drr::volume::{Classification, Volume};
use drr::{Accumulation, Algorithm, Context, Method, Projector, Scene, ViewRequest};
use glam::DVec3;
use serde_json::json;

use crate::charts::{Curves, Drawing as _, Scale, Series};
use crate::console::Console;
use crate::output::prepare;
use crate::rms::rms;
use crate::times::median;

#[derive(Debug, Args)]
#[command(after_help = "\
Rays of 100 to 100000 samples through noise of soft tissue are summed in float32 in three ways, and in float64. The error
is that of the areal density, a root mean square over the rays. Files in DIR: rounding.json, rounding.svg, rounding.png.")]
pub(crate) struct Arguments {
    /// Folder for the files; it is made where it is missing
    #[arg(long, short, value_name = "DIR", default_value = "drr-rounding", help_heading = "Output")]
    output: PathBuf,
    /// Print the JSON instead of the table
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Samples along a ray.
const LENGTHS: [usize; 7] = [100, 320, 1000, 3200, 10_000, 32_000, 100_000];
/// Samples per voxel, so that no side of the volume needs more than 32768 of them.
const PER_VOXEL: usize = 4;
/// Voxels across, and their size, mm.
const ACROSS: usize = 12;
const VOXEL_MM: f64 = 0.5;
/// Columns and rows of rays.
const RAYS: [usize; 2] = [32, 32];
const RUNS: usize = 5;

const WAYS: [(Accumulation, &str); 3] = [
    (Accumulation::Naive, "one float32 sum"),
    (Accumulation::Blocked, "blocks of 64 in float32, blocks in float64"),
    (Accumulation::Compensated, "one compensated float32 sum"),
];

/// One way of adding at one length.
struct Row {
    samples: usize,
    way: usize,
    /// Relative, root mean square and largest.
    rms: f64,
    max: f64,
    ns_per_sample: f64,
}

/// `drr rounding`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.json);
    prepare(&arguments.output)?;
    let bar = console.bar("rounding", LENGTHS.len());
    let mut rows = Vec::new();
    for samples in LENGTHS {
        rows.extend(measure(samples)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let json = to_json(&rows);
    write_text(&arguments.output.join("rounding.json"), &(json.to_string() + "\n"))?;
    draw(&rows, &arguments.output)?;
    if arguments.json {
        Console::answer(json);
    }
    console.say(table(&rows));
    console.say(format_args!(
        "wrote   rounding.json, rounding.svg, rounding.png in {}",
        arguments.output.display()
    ));
    Ok(ExitCode::SUCCESS)
}

/// All ways at one length.
fn measure(samples: usize) -> Result<Vec<Row>> {
    let voxels = samples / PER_VOXEL;
    let volume = Arc::new(noise([voxels, ACROSS, ACROSS])?);
    let view: [ViewRequest; 1] = [View::Pose(pose(voxels)).into()];
    let context = Context::new(Backend::Cpu, 1)?;
    let algorithm = Algorithm::March { step: 1.0 / PER_VOXEL as f64 };
    let layers = Layers { areal_density: true, ..Layers::default() };
    let scene = |accumulation| -> Result<Scene> {
        Ok(Scene { method: Method { accumulation, ..algorithm.into() }, bone: None, ..Scene::new(RAYS)? })
    };
    let twin = Projector::new(&context, volume.clone(), scene(Accumulation::Blocked)?)?;
    let exact = twin.reference(algorithm, &view, layers, SILENT)?.areal_density;
    WAYS.iter()
        .enumerate()
        .map(|(way, &(accumulation, _))| {
            let projector = Projector::new(&context, volume.clone(), scene(accumulation)?)?;
            let mut times = Vec::new();
            let mut images = projector.project(&view, layers, SILENT)?;
            for _ in 0..RUNS {
                let start = Instant::now();
                images = projector.project(&view, layers, SILENT)?;
                times.push(start.elapsed().as_secs_f64());
            }
            let seen = images.areal_density.iter().zip(&exact).filter(|(_, exact)| **exact > 0.0);
            let errors: Vec<f64> = seen.map(|(own, exact)| f64::from(*own) / exact - 1.0).collect();
            let rms = rms(errors.iter().copied());
            let max = errors.iter().fold(0.0, |max: f64, e| max.max(e.abs()));
            let ns_per_sample = 1e9 * median(&times) / (samples * RAYS[0] * RAYS[1]) as f64;
            Ok(Row { samples, way, rms, max, ns_per_sample })
        })
        .collect()
}

/// Soft tissue, with the noise of a scan: one material, and no voxel of density 0.
fn noise(dimensions: [usize; 3]) -> Result<Volume> {
    let mut state = 1_u64;
    let mut hu = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 58) as i16 + 10
    };
    let grid = Grid::centred(dimensions, DVec3::splat(VOXEL_MM))?;
    let voxels: Vec<i16> = (0..grid.voxel_count()).map(|_| hu()).collect();
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT)?;
    Ok(Volume::from_int16(grid, &voxels, None, &how)?)
}

/// Nearly parallel rays along x, none of them along an axis.
fn pose(voxels: usize) -> DetectorPose {
    let half = 0.5 * VOXEL_MM * voxels as f64;
    let step = 0.4 * VOXEL_MM * ACROSS as f64 / RAYS[0] as f64;
    let corner = -0.5 * step * (RAYS[0] as f64 - 1.0) + 0.03;
    DetectorPose {
        source: DVec3::new(-20.0 * half - 10.0, 0.11, -0.07),
        first_pixel: DVec3::new(half + 1.0, corner, corner),
        column_step: step * DVec3::Y,
        row_step: step * DVec3::Z,
    }
}

fn of_way(rows: &[Row], way: usize) -> impl Iterator<Item = &Row> {
    rows.iter().filter(move |row| row.way == way)
}

fn to_json(rows: &[Row]) -> serde_json::Value {
    let row = |row: &Row| {
        json!({
            "sums": WAYS[row.way].0,
            "samples": row.samples,
            "relative_rms": row.rms,
            "relative_max": row.max,
            "ns_per_sample": row.ns_per_sample,
        })
    };
    json!({ "version": drr::VERSION, "rows": rows.iter().map(row).collect::<Vec<_>>() })
}

fn table(rows: &[Row]) -> String {
    let mut lines = vec![
        "relative error of the areal density (RMS, and largest), and time of a sample on one thread".into(),
    ];
    for (way, (_, name)) in WAYS.iter().enumerate() {
        lines.push(format!("  {name}"));
        for Row { samples, rms, max, ns_per_sample, .. } in of_way(rows, way) {
            lines.push(format!("    {samples:>7} samples   {rms:.1e}   {max:.1e}   {ns_per_sample:>6.2} ns"));
        }
    }
    lines.join("\n")
}

fn draw(rows: &[Row], folder: &Path) -> Result<()> {
    let series = |(way, (_, name)): (usize, &(Accumulation, &str))| Series {
        name: (*name).into(),
        points: of_way(rows, way).map(|row| [row.samples as f64, row.rms]).collect(),
    };
    let chart = Curves {
        title: "How rounding grows along a ray".into(),
        subtitle: format!(
            "{} rays through noise of soft tissue, against the same sum in float64",
            RAYS[0] * RAYS[1]
        ),
        x_scale: Scale::Decades,
        x_label: "samples along the ray".into(),
        y_label: "relative error of the areal density, RMS".into(),
        series: WAYS.iter().enumerate().map(series).collect(),
    };
    chart.write_svg(&folder.join("rounding.svg"))?;
    chart.write_png(&folder.join("rounding.png"))
}
