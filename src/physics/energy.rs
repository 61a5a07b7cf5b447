//! The energies of a spectrum.

use std::ops::RangeInclusive;

use crate::error::{Error, Result};

/// Most energies of a grid.
pub const MAX_ENERGIES: usize = 4096;
/// Two energies closer than this, in keV, are the same energy.
const SAME_ENERGY_KEV: f64 = 1e-9;
/// Smallest step, keV: far above `SAME_ENERGY_KEV`, so that an energy names one bin.
const MIN_STEP_KEV: f64 = 1e-6;
/// The values of a spectrum or a detector's response.
pub(super) const WEIGHTS: (RangeInclusive<f64>, &str) = (0.0..=f64::MAX, "finite, at least 0");
/// Largest energy, keV: keeps every `E_k` exact to `SAME_ENERGY_KEV`.
const MAX_KEV: f64 = 1e6;

/// Evenly spaced energies `E_k = first + k·step` in keV, k = 0 … count−1.
///
/// Coefficients are values *at* `E_k`; a spectrum's weight k is the content of the bin centred on `E_k`.
#[derive(Debug, Clone, Copy)]
pub struct EnergyGrid {
    first_kev: f64,
    step_kev: f64,
    count: usize,
}

impl EnergyGrid {
    /// The specification's 136 energies: 15, 16, …, 150 keV. The built-in tables hold exactly these.
    pub const SPECIFICATION: Self = Self { first_kev: 15.0, step_kev: 1.0, count: 136 };

    /// `energy_count` energies from `first_energy_kev` in steps of `energy_step_kev`, both in keV.
    ///
    /// # Errors
    /// `InvalidArgument` unless 0 < first, 1e-6 ≤ step, 1 ≤ count ≤ [`MAX_ENERGIES`] and the last energy is at most
    /// 1e6 keV.
    pub fn new(first_energy_kev: f64, energy_step_kev: f64, energy_count: usize) -> Result<Self> {
        if !(first_energy_kev > 0.0 && first_energy_kev <= MAX_KEV) {
            let valid = format!("above 0, at most {MAX_KEV:e} keV");
            return Err(Error::invalid("first_energy_kev", first_energy_kev, valid));
        }
        if !(MIN_STEP_KEV..=MAX_KEV).contains(&energy_step_kev) {
            let valid = format!("{MIN_STEP_KEV:e} … {MAX_KEV:e} keV");
            return Err(Error::invalid("energy_step_kev", energy_step_kev, valid));
        }
        if energy_count == 0 || energy_count > MAX_ENERGIES {
            return Err(Error::invalid("energy_count", energy_count, format!("1 … {MAX_ENERGIES}")));
        }
        let grid = Self { first_kev: first_energy_kev, step_kev: energy_step_kev, count: energy_count };
        let last = energy_count - 1;
        if grid.energy(last) > MAX_KEV {
            let value = format!("{} keV", grid.energy(last));
            return Err(Error::invalid(Self::argument(last), value, format!("at most {MAX_KEV:e} keV")));
        }
        Ok(grid)
    }

    /// What an error calls `E_k`: how the arguments of [`EnergyGrid::new`] make it.
    pub(crate) fn argument(k: usize) -> String {
        format!("first_energy_kev + {k} × energy_step_kev")
    }

    /// The grid of one energy, in keV.
    pub fn single(kev: f64) -> Result<Self> {
        Self::new(kev, 1.0, 1)
    }

    /// The first energy, keV.
    pub fn first_kev(&self) -> f64 {
        self.first_kev
    }

    /// The distance between neighbouring energies, keV.
    pub fn step_kev(&self) -> f64 {
        self.step_kev
    }

    /// The number of energies.
    pub fn count(&self) -> usize {
        self.count
    }

    /// `E_k` in keV, k below `count`.
    pub fn energy(&self, k: usize) -> f64 {
        self.first_kev + k as f64 * self.step_kev
    }

    /// All energies in keV, ascending.
    pub fn energies(&self) -> impl ExactSizeIterator<Item = f64> + use<> {
        let grid = *self;
        (0..grid.count).map(move |k| grid.energy(k))
    }

    /// The k with `E_k` = `kev` to 1e-9 keV, if there is one.
    pub fn index_of(&self, kev: f64) -> Option<usize> {
        let k = ((kev - self.first_kev) / self.step_kev).round();
        // NaN fails the first comparison.
        let inside = k >= 0.0 && k < self.count as f64;
        (inside && (self.energy(k as usize) - kev).abs() <= SAME_ENERGY_KEV).then_some(k as usize)
    }

    /// Checks one value per energy: the length, then that every value is in `range`, which `valid` puts in words.
    pub(crate) fn check_values(
        &self,
        argument: &str,
        values: &[f64],
        (range, valid): (RangeInclusive<f64>, &str),
    ) -> Result<()> {
        if values.len() != self.count {
            let length = format!("{} values", values.len());
            return Err(Error::invalid(argument, length, format!("one value per energy, {}", self.count)));
        }
        match values.iter().position(|v| !range.contains(v)) {
            Some(k) => Err(Error::invalid(format!("{argument}[{k}]"), values[k], valid)),
            None => Ok(()),
        }
    }

    /// Checks that `argument`, given on `self`, has the energies of `expected`.
    pub(crate) fn check_same(&self, argument: &str, expected: &Self) -> Result<()> {
        if self == expected {
            return Ok(());
        }
        Err(Error::invalid(argument, format!("on {self}"), format!("the spectrum's energies, {expected}")))
    }
}

impl PartialEq for EnergyGrid {
    /// The same energies; the step of a single energy does not matter.
    fn eq(&self, other: &Self) -> bool {
        self.first_kev == other.first_kev
            && self.count == other.count
            && (self.count == 1 || self.step_kev == other.step_kev)
    }
}

impl std::fmt::Display for EnergyGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.count {
            1 => write!(f, "{} keV", self.first_kev),
            n => write!(f, "{n} energies from {} keV, step {} keV", self.first_kev, self.step_kev),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_specification_runs_from_15_to_150_kev() {
        let grid = EnergyGrid::SPECIFICATION;
        assert_eq!((grid.energy(0), grid.energy(135), grid.count()), (15.0, 150.0, 136));
        assert_eq!(grid.energies().collect::<Vec<_>>(), (15..=150).map(f64::from).collect::<Vec<_>>());
        assert_eq!(EnergyGrid::new(15.0, 1.0, 136), Ok(grid));
    }

    #[test]
    fn index_of_inverts_energy_and_nothing_else() {
        let grid = EnergyGrid::new(20.0, 0.1, 500).unwrap();
        assert!((0..500).all(|k| grid.index_of(grid.energy(k)) == Some(k)));
        assert_eq!(grid.index_of(20.1 + 5e-10), Some(1));
        for absent in [19.9, 20.05, 20.1 + 2e-9, 70.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(grid.index_of(absent), None, "{absent} keV");
        }
    }

    #[test]
    fn refuses_what_is_no_grid_and_says_which_argument() {
        for (first, step, count, argument) in [
            (0.0, 1.0, 1, "first_energy_kev is 0"),
            (-15.0, 1.0, 1, "first_energy_kev is -15"),
            (f64::NAN, 1.0, 1, "first_energy_kev is NaN"),
            (f64::INFINITY, 1.0, 1, "first_energy_kev is inf"),
            (15.0, 0.0, 1, "energy_step_kev is 0"),
            (15.0, -1.0, 1, "energy_step_kev is -1"),
            (15.0, f64::INFINITY, 1, "energy_step_kev is inf"),
            (15.0, f64::NAN, 1, "energy_step_kev is NaN"),
            (15.0, 1.0, 0, "energy_count is 0"),
            (15.0, 1.0, MAX_ENERGIES + 1, "energy_count is 4097"),
            (15.0, 1e6, 2, "first_energy_kev + 1 × energy_step_kev is 1000015 keV"),
        ] {
            let message = EnergyGrid::new(first, step, count).unwrap_err().to_string();
            assert!(message.contains(argument), "{message}");
        }
        assert!(EnergyGrid::new(15.0, 0.01, MAX_ENERGIES).is_ok());
    }

    #[test]
    fn the_step_of_a_single_energy_does_not_matter() {
        assert_eq!(EnergyGrid::single(60.0), EnergyGrid::new(60.0, 2.0, 1));
        assert_ne!(EnergyGrid::new(60.0, 1.0, 2), EnergyGrid::new(60.0, 2.0, 2));
    }
}
