//! Which of a scene's effects have to be simulated.

use std::sync::Arc;

use serde::Serialize;

use crate::context::Context;
use crate::effects::Effects;
use crate::error::Result;
use crate::exposure::Focus;
use crate::planner::SHARE;
use crate::planner::focal_spot::{self, FocusChoice};
use crate::planner::negligible::{self, Part};
use crate::scene::Scene;
use crate::volume::Volume;

/// An effect that is not simulated, because it changes too little.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// The effect.
    pub name: &'static str,
    /// What leaving it out does, at most, in HU-equivalents of the line integral.
    pub hu: f64,
    /// What was allowed, HU-equivalents.
    pub allowed_hu: f64,
    /// What the bound is of, in words.
    pub what: String,
}

/// What of a scene's effects is simulated.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Decision {
    pub(crate) effects: Effects,
    pub(crate) focus: Option<FocusChoice>,
    pub(crate) left_out: Vec<LeftOut>,
}

/// Decides; `floor` is the line integral above which errors count, where a tolerance was planned. Without a tolerance all of
/// them are simulated.
pub(super) fn decide(
    context: &Context,
    volume: &Arc<Volume>,
    scene: &Scene,
    floor: Option<f64>,
) -> Result<Decision> {
    let mut decision = Decision { effects: scene.effects.clone(), ..Decision::default() };
    if let Some(spot) = &scene.effects.focal_spot {
        let choice = focal_spot::choose(context, volume, scene, spot)?;
        if choice.focus == Focus::Point {
            decision.effects.focal_spot = None;
            decision.left_out.push(choice.left_out());
        }
        decision.focus = Some(choice);
    }
    let (Some(tolerance), Some(floor)) = (scene.tolerance, floor.filter(|floor| *floor > 0.0)) else {
        return Ok(decision);
    };
    // What is left out adds up.
    let used: f64 = decision.left_out.iter().map(|left| left.hu).sum();
    let mut allowed_hu = (SHARE * tolerance.hu - used).max(0.0);
    if let Some(blur) = &scene.effects.detector_blur
        && let Some(left) = negligible::blur(context, volume, scene, blur, allowed_hu)?
    {
        decision.effects.detector_blur = None;
        allowed_hu -= left.hu;
        decision.left_out.push(left);
    }
    if let Some(scatter) = scene.effects.scatter
        && let Some(left) = negligible::scatter(context, volume, scene, scatter, allowed_hu)?
    {
        decision.effects.scatter = None;
        allowed_hu -= left.hu;
        decision.left_out.push(left);
    }
    for part in Part::ALL {
        if let Some(left) = negligible::source(volume, scene, part, floor, allowed_hu)? {
            part.remove(&mut decision.effects);
            allowed_hu -= left.hu;
            decision.left_out.push(left);
        }
    }
    Ok(decision)
}
