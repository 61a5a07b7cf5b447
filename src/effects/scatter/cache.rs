//! Kernels that were made, to be had again for nothing.

use std::sync::{Arc, Mutex, PoisonError};

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
    /// As [`ScatterKernels::new`], with distances to half a percent: views that differ by less share their kernels.
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
        // Held while kernels are made: threads that need the same wait for them.
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, kernels)) = known.iter().find(|(other, _)| *other == key) {
            return Ok(kernels.clone());
        }
        let kernels = Arc::new(ScatterKernels::new(&scatter, source, responses, geometry)?);
        if known.len() == MOST {
            known.remove(0);
        }
        known.push((key, kernels.clone()));
        Ok(kernels)
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
