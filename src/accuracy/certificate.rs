//! What can be said of a projector's error on given views.

use serde::Serialize;

use crate::accuracy::{CONFIDENCE, Estimate, Measurement, Sample, Truth};
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::projector::Projector;

/// Rays that a certificate looks at, about.
const RAYS: usize = 6000;

/// Decides which; another one than the planner's, so that a plan is not judged by the rays that it was chosen by.
const SEED: u64 = 2;

/// The measured error of a projector on some views: rays of theirs, cast again in float64 and integrated exactly.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Certificate {
    /// Rays that were cast again.
    pub rays: usize,
    /// The p above which relative errors are taken: a twentieth of the largest.
    pub floor: f64,
    /// The confidence that is aimed at: that root mean squares over all rays are below `rms_high`.
    pub confidence: f64,
    /// In all: against the exact integral of the interpolated voxels with every energy.
    pub total: Measurement,
    /// Against the same algorithm in float64 with every energy, HU: rounding, and what few energies and voxels of one byte
    /// give up.
    pub rounding: Option<Estimate>,
}

impl Certificate {
    /// Measures a projector on `views`. Where a pixel is several rays, single rays are looked at.
    ///
    /// # Errors
    /// As [`Projector::project`]; `Unsupported` for voxels in a texture.
    pub(crate) fn new(projector: &Projector, views: &[View]) -> Result<Self> {
        if views.is_empty() {
            return Err(Error::invalid("views", "empty", "at least one view"));
        }
        let sample = Sample::new(views, projector.scene().detector, RAYS, SEED);
        let truth = Truth::new(projector.context(), projector.volume(), projector.scene(), sample)?;
        let images = truth.cast(projector)?;
        let total = truth.compare(&images);
        let rounding = truth.hu(&images, &truth.cast_twin(projector)?);
        Ok(Self {
            rays: truth.sample().rays(),
            floor: truth.floor(),
            confidence: CONFIDENCE,
            total,
            rounding,
        })
    }
}
