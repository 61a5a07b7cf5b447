//! The few energies that stand for all of a scene's.

use std::sync::Arc;

use crate::physics::{Quadrature, SpectralModel};

/// A reduced sum, and where the kernel may take it.
#[derive(Debug)]
pub(super) struct Few {
    pub(super) model: Arc<SpectralModel>,
    /// The largest areal densities, g/cm², by label.
    pub(super) up_to: [f32; 8],
}

impl Few {
    /// Of a scene's model.
    pub(super) fn of(quadrature: &Quadrature, exact: &SpectralModel) -> Self {
        let mut up_to = [0.0; 8];
        for (up_to, &limit) in up_to.iter_mut().zip(quadrature.limits()) {
            *up_to = rounded_down(limit);
        }
        Self { model: Arc::new(quadrature.model(exact)), up_to }
    }
}

/// The bound holds up to the limit, not up to what it is rounded to.
fn rounded_down(limit: f64) -> f32 {
    let nearest = limit as f32;
    if f64::from(nearest) > limit { nearest.next_down() } else { nearest }
}
