//! Whether a focal spot has to be simulated, and how: what it does to some rays of the expected views.

use std::sync::Arc;

use serde::Serialize;

use crate::accuracy::Estimate;
use crate::context::Context;
use crate::effects::FocalSpot;
use crate::error::Result;
use crate::exposure::{Focus, beamline, penumbra};
use crate::geometry::DetectorPose;
use crate::planner::effects::LeftOut;
use crate::planner::rays::Rays;
use crate::planner::{SHARE, expected};
use crate::scene::Scene;
use crate::tolerance::Tolerance;
use crate::volume::Volume;

/// Points along each side that others are judged by, at least.
const JUDGED_BY: usize = 4;

/// How a focal spot is simulated, and what cheaper ways would be wrong by.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FocusChoice {
    /// What was chosen.
    pub focus: Focus,
    /// The widest penumbra in the expected views, pixels along columns and rows.
    pub penumbra: [f64; 2],
    /// Points of the focal spot in those views, where all of them are simulated.
    pub points: [usize; 2],
    /// HU-equivalents that may be used up; `None` without a tolerance.
    pub allowed_hu: Option<f64>,
    /// The error of a point source and of a convolution, HU-equivalents, where they were measured.
    pub errors: Vec<(Focus, Option<Estimate>)>,
}

impl FocusChoice {
    /// A point source instead of the spot.
    pub(super) fn left_out(&self) -> LeftOut {
        let [columns, rows] = self.penumbra;
        let error =
            self.errors.iter().find(|(focus, _)| *focus == Focus::Point).and_then(|(_, error)| *error);
        LeftOut {
            name: "focal spot",
            hu: error.map_or(0.0, |error| error.rms_high),
            allowed_hu: self.allowed_hu.unwrap_or(0.0),
            what: format!(
                "penumbrae up to {columns:.2} × {rows:.2} pixels; root mean square against {0}×{0} points or more, measured on {1} rays",
                JUDGED_BY,
                error.map_or(0, |error| error.rays)
            ),
        }
    }
}

/// Chooses for a scene that has a focal spot. Without a tolerance nothing is left out.
///
/// # Errors
/// `InvalidArgument` where a view is given by a matrix, the volume is around the source, or the spot is too large.
pub(super) fn choose(
    context: &Context,
    volume: &Arc<Volume>,
    scene: &Scene,
    spot: &FocalSpot,
) -> Result<FocusChoice> {
    let views = expected::views(scene, volume);
    let mut widest = [0.0_f64; 2];
    for view in &views {
        let own = penumbra(spot, view, volume.grid())?;
        widest = [0, 1].map(|axis| widest[axis].max(own[axis]));
    }
    let mut choice = FocusChoice {
        focus: Focus::Points,
        penumbra: widest,
        points: spot.counts(widest)?,
        allowed_hu: None,
        errors: Vec::new(),
    };
    let Some(Tolerance { hu, .. }) = scene.tolerance else { return Ok(choice) };
    choice.allowed_hu = Some(SHARE * hu);
    let rays = Rays::new(context, volume, scene)?;
    let right = rays.seen_from_points(
        spot,
        choice.points.map(|count| if count > 1 { count.max(JUDGED_BY) } else { 1 }),
    )?;
    let shadow = |pose: &DetectorPose, pitch: [f64; 2]| {
        let at = beamline(pose, volume.grid());
        Ok(vec![(1.0, spot.taps(at.source_detector_mm, at.source_centre_mm, pitch)?)])
    };
    // A convolution would blur what lies before the volume as well.
    let ways =
        if scene.effects.is_even_source() { &[Focus::Point, Focus::Convolved][..] } else { &[Focus::Point] };
    for &focus in ways {
        let own = match focus {
            Focus::Convolved => rays.convolved("focal_spot", shadow)?,
            _ => rays.seen_from_centre()?,
        };
        let error = rays.hu(&own, &right);
        choice.errors.push((focus, error));
        if error.is_none_or(|error| error.rms_high <= SHARE * hu) {
            choice.focus = focus;
            break;
        }
    }
    Ok(choice)
}
