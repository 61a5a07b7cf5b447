//! Effects that change too little to be simulated: how much they change.

use std::sync::Arc;

use crate::accuracy::FLOOR;
use crate::context::Context;
use crate::effects::{DetectorBlur, Effects, Scatter};
use crate::engine::{Layers, SILENT};
use crate::error::Result;
use crate::exposure::{Source, pose_of};
use crate::geometry::{DetectorPose, View};
use crate::method::Algorithm;
use crate::planner::effects::LeftOut;
use crate::planner::expected;
use crate::planner::rays::Rays;
use crate::projector::{Projector, ViewRequest};
use crate::scene::Scene;
use crate::volume::Volume;

/// Columns and rows of rays that are looked at in each view, corners included.
const LOOKED_AT: usize = 17;
/// Most views that are looked at.
const MOST_VIEWS: usize = 64;
/// Widest blur that may be left out at all, pixels: what is wider is no small change.
const MOST_BLUR: f64 = 0.5;
/// Columns and rows of the detector that scatter is judged on.
const COARSE: usize = 64;

/// What lies between source and volume, by the largest change of any energy's intensity in any pixel.
pub(super) fn source(
    volume: &Volume,
    scene: &Scene,
    part: Part,
    floor: f64,
    allowed_hu: f64,
) -> Result<Option<LeftOut>> {
    let alone = part.of(&scene.effects);
    if alone == Effects::default() {
        return Ok(None);
    }
    // p is relative to the open field, which changes as well: what a factor can do is twice its logarithm.
    let hu = 1000.0 * 2.0 * largest_logarithm(volume, scene, alone)? / floor;
    let what = "from the largest change of any energy's intensity in any pixel".to_owned();
    Ok((hu <= allowed_hu).then_some(LeftOut { name: part.name(), hu, allowed_hu, what }))
}

/// A blur that hardly leaves the pixel, measured; wider ones are not.
pub(super) fn blur(
    context: &Context,
    volume: &Arc<Volume>,
    scene: &Scene,
    blur: &DetectorBlur,
    allowed_hu: f64,
) -> Result<Option<LeftOut>> {
    let views = expected::views(scene, volume);
    let mut widest = 0.0_f64;
    for view in &views {
        let pose = pose_of(view, "scene.effects.detector_blur")?;
        let pitch = pose.column_step.length().min(pose.row_step.length());
        widest = widest.max(blur.largest_sigma_mm() / pitch);
    }
    if widest > MOST_BLUR {
        return Ok(None);
    }
    let rays = Rays::new(context, volume, scene)?;
    let kernels = |_: &DetectorPose, pitch: [f64; 2]| blur.kernels(pitch);
    let error = rays.hu(&rays.seen_from_centre()?, &rays.convolved("detector_blur", kernels)?);
    let hu = error.map_or(0.0, |error| error.rms_high);
    let what = format!(
        "σ up to {widest:.3} pixels; root mean square in the detector's first layer, measured on {} rays",
        error.map_or(0, |error| error.rays)
    );
    Ok((hu <= allowed_hu).then_some(LeftOut { name: "detector blur", hu, allowed_hu, what }))
}

/// Scatter that adds next to nothing, by its own estimate on a coarse detector.
pub(super) fn scatter(
    context: &Context,
    volume: &Arc<Volume>,
    scene: &Scene,
    scatter: Scatter,
    allowed_hu: f64,
) -> Result<Option<LeftOut>> {
    let views = expected::views(scene, volume);
    let coarse = scene.detector.map(|side| side.min(COARSE));
    let views: Vec<ViewRequest> = views
        .iter()
        .step_by(views.len().div_ceil(MOST_VIEWS).max(1))
        .map(|view| {
            Ok(View::Pose(coarser(pose_of(view, "scene.effects.scatter")?, scene.detector, coarse)).into())
        })
        .collect::<Result<_>>()?;
    let only = Layers { line_integral: true, ..Layers::default() };
    let line_integrals = |effects: Effects| -> Result<Vec<f32>> {
        let plain = scene.with_method(Algorithm::Joseph.into());
        let detector_layers = scene.detector_layers.clone();
        let scene =
            Scene { effects, detector_layers, bone: None, detector: coarse, supersampling: 1, ..plain };
        let projector = Projector::new(&context.on_cpu(), volume.clone(), scene)?;
        Ok(projector.project(&views, only, SILENT)?.line_integral)
    };
    let with = line_integrals(Effects { scatter: Some(scatter), ..Effects::default() })?;
    let without = line_integrals(Effects::default())?;
    let floor = FLOOR as f32 * without.iter().copied().filter(|p| p.is_finite()).fold(0.0, f32::max);
    let hu = with
        .iter()
        .zip(&without)
        .filter(|(_, p)| **p > floor && p.is_finite())
        .map(|(with, without)| 1000.0 * f64::from((with - without) / without).abs())
        .fold(0.0, f64::max);
    let what = "the largest change of any pixel of a coarse detector, by the estimate itself".to_owned();
    Ok((hu <= allowed_hu).then_some(LeftOut { name: "scatter", hu, allowed_hu, what }))
}

/// The same detector with fewer pixels.
fn coarser(pose: &DetectorPose, fine: [usize; 2], coarse: [usize; 2]) -> DetectorPose {
    let [columns, rows] = [0, 1].map(|axis| fine[axis] as f64 / coarse[axis] as f64);
    DetectorPose {
        first_pixel: pose.pixel(0.5 * (columns - 1.0), 0.5 * (rows - 1.0)),
        column_step: columns * pose.column_step,
        row_step: rows * pose.row_step,
        ..*pose
    }
}

/// An effect between source and volume.
#[derive(Clone, Copy)]
pub(super) enum Part {
    FallOff,
    Heel,
    Filters,
}

impl Part {
    pub(super) const ALL: [Self; 3] = [Self::FallOff, Self::Heel, Self::Filters];

    fn name(self) -> &'static str {
        match self {
            Self::FallOff => "fall-off",
            Self::Heel => "heel effect",
            Self::Filters => "filters",
        }
    }

    /// This one alone.
    fn of(self, effects: &Effects) -> Effects {
        match self {
            Self::FallOff => Effects { fall_off: effects.fall_off, ..Effects::default() },
            Self::Heel => Effects { heel: effects.heel, ..Effects::default() },
            Self::Filters => Effects { filters: effects.filters.clone(), ..Effects::default() },
        }
    }

    pub(super) fn remove(self, effects: &mut Effects) {
        match self {
            Self::FallOff => effects.fall_off = false,
            Self::Heel => effects.heel = None,
            Self::Filters => effects.filters.clear(),
        }
    }
}

/// The largest |ln(I with/I without)| of any energy with weight in the expected views.
fn largest_logarithm(volume: &Volume, scene: &Scene, effects: Effects) -> Result<f64> {
    let scene = Scene { effects, ..scene.clone() };
    let views = expected::views(&scene, volume);
    let mut largest = 0.0_f64;
    for view in views.iter().step_by(views.len().div_ceil(MOST_VIEWS).max(1)) {
        let source = Source::new(&scene, view, scene.detector)?;
        for j in 0..LOOKED_AT {
            for i in 0..LOOKED_AT {
                let at = |n: usize, side: usize| (n * (side - 1)) as f64 / (LOOKED_AT - 1) as f64;
                let (column, row) = (at(i, scene.detector[0]), at(j, scene.detector[1]));
                largest = largest.max(source.largest_logarithm(&scene, column, row));
            }
        }
    }
    Ok(largest)
}
