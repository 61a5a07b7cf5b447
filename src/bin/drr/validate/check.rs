//! One measured error and what is required of it.

use drr::Algorithm;
use serde::Serialize;

/// Above a list of checks.
pub(super) const HEADING: &str = "  what             algorithm                  RMSE        max   unit  required    aim  verdict       samples";

/// A measured error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Check {
    pub(super) what: &'static str,
    pub(super) algorithm: String,
    pub(super) rmse: f64,
    pub(super) max: f64,
    pub(super) unit: &'static str,
    /// Largest RMSE that passes.
    pub(super) required: f64,
    /// RMSE that is aimed at.
    pub(super) aim: f64,
    /// Number of differences.
    pub(super) samples: usize,
    pub(super) passed: bool,
}

impl Check {
    /// Differences in mm: in the plane of the isocentre, or of water.
    pub(super) fn millimetres(what: &'static str, algorithm: Algorithm, differences: &[f64]) -> Self {
        Self::new(what, algorithm, differences, "mm", [0.2, 0.02])
    }

    /// Differences in HU-equivalents.
    pub(super) fn hu(what: &'static str, algorithm: Algorithm, differences: &[f64]) -> Self {
        Self::new(what, algorithm, differences, "HU", [2.0, 0.5])
    }

    fn new(
        what: &'static str,
        algorithm: Algorithm,
        differences: &[f64],
        unit: &'static str,
        [required, aim]: [f64; 2],
    ) -> Self {
        let samples = differences.len();
        // Without a sample it is NaN, which does not pass.
        let rmse = (differences.iter().map(|d| d * d).sum::<f64>() / samples as f64).sqrt();
        let max = differences.iter().fold(0.0, |max: f64, d| max.max(d.abs()));
        let passed = rmse <= required;
        Self { what, algorithm: algorithm.to_string(), rmse, max, unit, required, aim, samples, passed }
    }

    pub(super) fn passes(&self) -> bool {
        self.passed
    }
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let verdict = match (self.passed, self.rmse <= self.aim) {
            (false, _) => "FAILS",
            (true, true) => "passes, aim",
            (true, false) => "passes",
        };
        write!(
            f,
            "  {:<16} {:<22} {:>8.4} {:>10.4}   {:<4} {:>9} {:>6}  {verdict:<12} {:>8}",
            self.what, self.algorithm, self.rmse, self.max, self.unit, self.required, self.aim, self.samples
        )
    }
}
