//! Analytic derivatives against central differences, at random poses of a volume.

mod kinks;
mod pose;
mod row;

use std::process::ExitCode;

use anyhow::Result;
use drr::alignment::Misalignment;
use drr::parallel::{ParallelGeometry, ParallelProjector, Quadrature, ViewParameters};
use drr::{Context, Real};
use serde_json::json;

use super::Arguments;
use super::scene::Scene;
use crate::console::Console;
use pose::{Differences, Pose};
use row::{Row, Worst};

/// Random poses.
const POSES: usize = 4;
/// How far they reach, degrees and mm.
const REACH: [f64; 2] = [30.0, 15.0];
/// Pixels a side, over the whole detector.
const PIXELS: usize = 40;
/// Relative errors that are allowed, in float64 and in float32.
const BOUNDS: [f64; 2] = [1e-7, 1e-4];

/// `drr align --check`.
pub(super) fn run(
    arguments: &Arguments,
    scene: &Scene,
    context: &Context,
    console: Console,
) -> Result<ExitCode> {
    let geometry = sparse(&scene.geometry);
    let quadratures = [Quadrature::Steps, Quadrature::Exact];
    let bar = console.bar("checking", quadratures.len() * POSES);
    let mut rows = Vec::new();
    for quadrature in quadratures {
        let twin: Vec<f64> = scene.volume.iter().map(|&value| value.into()).collect();
        let double = ParallelProjector::new(context, geometry, quadrature, &twin)?;
        let single = ParallelProjector::new(context, geometry, quadrature, &scene.volume)?;
        let mut worst = [Worst::default(); 2];
        for pose in poses(arguments.seed) {
            let pose = Pose::new(&geometry, quadrature, pose);
            let differences = Differences::new(&pose, &double)?;
            compare(&pose, &differences, &double, &mut worst[0])?;
            compare(&pose, &differences, &single, &mut worst[1])?;
            bar.inc(1);
        }
        for (worst, (precision, bound)) in worst.iter().zip(["float64", "float32"].into_iter().zip(BOUNDS)) {
            rows.extend(Row::of(worst, row::name(quadrature), precision, bound));
        }
    }
    bar.finish_and_clear();
    report(&rows, scene, arguments.to.json, console)
}

fn report(rows: &[Row], scene: &Scene, json: bool, console: Console) -> Result<ExitCode> {
    let passed = rows.iter().all(Row::passed);
    if json {
        let object =
            json!({ "version": drr::VERSION, "scene": scene.text(), "passed": passed, "rows": rows });
        Console::answer(serde_json::to_string_pretty(&object)?);
    }
    console.say(scene.text());
    console.say(format_args!(
        "{POSES} random poses, up to {PIXELS}×{PIXELS} rays each; analytic against central differences in float64"
    ));
    console.say(row::HEADING);
    for row in rows {
        console.say(row.line());
    }
    console.say(if passed { "passed" } else { "failed" });
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn compare<T: Real>(
    pose: &Pose<'_>,
    differences: &Differences,
    projector: &ParallelProjector<T>,
    worst: &mut Worst,
) -> Result<()> {
    let double = size_of::<T>() == size_of::<f64>();
    worst.image = worst.image.max(pose.image_error(differences, projector, double)?);
    let [loss, normal] = pose.loss_errors(differences, projector, double)?;
    (worst.loss, worst.normal) = (worst.loss.max(loss), worst.normal.max(normal));
    worst.rays += differences.rays(double).iter().filter(|counts| **counts).count();
    if double && !differences.kinked.is_empty() {
        let beyond = pose.beyond_kinks(differences, projector)?;
        worst.kinks = Some(worst.kinks.unwrap_or(0.0).max(beyond));
        worst.kinked += differences.kinked.len();
    }
    Ok(())
}

/// As many pixels as the check needs.
fn sparse(geometry: &ParallelGeometry) -> ParallelGeometry {
    let detector = geometry.detector.map(|n| n.min(PIXELS));
    let pixel =
        [0, 1].map(|axis| geometry.pixel[axis] * geometry.detector[axis] as f64 / detector[axis] as f64);
    ParallelGeometry { detector, pixel, ..*geometry }
}

fn poses(seed: u64) -> impl Iterator<Item = ViewParameters> {
    let reach = Misalignment { degrees: REACH[0], mm: REACH[1], seed };
    (0..POSES).map(move |n| {
        let nominal = ViewParameters { phi: n as f64 * 0.9, ..ViewParameters::default() };
        reach.applied(n, &nominal)
    })
}
