//! The spectral tables of a job's views.

use std::sync::Arc;

use crate::engine::SignalsJob;
use crate::engine::gpu::few::Few;
use crate::engine::gpu::wire::{Beam, Channels, Table};
use crate::error::Result;
use crate::physics::{MAX_MATERIALS, SpectralModel};
use crate::scene::Scene;

/// Energies of which a table holds a multiple, `DRR_ENERGIES_TOGETHER` in `shaders/spectrum.h`: the last ones have no
/// weight and the attenuation of the last that has.
const TOGETHER: usize = 8;

/// `DRR_SPECIFICATION_ENERGIES` in `shaders/specification.h`.
const SPECIFICATION_ENERGIES: usize = 136;

/// Less than any areal density.
const NEVER: f32 = -1.0;

/// The logarithm of no weight, as far as float32 sums can tell.
const NO_WEIGHT: f64 = -1e30;

/// The tables of all views, one after the other; views that share a model share its tables.
#[derive(Debug, Default)]
pub(crate) struct Spectra {
    models: Vec<(Arc<SpectralModel>, Table)>,
    /// Weights by energy, normalised to sum 1; and once more their natural logarithms, which float32 can hold always.
    pub weights: Vec<f32>,
    /// Mass attenuation by material and energy, cm²/g.
    pub attenuation: Vec<f32>,
}

/// A scene's tables with all energies, also those without weight, and the weights as they are given: what the tables that
/// a view has in the device's memory replace. Every row is padded with zeros to whole groups.
#[derive(Debug)]
pub(super) struct WholeTables {
    energies: usize,
    weights: Vec<f32>,
    attenuation: Vec<f32>,
}

impl WholeTables {
    pub(super) fn of(scene: &Scene) -> Result<Self> {
        let spectrum = scene.detected(0)?;
        let energies = spectrum.grid().count();
        let padded = |row: &[f64]| {
            let mut padded: Vec<f32> = row.iter().map(|&value| value as f32).collect();
            padded.resize(energies.next_multiple_of(TOGETHER), 0.0);
            padded
        };
        let rows = (0..scene.materials.names().len()).map(|m| padded(scene.materials.coefficients(m)));
        let attenuation = rows.flatten().collect();
        Ok(Self { energies, weights: padded(spectrum.weights()), attenuation })
    }
}

impl Spectra {
    /// Names a model's tables in a beam, to be summed over whatever a ray has met.
    pub(super) fn set(&mut self, model: &Arc<SpectralModel>, beam: &mut Beam) {
        beam.all = self.table(model);
        beam.few_up_to = [NEVER; 8];
        beam.i0 = model.i0() as f32;
        for m in 0..model.materials() {
            beam.least_attenuation[m] = model.least_attenuation(m) as f32;
        }
    }

    /// Names in a beam the tables of the few energies that stand for those of its model.
    pub(super) fn set_few(&mut self, few: &Few, beam: &mut Beam) {
        beam.few = self.table(&few.model);
        beam.few_up_to = few.up_to;
    }

    /// Makes room for the tables that a view has in the device's memory, where `shaders/tables.h` prepares them.
    pub(super) fn make_room(&mut self, tables: &WholeTables, beam: &mut Beam) {
        beam.all = Table { bins: tables.energies as u32, ..self.end() };
        beam.few_up_to = [NEVER; 8];
        // Twice: logarithms follow.
        self.weights.extend(tables.weights.iter().chain(&tables.weights));
        self.attenuation.extend(&tables.attenuation);
    }

    /// The tables of a job's rows of weights, of a scene with so many materials.
    pub(super) fn set_rows(&mut self, job: &SignalsJob<'_>, materials: usize) -> Channels {
        let end = self.end();
        let energies = job.coefficients[0].len();
        let padded = energies.next_multiple_of(TOGETHER);
        let mut channels = Channels {
            bins: padded as u32,
            first_weight: end.first_weight,
            first_attenuation: end.first_attenuation,
            ..Channels::default()
        };
        let totals: Vec<f64> = job.rows.iter().map(|row| row.iter().sum()).collect();
        for ((row, total), sum) in job.rows.iter().zip(&totals).zip(&mut channels.weight_sum) {
            let first = self.weights.len();
            extend(&mut self.weights, padded, row.iter().map(|weight| weight / total), 0.0);
            *sum = sum_of(&self.weights[first..]).into();
        }
        for (row, total) in job.rows.iter().zip(&totals) {
            let logarithm = |weight: &f64| if *weight > 0.0 { (weight / total).ln() } else { NO_WEIGHT };
            extend(&mut self.weights, padded, row.iter().map(logarithm), NO_WEIGHT);
        }
        for (m, row) in job.coefficients.iter().enumerate() {
            extend(&mut self.attenuation, padded, row.iter().copied(), row[energies - 1]);
            let part = if m < materials { m } else { MAX_MATERIALS + m - materials };
            channels.least_attenuation[part] = row.iter().copied().fold(f64::INFINITY, f64::min) as f32;
        }
        channels
    }

    /// A table that begins where the others end.
    fn end(&self) -> Table {
        let [first_weight, first_attenuation] =
            [self.weights.len(), self.attenuation.len()].map(|n| n as u32);
        Table { first_weight, first_attenuation, ..Table::default() }
    }

    /// A model's tables, laid out if they are new.
    fn table(&mut self, model: &Arc<SpectralModel>) -> Table {
        if let Some((_, table)) = self.models.iter().find(|(known, _)| Arc::ptr_eq(known, model)) {
            return *table;
        }
        let (mut table, first) = (self.end(), self.attenuation.len());
        let padded = model.bins().next_multiple_of(TOGETHER);
        extend(&mut self.weights, padded, model.weights().iter().copied(), 0.0);
        table.bins = padded as u32;
        table.weight_sum = sum_of(&self.weights[table.first_weight as usize..]).into();
        extend(&mut self.weights, padded, model.weights().iter().map(|weight| weight.ln()), NO_WEIGHT);
        for m in 0..model.materials() {
            let coefficients = model.coefficients(m);
            let last = coefficients[model.bins() - 1];
            extend(&mut self.attenuation, padded, coefficients.iter().copied(), last);
        }
        // The specification's loop reads as many energies as it has, whatever the tables hold.
        let read = first + (model.materials() - 1) * padded + SPECIFICATION_ENERGIES;
        self.attenuation.resize(read.max(self.attenuation.len()), 0.0);
        self.models.push((model.clone(), table));
        table
    }
}

/// Lays out a row of a table, filled up to whole groups.
fn extend(table: &mut Vec<f32>, padded: usize, values: impl Iterator<Item = f64>, filler: f64) {
    let filled = values.chain(std::iter::repeat(filler)).take(padded);
    table.extend(filled.map(|value| value as f32));
}

/// Of weights as rounded: an empty path has exactly none of them missing.
fn sum_of(rounded: &[f32]) -> f64 {
    rounded.iter().map(|&weight| f64::from(weight)).sum()
}

#[cfg(test)]
mod tests;
