//! The signals of a view whose energies an engine has summed.

use rayon::prelude::*;

use crate::engine::Passed;
use crate::error::Result;
use crate::exposure::signals::Signals;
use crate::exposure::sums::Sums;
use crate::exposure::{Sample, Shot};

/// The signals of a shot's rays, averaged over the focal spot in float64, as the sums by [`signals`](super::signals::signals)
/// are.
pub(super) fn signals_of<T: Sample>(shot: &Shot<T>, passed: &Passed, sums: &Sums<'_>) -> Result<Signals> {
    let size = shot.size();
    let rows = sums.channels.count();
    let mut signals = Signals::zeroed(size, rows, sums.open)?;
    signals.rows().into_par_iter().enumerate().for_each(|(row, mut planes)| {
        let (behind, open) = planes.split_at_mut(rows);
        let of_row = Row { sums, size, number: row };
        of_row.behind(behind, &shot.parts, &passed.passing);
        of_row.open(open, &passed.open);
    });
    Ok(signals)
}

/// One row of rays.
struct Row<'a> {
    sums: &'a Sums<'a>,
    size: [usize; 2],
    number: usize,
}

impl Row<'_> {
    /// The mean over the focal spot's points of what passed from each.
    fn behind(&self, to: &mut [&mut [f64]], parts: &[f64], passing: &[f32]) {
        let rows = to.len();
        for (point, part) in parts.iter().enumerate() {
            for (n, to) in to.iter_mut().enumerate() {
                let passed = self.of(passing, point * rows + n);
                to.iter_mut().zip(passed).for_each(|(sum, &number)| *sum += part * Passed::part(number));
            }
        }
        self.in_units(to);
    }

    /// What the engine has not summed because nothing attenuates it passes whole.
    fn open(&self, to: &mut [&mut [f64]], passing: &[f32]) {
        for (n, to) in to.iter_mut().enumerate() {
            match passing {
                [] => to.fill(1.0),
                passing => {
                    let passed = self.of(passing, n).iter().map(|&number| Passed::part(number));
                    to.iter_mut().zip(passed).for_each(|(to, part)| *to = part);
                }
            }
        }
        self.in_units(to);
    }

    /// The row's numbers of a plane.
    fn of<'a>(&self, planes: &'a [f32], plane: usize) -> &'a [f32] {
        let [width, height] = self.size;
        &planes[(plane * height + self.number) * width..][..width]
    }

    /// From parts of each sum to signals, with the source's factor.
    fn in_units(&self, to: &mut [&mut [f64]]) {
        for (total, to) in self.sums.channels.totals().iter().zip(&mut *to) {
            to.iter_mut().for_each(|value| *value *= total);
        }
        if !self.sums.source.has_factor() {
            return;
        }
        for column in 0..self.size[0] {
            let factor = self.sums.source.factor(column as f64, self.number as f64);
            for to in &mut *to {
                to[column] *= factor;
            }
        }
    }
}

#[cfg(test)]
mod tests;
