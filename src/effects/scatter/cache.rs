//! Kernels that were made, to be had again for nothing.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{Beamline, Scatter, ScatterKernels};
use crate::error::Result;
use crate::physics::Spectrum;

/// Kernels that are kept.
const MOST: usize = 16;

/// What kernels are made of.
#[derive(Debug, Clone, PartialEq)]
struct Key {
    scatter: Scatter,
    source: Spectrum,
    responses: Vec<Vec<f64>>,
    geometry: Beamline,
}

/// The latest kernels of one context.
#[derive(Debug, Default)]
pub(crate) struct ScatterCache(Mutex<Vec<(Key, Arc<ScatterKernels>)>>);

impl ScatterCache {
    /// As [`ScatterKernels::new`], with distances to half a percent: views that differ by less share their kernels. Two threads
    /// may make the same.
    pub(crate) fn get_or_make(
        &self,
        scatter: Scatter,
        source: &Spectrum,
        responses: &[Vec<f64>],
        geometry: Beamline,
    ) -> Result<Arc<ScatterKernels>> {
        geometry.validate()?;
        let geometry = geometry.rounded();
        let key = Key { scatter, source: source.clone(), responses: responses.to_vec(), geometry };
        if let Some((_, kernels)) = self.entries().iter().find(|(other, _)| *other == key) {
            return Ok(kernels.clone());
        }
        // Not while others wait: a thread that makes kernels takes other work of its pool meanwhile, which may want some too.
        let kernels = Arc::new(ScatterKernels::new(&scatter, source, responses, geometry)?);
        let mut entries = self.entries();
        if let Some((_, known)) = entries.iter().find(|(other, _)| *other == key) {
            return Ok(known.clone());
        }
        if entries.len() == MOST {
            entries.remove(0);
        }
        entries.push((key, kernels.clone()));
        Ok(kernels)
    }

    fn entries(&self) -> MutexGuard<'_, Vec<(Key, Arc<ScatterKernels>)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::EnergyGrid;

    #[test]
    fn the_same_is_made_once() {
        let cache = ScatterCache::default();
        let source = Spectrum::named("W60_2p5Al", EnergyGrid::SPECIFICATION).expect("built in");
        let responses = [vec![1.0; EnergyGrid::SPECIFICATION.count()]];
        let scatter = Scatter { histories: 1000, seed: 3 };
        let at = |source_detector_mm: f64| {
            let geometry = Beamline { source_centre_mm: 1000.0, source_detector_mm };
            cache.get_or_make(scatter, &source, &responses, geometry).expect("valid")
        };
        let first = at(1500.0);
        assert!(Arc::ptr_eq(&first, &at(1500.0)) && Arc::ptr_eq(&first, &at(1500.5)));
        assert!(!Arc::ptr_eq(&first, &at(1600.0)));
        let geometry = Beamline { source_centre_mm: -1.0, source_detector_mm: 10.0 };
        assert!(cache.get_or_make(scatter, &source, &responses, geometry).is_err());
    }
}
