//! From a scene to its plan: where the scene states a tolerance, the cheapest method that is measured to keep it.

mod cache;
mod candidates;
mod choice;
mod costs;
mod effects;
mod effort;
mod expected;
mod focal_spot;
mod judge;
mod negligible;
mod predicted;
mod rays;
mod reach;
mod stage_rate;
#[cfg(test)]
mod tests;

pub(crate) use cache::Cache;
pub use candidates::candidates;
pub use choice::{Candidate, Choice, Verdict};
pub use costs::{Costs, Rates, Timed};
pub(crate) use effects::Decision;
pub use effects::LeftOut;
pub use effort::Effort;
pub use focal_spot::FocusChoice;
pub use reach::Reach;
pub use stage_rate::StageRate;

use std::sync::Arc;

use crate::accuracy::Sample;
use crate::context::Context;
use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::method::{Algorithm, Energies, FEW_ENERGIES_RANGE, Method};
use crate::plan::Plan;
use crate::planner::judge::Judge;
use crate::projector::Projector;
use crate::scene::Scene;
use crate::tolerance::Tolerance;
use crate::volume::Volume;

/// Rays that are cast to see what they reach, about.
const RAYS: usize = 2000;

/// Decides which.
const SEED: u64 = 1;

/// The part of a tolerance that the sum over energies may use up.
const ENERGIES_SHARE: f64 = 0.05;

/// The part of a tolerance that effects may use up that are simplified or left out.
const SHARE: f64 = 0.1;

/// The plan of a scene on a context's engine; from the context's cache where the same has been planned before.
///
/// # Errors
/// As [`Projector::new`](crate::Projector::new).
pub(crate) fn plan(context: &Context, volume: &Arc<Volume>, scene: &Scene) -> Result<Plan> {
    let engine = context.backend();
    // What is wrong with scene, volume or engine is told before any ray is cast.
    scene.validate()?;
    context.look_into(volume)?;
    let method = if scene.tolerance.is_some() { Algorithm::Joseph.into() } else { scene.method };
    let plain = Plan::new(&Scene { method, ..scene.clone() }, volume, engine, None)?;
    // Effects are made of every energy.
    let few = scene.method.energies != Energies::All && engine != Backend::Reference && !scene.has_effects();
    if scene.tolerance.is_none() && !few && scene.effects.focal_spot.is_none() {
        return Ok(predicted::with_seconds(plain, context, volume, scene));
    }
    if engine == Backend::Reference && scene.tolerance.is_some() {
        return Err(Error::Unsupported(
            "the engine reference takes no tolerance: its algorithm exact has no error".into(),
        ));
    }
    context.plans().get_or_make(volume, scene, || {
        let plan = match scene.tolerance {
            Some(tolerance) => cheapest(context, volume, scene, tolerance)?,
            None if few => {
                let sample = Sample::new(&expected::views(scene, volume), scene.detector, RAYS, SEED);
                let reach = Reach::of_rays(context, volume, scene, &sample)?;
                Plan::new(scene, volume, engine, reach.quadrature(scene)?)?
            }
            None => plain,
        };
        let floor = plan.choice.as_ref().map(|choice| choice.floor);
        let plan = plan.with_effects(effects::decide(context, volume, scene, floor)?, scene, volume);
        Ok(predicted::with_seconds(plan, context, volume, scene))
    })
}

/// The first candidate, by predicted time, that keeps the tolerance on the sample's rays with the stated confidence.
fn cheapest(context: &Context, volume: &Arc<Volume>, scene: &Scene, tolerance: Tolerance) -> Result<Plan> {
    // What effects may use up is not the method's.
    let share = if scene.has_effects() { 1.0 - SHARE } else { 1.0 };
    let tolerance = Tolerance { hu: share * tolerance.hu, ..tolerance };
    let judge = Judge::new(context, volume, scene)?;
    let few = Energies::Few { hu: (ENERGIES_SHARE * tolerance.hu).max(FEW_ENERGIES_RANGE[0]) };
    let with = |method: Method| scene.with_method(method);
    // Effects are made of every energy.
    let quadrature = if scene.has_effects() {
        None
    } else {
        judge.reach().quadrature(&with(Method { energies: few, ..scene.method }))?
    };
    let energies = if quadrature.is_some() { few } else { Energies::All };
    let cpu = context.on_cpu();
    let mut choice = Choice::new(context, volume, scene, tolerance, energies, &judge, quadrature.as_ref())?;
    if judge.sees_nothing() {
        choice.take_unmeasured(Algorithm::Joseph);
    }
    for candidate in &mut choice.candidates {
        if judge.sees_nothing() {
            break;
        }
        // Engines keep float32's bound against the same algorithm in float64, so that the CPU's speaks for all.
        let scene = with(candidate.method);
        let plan = Plan::new(&scene, volume, Backend::Cpu, quadrature.clone())?;
        let projector = Projector::planned(&cpu, volume.clone(), scene, plan)?;
        if candidate.judge(judge.measure(&projector)?, tolerance) {
            break;
        }
    }
    let scene = Scene { method: choice.method()?, tolerance: None, ..scene.clone() };
    let plan = Plan::new(&scene, volume, context.backend(), quadrature)?;
    Ok(Plan { choice: Some(choice), ..plan })
}
