//! From how far off the motion is found.

use std::ops::ControlFlow;

use crate::effects::RowRandom;
use crate::error::{Error, Result};
use crate::geometry::RigidMotion;
use crate::real::Real;
use crate::registration::levels::{Registrar, RegistrationView};
use crate::registration::register::RegistrationOptions;
use crate::registration::target_error::TargetError;

/// The part of starts that must succeed (van de Kraats et al., IEEE TMI 24(9), 1177, 2005, §II-D).
const REQUIRED: f64 = 0.95;

/// Most distances, and most starts at one.
const MOST_STARTS: usize = 1 << 20;

/// Keeps the starts apart from the noise of the same seed: detectors have layers 0 and 1.
const STARTS: usize = 2;

/// Which starts are tried.
#[derive(Debug, Clone, PartialEq)]
pub struct CaptureOptions {
    /// Mean target registration errors of the starts, mm, ascending.
    pub distances: Vec<f64>,
    /// Starts at each distance.
    pub starts: usize,
    /// The largest mean target registration error of a success, mm.
    pub success: f64,
    /// Other seeds give other starts.
    pub seed: u64,
    /// How each is registered.
    pub registration: RegistrationOptions,
}

impl Default for CaptureOptions {
    /// 1 to 64 mm, 20 starts each; a success is within 2 mm, as in van de Kraats et al.
    fn default() -> Self {
        Self {
            distances: vec![1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0],
            starts: 20,
            success: 2.0,
            seed: 1,
            registration: RegistrationOptions::default(),
        }
    }
}

/// What became of the starts at one distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaptureRow {
    /// Mean target registration error of the starts, mm.
    pub distance: f64,
    /// Number of starts.
    pub starts: usize,
    /// How many of them ended within the limit.
    pub successes: usize,
    /// The median of what was left, mm, of all starts; ∞ where half of them cannot be registered.
    pub median_error: f64,
    /// The largest that was left where there was success, mm; 0 where there was none.
    pub largest_success: f64,
}

/// A table of starts by distance.
#[derive(Debug, Clone, PartialEq)]
pub struct CaptureRange {
    /// By distance, ascending.
    pub rows: Vec<CaptureRow>,
}

impl CaptureRange {
    /// The capture range, mm: the largest distance up to which at least 95 % of the starts at each distance succeed; 0 where
    /// they do not at the first.
    pub fn distance(&self) -> f64 {
        let captured = |row: &&CaptureRow| row.successes as f64 >= REQUIRED * row.starts as f64;
        self.rows.iter().take_while(captured).last().map_or(0.0, |row| row.distance)
    }
}

impl CaptureOptions {
    /// # Errors
    /// `InvalidArgument` with the field that is not valid.
    pub fn validate(&self) -> Result<()> {
        if self.distances.is_empty() || self.distances.len() > MOST_STARTS {
            return Err(Error::invalid(
                "distances",
                self.distances.len(),
                format!("1 … {MOST_STARTS} of them"),
            ));
        }
        let mut before = 0.0;
        for (k, &distance) in self.distances.iter().enumerate() {
            if !(distance > before && distance <= 1e6) {
                return Err(Error::invalid(
                    format!("distances[{k}]"),
                    distance,
                    "ascending, above 0, up to 1e6 mm",
                ));
            }
            before = distance;
        }
        if self.starts == 0 || self.starts > MOST_STARTS {
            return Err(Error::invalid("starts", self.starts, format!("1 … {MOST_STARTS}")));
        }
        if !(self.success > 0.0) {
            return Err(Error::invalid("success", self.success, "above 0 mm"));
        }
        Ok(())
    }
}

impl<T: Real> Registrar<T> {
    /// Registers views of an object whose motion is `truth` from random starts at growing distance. A start differs from the
    /// truth by three angles and three translations that are equally likely within a box, all scaled so that the mean target
    /// registration error, at the volume's corners, is the distance; translations weigh as much as angles at the corners. The
    /// same starts on every machine. `report` gets each distance's index, the start's, and what was left, mm, ∞ where a start
    /// cannot be registered; where it breaks, the error is `Cancelled`.
    ///
    /// # Errors
    /// As [`Registrar::register`]; `InvalidArgument` for options that are not valid; `Cancelled`.
    pub fn capture_range(
        &self,
        views: &[RegistrationView<'_, T>],
        truth: &RigidMotion,
        options: &CaptureOptions,
        report: &mut dyn FnMut(usize, usize, f64) -> ControlFlow<()>,
    ) -> Result<CaptureRange> {
        options.validate()?;
        truth.validate().map_err(|error| error.of("truth"))?;
        options.registration.levels.coarse.validate()?;
        options.registration.levels.fine.validate()?;
        self.views(views, options.registration.signal)?;
        let target = TargetError::new(self.finest().volume().grid(), self.finest().pivot());
        let mut rows = Vec::with_capacity(options.distances.len());
        for (d, &distance) in options.distances.iter().enumerate() {
            let mut errors = Vec::with_capacity(options.starts);
            for n in 0..options.starts {
                let mut random = RowRandom::new(options.seed, d, STARTS, n);
                let start = start(truth, &target, distance, [random.draws(), random.draws()]);
                let silent = &mut |_: usize, _: &_| ControlFlow::Continue(());
                let left = match self.register(views, &start, &options.registration, silent) {
                    Ok(found) => target.between(truth, &found.motion),
                    // Views and settings are valid: from this start there is no way.
                    Err(Error::InvalidArgument { .. }) => f64::INFINITY,
                    Err(error) => return Err(error),
                };
                errors.push(left);
                if report(d, n, left).is_break() {
                    return Err(Error::Cancelled);
                }
            }
            rows.push(CaptureRow::new(distance, options.success, errors));
        }
        Ok(CaptureRange { rows })
    }
}

impl CaptureRow {
    fn new(distance: f64, success: f64, mut errors: Vec<f64>) -> Self {
        errors.sort_by(f64::total_cmp);
        let successes = errors.partition_point(|&error| error <= success);
        Self {
            distance,
            starts: errors.len(),
            successes,
            median_error: errors[errors.len() / 2],
            largest_success: errors[..successes].last().copied().unwrap_or(0.0),
        }
    }
}

/// The motion at this mean target registration error from `truth` towards which uniform numbers in (0, 1) point.
fn start(truth: &RigidMotion, target: &TargetError, distance: f64, uniform: [[f64; 3]; 2]) -> RigidMotion {
    let [turn, shift] = uniform.map(|draws| draws.map(|u| 2.0 * u - 1.0));
    let away = |scale: f64| {
        let mut moved = *truth;
        for axis in 0..3 {
            moved.angles[axis] += scale * turn[axis] / target.radius();
            moved.translation[axis] += scale * shift[axis];
        }
        moved
    };
    // Nearly proportional to the scale: a few corrections are enough; far turns, whose chords shrink, get what they reach.
    let mut scale = distance;
    for _ in 0..20 {
        scale *= (distance / target.between(truth, &away(scale))).clamp(0.5, 2.0);
    }
    away(scale)
}

#[cfg(test)]
mod tests;
