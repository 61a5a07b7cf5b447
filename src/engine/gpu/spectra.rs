//! The spectral tables of a job's views.

use std::sync::Arc;

use crate::engine::gpu::wire::Beam;
use crate::physics::SpectralModel;

/// Energies of which a table holds a multiple, `DRR_ENERGIES_TOGETHER` in `shaders/spectrum.h`: the last ones have no
/// weight and the attenuation of the last that has.
const TOGETHER: usize = 8;

/// The logarithm of no weight, as far as float32 sums can tell.
const NO_WEIGHT: f64 = -1e30;

/// The tables of all views, one after the other; views that share a model share its tables.
#[derive(Debug, Default)]
pub(crate) struct Spectra {
    models: Vec<(Arc<SpectralModel>, Place)>,
    /// Weights by energy, normalised to sum 1; and once more their natural logarithms, which float32 can hold always.
    pub weights: Vec<f32>,
    /// Mass attenuation by material and energy, cm²/g.
    pub attenuation: Vec<f32>,
}

/// Where a model's tables begin.
#[derive(Debug, Clone, Copy)]
struct Place {
    weight: usize,
    attenuation: usize,
}

impl Spectra {
    /// Names a model's tables in a beam.
    pub(super) fn set(&mut self, model: &Arc<SpectralModel>, beam: &mut Beam) {
        let place = self.place(model);
        beam.bins = model.bins().next_multiple_of(TOGETHER) as u32;
        beam.first_weight = place.weight as u32;
        beam.first_attenuation = place.attenuation as u32;
        beam.i0 = model.i0() as f32;
        // Of the weights as rounded: an empty path has exactly none of them missing.
        let rounded = &self.weights[place.weight..][..model.bins()];
        beam.weight_sum = rounded.iter().map(|&weight| f64::from(weight)).sum::<f64>().into();
        for m in 0..model.materials() {
            beam.least_attenuation[m] = model.least_attenuation(m) as f32;
        }
    }

    fn place(&mut self, model: &Arc<SpectralModel>) -> Place {
        if let Some((_, place)) = self.models.iter().find(|(known, _)| Arc::ptr_eq(known, model)) {
            return *place;
        }
        let place = Place { weight: self.weights.len(), attenuation: self.attenuation.len() };
        let padded = model.bins().next_multiple_of(TOGETHER);
        let extend = |table: &mut Vec<f32>, values: &mut dyn Iterator<Item = f64>, filler: f64| {
            let filled = values.chain(std::iter::repeat(filler)).take(padded);
            table.extend(filled.map(|value| value as f32));
        };
        extend(&mut self.weights, &mut model.weights().iter().copied(), 0.0);
        extend(&mut self.weights, &mut model.weights().iter().map(|weight| weight.ln()), NO_WEIGHT);
        for m in 0..model.materials() {
            let coefficients = model.coefficients(m);
            extend(&mut self.attenuation, &mut coefficients.iter().copied(), coefficients[model.bins() - 1]);
        }
        self.models.push((model.clone(), place));
        place
    }
}
