//! The energy bins of a sum, laid out for float32, eight at a time.

use crate::physics::SpectralModel;

/// Energies summed side by side; the compiler makes vectors of them.
pub(super) const WIDTH: usize = 8;

pub(super) type Wide = [f32; WIDTH];

/// Weights and coefficients of a spectral model.
#[derive(Debug, Clone)]
pub(super) struct Bins {
    /// Weights, normalised to sum 1; the last bin is repeated with weight 0 to fill the last vector.
    pub(super) weights: Vec<Wide>,
    /// Their sum as rounded: an empty path has exactly none of them missing.
    pub(super) weight_sum: f64,
    /// Mass attenuation coefficients by label.
    pub(super) coefficients: Vec<Vec<Wide>>,
}

impl Bins {
    pub(super) fn of(model: &SpectralModel) -> Self {
        let wide = |values: &[f64], filler: f64| -> Vec<Wide> {
            let filled = |chunk: &[f64]| std::array::from_fn(|i| *chunk.get(i).unwrap_or(&filler) as f32);
            values.chunks(WIDTH).map(filled).collect()
        };
        let coefficients = |m: usize| {
            let values = model.coefficients(m);
            wide(values, *values.last().unwrap_or(&0.0))
        };
        let weights = wide(model.weights(), 0.0);
        Self {
            weight_sum: weights.iter().flatten().copied().map(f64::from).sum(),
            weights,
            coefficients: (0..model.materials()).map(coefficients).collect(),
        }
    }
}
