//! What casts the rays of an exposure.

use crate::engine::reference::Reference;
use crate::engine::{Engine, Images, Job, Passed, SignalsJob};
use crate::error::Result;

/// An engine, for exposures of numbers of one type.
pub(crate) trait RayCaster<T>: Sync {
    /// Areal densities and bone path along all rays of a job.
    fn cast(&self, job: &Job<'_>) -> Result<Images<T>>;

    /// Whether it ever takes the sums over energies.
    fn has_signals(&self) -> bool;

    /// The sums over energies as well; `None` where they are left to the development.
    fn signals(&self, job: &SignalsJob<'_>) -> Result<Option<(Images<T>, Passed)>>;
}

impl RayCaster<f32> for dyn Engine + '_ {
    fn cast(&self, job: &Job<'_>) -> Result<Images<f32>> {
        self.project(job)
    }

    fn has_signals(&self) -> bool {
        Engine::has_signals(self)
    }

    fn signals(&self, job: &SignalsJob<'_>) -> Result<Option<(Images<f32>, Passed)>> {
        Engine::signals(self, job)
    }
}

/// In float64, with every sum the development's own.
impl RayCaster<f64> for Reference {
    fn cast(&self, job: &Job<'_>) -> Result<Images<f64>> {
        self.project_f64(job)
    }

    fn has_signals(&self) -> bool {
        false
    }

    fn signals(&self, _: &SignalsJob<'_>) -> Result<Option<(Images<f64>, Passed)>> {
        Ok(None)
    }
}
