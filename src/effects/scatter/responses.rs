//! What the detector makes of photons that have lost energy.

use crate::error::{Error, Result};
use crate::physics::EnergyGrid;

/// Detected signal per photon, in rows, at the energies of a spectrum.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Responses {
    grid: EnergyGrid,
    /// Those of one energy side by side: that of row i at energy k is at `k*rows + i`.
    values: Vec<f64>,
    rows: usize,
}

impl Responses {
    /// # Errors
    /// `InvalidArgument` unless there is a row, each has one value per energy, and all are finite and at least 0.
    pub(super) fn new(grid: EnergyGrid, rows: &[Vec<f64>]) -> Result<Self> {
        if rows.is_empty() {
            return Err(Error::invalid("responses", "0 rows", "at least one row"));
        }
        for (i, row) in rows.iter().enumerate() {
            if row.len() != grid.count() {
                let valid = format!("one value per energy, {}", grid.count());
                return Err(Error::invalid(format!("responses[{i}]"), row.len(), valid));
            }
            if let Some(k) = row.iter().position(|value| !(0.0..=f64::MAX).contains(value)) {
                return Err(Error::invalid(format!("responses[{i}][{k}]"), row[k], "finite, at least 0"));
            }
        }
        let values = (0..grid.count()).flat_map(|k| rows.iter().map(move |row| row[k])).collect();
        Ok(Self { grid, values, rows: rows.len() })
    }

    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// Adds `weight` times the signal of a photon of `kev` to the sum of each row. Between the grid's energies the
    /// response is a straight line, so that a K edge of the detector is as wide as a step of the grid; beyond the grid
    /// it is that of its first or last energy.
    pub(super) fn add(&self, kev: f64, weight: f64, sums: &mut [f64]) {
        let last = self.grid.count() - 1;
        let place = ((kev - self.grid.first_kev()) / self.grid.step_kev()).clamp(0.0, last as f64);
        let below = (place as usize).min(last.saturating_sub(1));
        let part = place - below as f64;
        let row = |k: usize| &self.values[k * self.rows..][..self.rows];
        for ((sum, low), high) in sums.iter_mut().zip(row(below)).zip(row((below + 1).min(last))) {
            *sum += weight * (low + part * (high - low));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_energies_a_straight_line_and_beyond_them_the_last() {
        let grid = EnergyGrid::new(40.0, 5.0, 3).unwrap();
        let own = Responses::new(grid, &[vec![1.0, 2.0, 4.0], vec![8.0, 8.0, 0.0]]).unwrap();
        for (kev, expected) in [
            (20.0, [1.0, 8.0]),
            (40.0, [1.0, 8.0]),
            (42.5, [1.5, 8.0]),
            (45.0, [2.0, 8.0]),
            (49.0, [3.6, 1.6]),
            (50.0, [4.0, 0.0]),
            (60.0, [4.0, 0.0]),
        ] {
            let mut sums = [0.0; 2];
            own.add(kev, 2.0, &mut sums);
            assert!((0..2).all(|i| (sums[i] - 2.0 * expected[i]).abs() < 1e-12), "{kev} keV: {sums:?}");
        }
        let one = Responses::new(EnergyGrid::single(60.0).unwrap(), &[vec![3.0]]).unwrap();
        let mut sums = [0.0];
        one.add(47.0, 1.0, &mut sums);
        assert_eq!(sums, [3.0]);
    }

    #[test]
    fn refusals_name_what_is_wrong() {
        let grid = EnergyGrid::new(40.0, 5.0, 2).unwrap();
        for (rows, part) in [
            (vec![], "responses is 0 rows"),
            (vec![vec![1.0, 2.0], vec![1.0]], "responses[1] is 1"),
            (vec![vec![1.0, f64::NAN]], "responses[0][1] is NaN"),
            (vec![vec![-1.0, 0.0]], "responses[0][0] is -1"),
        ] {
            let message = Responses::new(grid, &rows).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
