//! What the stages of a development took.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::error::Result;

/// Seconds of each stage, in the order in which they first ran, summed over views.
#[derive(Debug, Default)]
pub struct StageTimes(Mutex<Vec<(&'static str, Duration)>>);

impl StageTimes {
    /// Runs a stage and counts its time.
    pub(crate) fn of<T>(&self, name: &'static str, stage: impl FnOnce() -> Result<T>) -> Result<T> {
        let start = Instant::now();
        let result = stage()?;
        self.add(name, start.elapsed());
        Ok(result)
    }

    /// Adds the time of a stage.
    pub(crate) fn add(&self, name: &'static str, time: Duration) {
        let mut stages = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match stages.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += time,
            None => stages.push((name, time)),
        }
    }

    /// Adds those of another development.
    pub(crate) fn add_all(&self, other: &Self) {
        for (name, seconds) in other.seconds() {
            self.add(name, Duration::from_secs_f64(seconds));
        }
    }

    /// Name and seconds of each stage.
    pub fn seconds(&self) -> Vec<(&'static str, f64)> {
        let stages = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        stages.iter().map(|(name, time)| (*name, time.as_secs_f64())).collect()
    }
}
