//! `drr validate`: measured errors against closed forms.

mod check;
mod cylinder;
mod rods;
mod spheres;
mod stand;

use std::process::ExitCode;

use anyhow::{Context as _, Result};
use clap::Args;
use drr::Algorithm;
use drr::phantom::Phantom;
use serde_json::json;

use crate::console::Console;
use crate::value;
use stand::Stand;

/// The specification's volume: 0.5 mm voxels.
const FULL: [usize; 3] = [720, 720, 665];
/// The algorithms of the fast engine.
const FAST: [Algorithm; 3] = [Algorithm::Joseph, Algorithm::March { step: 0.5 }, Algorithm::Siddon];

#[derive(Debug, Args)]
#[command(after_help = "\
Two views at -6 and +6 degrees, 720x720 pixels of 0.9 mm (120x120 of 5.4 mm for the water cylinder), source 1000 mm from the axis and 1500 mm from the detector,
120 kVp with all its energies; phantoms as voxels of partial volume, with labels, density linear in HU.

  rods             centroid of each rod's shadow, row by row, against the projection of its axis; mm across the rod in
                   the plane of the isocentre; at most 0.2 mm RMSE is required, 0.02 aimed at
  sphere centres   centroid of each ball's shadow against that of the closed form on the same pixels; as rods
  water cylinder   200 mm of water: 1000 (p - p_ref)/p_ref over rays with a chord of at least 100 mm that stay 10 mm
                   away from the ends; at most 2 HU RMSE is required, 0.5 aimed at
  water ball       the same for chords of at least 30 mm of a ball of 40 mm, as a length of water: at most 0.2 mm RMSE,
                   which is 2 HU of 100 mm

Exit code 1 when a requirement is not met. The requirements are for voxels of 0.5 mm (--full); much coarser ones than the
default's 0.75 mm fail, siddon first.")]
pub(crate) struct Arguments {
    /// Voxels along x, y, z over 360 x 360 x 332.5 mm
    #[arg(long, value_name = "NX,NY,NZ", value_parser = value::dimensions, default_value = "480,480,443")]
    #[arg(conflicts_with = "full")]
    size: [usize; 3],
    /// The specification's 720,720,665 voxels of 0.5 mm
    #[arg(long)]
    full: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Threads; 0 is one per core
    #[arg(long, value_name = "N", default_value = "0")]
    threads: usize,
}

/// `drr validate`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.json);
    let size = if arguments.full { FULL } else { arguments.size };
    let voxel = Phantom::water_cylinder().grid(size).context("--size")?.smallest_spacing();
    let stand = |phantom| Stand::new(phantom, size, arguments.threads, console);
    // One volume at a time.
    let mut checks = rods::checks(&stand(Phantom::rods())?)?;
    checks.extend(cylinder::checks(&stand(Phantom::water_cylinder())?)?);
    checks.extend(spheres::checks(&stand(Phantom::spheres())?)?);
    let passed = checks.iter().all(check::Check::passes);
    if arguments.json {
        let report = json!({ "passed": passed, "version": drr::VERSION, "volume": size, "checks": checks });
        Console::answer(report);
    } else {
        let [n0, n1, n2] = size;
        console.say(format_args!("{n0}×{n1}×{n2} voxels, smallest spacing {voxel:.3} mm"));
        console.say(check::HEADING);
        for check in &checks {
            console.say(check);
        }
        console.say(if passed { "every requirement is met" } else { "a requirement is not met" });
    }
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
