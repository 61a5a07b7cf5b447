//! From a scene to its plan: where the scene states a tolerance, the cheapest method that is measured to keep it.

mod cache;
mod candidates;
mod choice;
mod costs;
mod effort;
mod expected;

pub(crate) use cache::Cache;
pub use candidates::candidates;
pub use choice::{Candidate, Choice, Verdict};
pub use costs::{Costs, Rates, Timed};
pub use effort::Effort;

use std::sync::Arc;

use crate::accuracy::{Sample, Truth};
use crate::error::Result;
use crate::method::{Energies, Method};
use crate::physics::Quadrature;
use crate::plan::Plan;
use crate::projector::{Context, Projector};
use crate::scene::Scene;
use crate::tolerance::Tolerance;
use crate::volume::Volume;

/// Rays that candidates are judged by, about.
const RAYS: usize = 1500;

/// Decides which.
const SEED: u64 = 1;

/// The part of a tolerance that the sum over energies may use up.
const ENERGIES_SHARE: f64 = 0.05;

/// Areal densities of rays that were not looked at may be larger than of those that were. Beyond this factor all
/// energies are summed.
const REACH: f64 = 1.25;

/// The plan of a scene on a context's engine; from the context's cache where the same has been planned before.
///
/// # Errors
/// As [`Projector::new`](crate::Projector::new).
pub(crate) fn plan(context: &Context, volume: &Arc<Volume>, scene: &Scene) -> Result<Plan> {
    let measured = scene.tolerance.is_some() || scene.method.energies != Energies::All;
    if !measured {
        return Plan::new(scene, volume, context.backend());
    }
    // What is wrong with scene, volume or engine is told before any ray is cast.
    Plan::new(scene, volume, context.backend())?;
    context.plans().get_or_make(volume, scene, || {
        let expected = expected::views(scene, volume);
        let sample = Sample::new(&expected, scene.detector, RAYS, SEED);
        let truth = Truth::new(context, volume, scene, sample)?;
        if let Some(tolerance) = scene.tolerance {
            return cheapest(context, volume, scene, tolerance, &truth);
        }
        let quadrature = quadrature(scene, scene.method.energies, &truth)?;
        of_method(context, volume, scene, scene.method, quadrature)
    })
}

/// The plan of a given method.
fn of_method(
    context: &Context,
    volume: &Volume,
    scene: &Scene,
    method: Method,
    quadrature: Option<Quadrature>,
) -> Result<Plan> {
    Ok(Plan { quadrature, ..Plan::new(&scene.with_method(method), volume, context.backend())? })
}

fn quadrature(scene: &Scene, energies: Energies, truth: &Truth) -> Result<Option<Quadrature>> {
    let Energies::Few { hu } = energies else { return Ok(None) };
    let limits: Vec<f64> = truth.reach().iter().map(|most| REACH * most).collect();
    Ok(Quadrature::new(&scene.spectral_model()?, &limits, truth.floor(), 1e-3 * hu))
}

/// The first candidate, by predicted time, that keeps the tolerance on the sample's rays with the stated confidence.
fn cheapest(
    context: &Context,
    volume: &Arc<Volume>,
    scene: &Scene,
    tolerance: Tolerance,
    truth: &Truth,
) -> Result<Plan> {
    let few = Energies::Few { hu: ENERGIES_SHARE * tolerance.hu };
    let quadrature = quadrature(scene, few, truth)?;
    let energies = if quadrature.is_some() { few } else { Energies::All };
    let cpu = context.on_cpu();
    let mut choice = Choice::new(context, volume, scene, tolerance, energies, truth, quadrature.as_ref())?;
    for candidate in &mut choice.candidates {
        // Engines keep float32's bound against the same algorithm in float64, so that the CPU's speaks for all.
        let plan = of_method(&cpu, volume, scene, candidate.method, quadrature.clone())?;
        let projector = Projector::planned(&cpu, volume.clone(), scene.with_method(candidate.method), plan)?;
        if candidate.judge(&truth.compare(&truth.cast(&projector)?), tolerance) {
            break;
        }
    }
    let method = choice.chosen()?.method;
    let plan = of_method(context, volume, scene, method, quadrature)?;
    Ok(Plan { choice: Some(choice), ..plan })
}
