//! How much water a cylinder of 200 mm seems to have.

use anyhow::Result;
use drr::Algorithm;
use drr::phantom::{Part, Phantom, Shape};
use glam::DVec3;

use super::check::Check;
use super::stand::Stand;

const PIXELS: usize = 120;
/// HU-equivalents per relative difference.
const HU: f64 = 1000.0;
/// Shortest chord that counts, mm.
const CHORD_MM: f64 = 100.0;
/// How far rays stay away from the cylinder's ends, mm.
const MARGIN_MM: f64 = 10.0;

pub(super) fn checks(stand: &Stand) -> Result<Vec<Check>> {
    let truth = stand.closed_form(PIXELS)?;
    let shorter = shortened(&stand.phantom)?;
    let weight = |from: DVec3, to: DVec3| {
        let chord = stand.phantom.lengths(from, to)[0];
        // A ray that keeps away from the ends has the same chord in the shorter cylinder.
        let counts = chord >= CHORD_MM && (shorter.lengths(from, to)[0] - chord).abs() < 1e-9;
        counts.then_some(HU)
    };
    let check = |&algorithm| {
        let differences = stand.project(algorithm, PIXELS)?.relative_differences(&truth, weight);
        Ok(Check::hu("water cylinder", algorithm, &differences))
    };
    super::FAST.iter().chain([&Algorithm::Exact]).map(check).collect()
}

/// The same cylinder without its ends.
fn shortened(phantom: &Phantom) -> Result<Phantom> {
    let shorter = |part: &Part| match part.shape {
        Shape::Cylinder { centre, axis, radius, half_length } => {
            let half_length = half_length - MARGIN_MM;
            Part { shape: Shape::Cylinder { centre, axis, radius, half_length }, ..*part }
        }
        _ => *part,
    };
    Ok(Phantom::new("shorter cylinder", phantom.parts().iter().map(shorter).collect())?)
}
