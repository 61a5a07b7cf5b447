//! `drr bench`.

mod gpu;
mod parallel;
mod scaling;
mod times;
mod variants;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use drr::engine::{Layers, SILENT};
use drr::geometry::View;
use drr::planner::Effort;
use drr::volume::{Volume, Voxels};
use rayon::prelude::*;
use serde_json::json;

use crate::bench::gpu::Gpu;
use crate::bench::times::Times;
use crate::bench::variants::Variants;
use crate::console::Console;
use crate::inputs::{Inputs, Setup};
use crate::memory;
use crate::value::{self, prefixed};

#[derive(Debug, Args)]
#[command(after_help = "\
The line integral and the intensity of all views are projected, with the volume resident and without writing files. The
read pass sums the voxels' bytes on all threads: no projector that reads every voxel once can be faster. One run of
every stage comes first and is not counted. On a GPU the kernel's time is by the GPU's clock, of at least 50 runs; copies
of a buffer of the volume's size, made between them, take the read pass's place.

Files in DIR: scaling.json, scaling.svg and scaling.png (four charts: time against threads, pixels and voxels
per side, and views, with what would be in proportion to the work). It projects a thorax of its own: of the other options
those of physics and method, --repeat, --output and --json count.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    inputs: Inputs,
    /// Runs of every stage
    #[arg(long, value_name = "N", default_value = "7", help_heading = "Output")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// Time the parallel beam and its derivatives instead: N³ voxels of its own, N² pixels, N steps (256 without N); of
    /// the other options --engine, --device, --threads, --repeat and --json count
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "256", help_heading = "Volume")]
    #[arg(value_parser = clap::value_parser!(u32).range(2..=1024))]
    parallel: Option<u32>,
    /// Time how the projection grows instead, with threads, pixels and voxels per side, and views: up to 8 to 1024 voxels, 8
    /// to 4096 pixels, 1 to 1024 views (720,1440,32 without numbers)
    ///
    /// A quarter of the sides, and one view, are held while something else grows.
    #[arg(long, value_name = "VOXELS,PIXELS,VIEWS", num_args = 0..=1, default_missing_value = "720,1440,32")]
    #[arg(value_parser = value::growth, conflicts_with = "parallel", help_heading = "Volume")]
    scaling: Option<[usize; 3]>,
    /// Folder for the files of --scaling; it is made where it is missing
    #[arg(
        long,
        short,
        value_name = "DIR",
        default_value = "drr-scaling",
        requires = "scaling",
        help_heading = "Output"
    )]
    output: PathBuf,
    /// Print one JSON object: median_seconds and times (s, the projection of all views), peak_bytes, stages, gpu, ...
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// `drr bench`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.json);
    let setup = arguments.inputs.setup()?;
    let runs = arguments.repeat;
    if let Some(n) = arguments.parallel {
        return parallel::run(&setup.context, (n as usize, runs), arguments.json, console);
    }
    if let Some(most) = arguments.scaling {
        return scaling::run(&setup, most, (runs, &arguments.output), arguments.json, console);
    }
    let (volume, load, classify) = load(&setup, runs, console)?;
    let views = setup.views(&volume)?;
    let requests = views.requests();

    let mut create = Times::new("projector creation");
    let mut projector = setup.projector(volume.clone(), &views)?;
    for _ in 0..runs {
        let start = Instant::now();
        projector = setup.projector(volume.clone(), &views)?;
        create.all.push(start.elapsed().as_secs_f64());
    }
    let layers = Layers { intensity: true, line_integral: true, ..Layers::default() };
    let mut project = Times::new("projection");
    let mut read = Times::new("read pass");
    let mut gpu = Gpu::of(&projector);
    let runs = if gpu.is_some() { runs.max(gpu::RUNS) } else { runs };
    let bar = console.bar("projecting", runs as usize + 1);
    for run in 0..=runs {
        let start = Instant::now();
        std::hint::black_box(projector.project(&requests, layers, SILENT)?);
        let projected = start.elapsed().as_secs_f64();
        let start = Instant::now();
        if gpu.is_none() {
            std::hint::black_box(setup.context.install(|| read_pass(&volume)));
        }
        if run > 0 {
            project.all.push(projected);
            match &mut gpu {
                Some(gpu) => gpu.note(&projector)?,
                None => read.all.push(start.elapsed().as_secs_f64()),
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let Some(gpu) = &mut gpu {
        gpu.variants = Some(Variants::measure(&setup, &projector, &requests)?);
    }

    let poses: Vec<View> = requests.iter().map(|request| request.view).collect();
    let effort = Effort::new(&poses, volume.grid(), projector.scene())?;
    let samples = effort.samples(projector.plan().method.algorithm);
    let mut stages = vec![&load, &classify, &create, &project];
    stages.extend(gpu.is_none().then_some(&read));
    let median = project.median();
    let ratio = gpu.is_none().then(|| median / read.median());
    if arguments.json {
        let stages: serde_json::Map<_, _> =
            stages.iter().map(|times| (times.name.replace(' ', "_"), times.to_json())).collect();
        let report = json!({
            "median_seconds": median,
            "times": project.all,
            "peak_bytes": memory::peak_bytes(),
            "engine": setup.context.backend().name(),
            "algorithm": projector.plan().method.to_string(),
            "threads": setup.context.threads(),
            "version": drr::VERSION,
            "volume": volume.grid().dimensions(),
            "volume_bytes": volume.bytes(),
            "detector": views.size,
            "views": requests.len(),
            "supersampling": projector.scene().supersampling,
            "stages": stages,
            "rays_per_second": effort.rays / median,
            "samples_per_second": samples / median,
            "ratio_to_read_pass": ratio,
            "gpu": gpu.map(|gpu| gpu.to_json(&setup.context, samples)),
        });
        Console::answer(report);
        return Ok(ExitCode::SUCCESS);
    }
    let [n0, n1, n2] = volume.grid().dimensions();
    let [width, height] = views.size;
    console.say(format_args!("{}: {n0}×{n1}×{n2} voxels, {} view(s) of {width}×{height} pixels, {} on {} with {} thread(s), {runs} runs",
        arguments.inputs.ct.name(), requests.len(), projector.plan().method,
        setup.context.backend().name(), setup.context.threads()));
    for times in stages {
        times.say(console);
    }
    console.say(format_args!(
        "  throughput           {}rays/s, {}samples/s{}",
        prefixed(effort.rays / median),
        prefixed(samples / median),
        ratio.map_or(String::new(), |ratio| format!("; {ratio:.1} times the read pass")),
    ));
    if let Some(gpu) = &gpu {
        gpu.say(&setup.context, samples, console);
    }
    let bytes = |n: f64| format!("{}B", prefixed(n));
    let peak = memory::peak_bytes().map_or("unknown".into(), |n| bytes(n as f64));
    console.say(format_args!("  memory               peak {peak}, volume {}", bytes(volume.bytes() as f64)));
    Ok(ExitCode::SUCCESS)
}

/// Loads again and again; never holds two volumes.
fn load(setup: &Setup<'_>, runs: u32, console: Console) -> Result<(Arc<Volume>, Times, Times)> {
    let (mut load, mut classify) = (Times::new("load"), Times::new("classification"));
    let mut volume = setup.load(console)?.volume;
    for _ in 0..runs {
        drop(volume);
        let loaded = setup.load(console.without_text(true))?;
        load.all.push(loaded.reading.as_secs_f64());
        classify.all.push(loaded.classifying.as_secs_f64());
        volume = loaded.volume;
    }
    Ok((Arc::new(volume), load, classify))
}

/// Voxels of one parallel piece of work.
const PIECE: usize = 1 << 18;

/// Reads every voxel once.
fn read_pass(volume: &Volume) -> u64 {
    match volume.voxels() {
        Voxels::Coded { codes, .. } => {
            codes.par_chunks(PIECE).map(|piece| piece.iter().map(|&code| u64::from(code)).sum::<u64>()).sum()
        }
        Voxels::Dense { density, label } => {
            let bits = |piece: &[f32]| piece.iter().map(|&value| u64::from(value.to_bits())).sum::<u64>();
            let labels = |piece: &[u8]| piece.iter().map(|&value| u64::from(value)).sum::<u64>();
            density.par_chunks(PIECE).map(bits).sum::<u64>()
                + label.par_chunks(PIECE).map(labels).sum::<u64>()
        }
        Voxels::Texture { .. } => unreachable!("no command reads a texture"),
    }
}
