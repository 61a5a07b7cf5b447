//! Distances from a pencil beam.

/// Radius of the innermost ring, mm.
const INNERMOST_MM: f64 = 1.0;
/// From one radius to the next.
const RATIO: f64 = 1.15;

/// Rings around a pencil beam in the detector's plane, each wider than the one inside it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rings {
    /// Outer radii, mm.
    radii: Vec<f64>,
}

impl Rings {
    /// Up to at least `radius` mm.
    pub(super) fn up_to(radius: f64) -> Self {
        let outer = |k: i32| INNERMOST_MM * RATIO.powi(k);
        let count = 2 + ((radius / INNERMOST_MM).ln() / RATIO.ln()).max(0.0) as i32;
        Self { radii: (0..count).map(outer).collect() }
    }

    pub(super) fn count(&self) -> usize {
        self.radii.len()
    }

    /// The largest radius, mm.
    pub(super) fn outermost(&self) -> f64 {
        self.radii[self.radii.len() - 1]
    }

    /// Inner and outer radius of each, mm.
    pub(super) fn bounds(&self) -> impl Iterator<Item = [f64; 2]> {
        let inner = std::iter::once(0.0).chain(self.radii.iter().copied());
        inner.zip(&self.radii).map(|(inner, outer)| [inner, *outer])
    }

    /// The ring that holds a radius in mm, if one does.
    pub(super) fn index(&self, radius: f64) -> Option<usize> {
        if !(radius < self.outermost()) {
            return None;
        }
        // Powers and logarithms round differently: the ring is looked up next to the estimate.
        let near = ((radius / INNERMOST_MM).ln() / RATIO.ln()).max(1.0) as usize - 1;
        (near..self.count()).find(|&k| radius < self.radii[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_radius_is_in_the_ring_that_bounds_it() {
        let rings = Rings::up_to(1500.0);
        assert!(rings.outermost() >= 1500.0 && rings.outermost() < 1500.0 * RATIO);
        for (k, [inner, outer]) in rings.bounds().enumerate() {
            for radius in [inner, 0.5 * (inner + outer), outer * (1.0 - 1e-15)] {
                assert_eq!(rings.index(radius), Some(k), "{radius} mm");
            }
        }
        assert_eq!(rings.index(rings.outermost()), None);
        assert_eq!(rings.index(f64::INFINITY), None);
    }
}
