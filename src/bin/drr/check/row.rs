//! One line of the table: a case, an algorithm, an engine, and how far off the answer is.

use serde::Serialize;

/// An error and the bound that it must keep.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Deviation {
    /// The layer it was found in.
    pub(crate) layer: &'static str,
    pub(crate) error: f64,
    pub(crate) bound: f64,
}

impl Deviation {
    /// Nothing to be seen.
    pub(crate) const NONE: Self = Self { layer: "all", error: 0.0, bound: 0.0 };

    /// No answer to compare.
    pub(crate) const NOT_SEEN: Self = Self { layer: "none", error: f64::NAN, bound: 0.0 };
    /// Bytes that should be the same are not.
    pub(crate) const DIFFERENT: Self = Self { layer: "bytes", error: f64::INFINITY, bound: 0.0 };

    /// How much of the bound is used. NaN counts as infinite.
    pub(crate) fn ratio(self) -> f64 {
        if self.error == 0.0 {
            0.0
        } else if self.error.is_nan() {
            f64::INFINITY
        } else {
            self.error / self.bound
        }
    }

    /// The one that uses more of its bound.
    pub(crate) fn or_worse(self, other: Self) -> Self {
        if other.ratio() >= self.ratio() { other } else { self }
    }
}

/// What came of a case.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Row {
    pub(crate) family: usize,
    pub(crate) case: String,
    pub(crate) algorithm: &'static str,
    pub(crate) engine: &'static str,
    #[serde(flatten)]
    pub(crate) worst: Deviation,
    /// What the verdict rests on when it is not the bound alone; why the case failed without an answer.
    pub(crate) note: Option<String>,
    pub(crate) holds: bool,
}

/// Above the table.
pub(crate) const HEADING: &str = "  family  case                                       algorithm  engine     layer             error     bound  verdict";

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { family, case, algorithm, engine, worst, note, holds } = self;
        let verdict = if *holds { "holds" } else { "FAILS" };
        write!(
            f,
            "  {family:>6}  {case:<42} {algorithm:<10} {engine:<10} {:<15} {:>8.1e}  {:>8.1e}  {verdict}",
            worst.layer, worst.error, worst.bound
        )?;
        note.as_ref().map_or(Ok(()), |note| write!(f, " ({note})"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_uses_more_than_any_bound() {
        let deviation = |error: f64, bound: f64| Deviation { layer: "of a test", error, bound };
        assert!(deviation(f64::NAN, 1.0).ratio() > 1.0);
        assert!(deviation(1e-300, 0.0).ratio() > 1.0);
        assert_eq!(deviation(0.0, 0.0).ratio(), 0.0);
        assert_eq!(deviation(1.0, 4.0).or_worse(deviation(f64::NAN, 1.0)).ratio(), f64::INFINITY);
        assert_eq!(deviation(f64::NAN, 1.0).or_worse(deviation(1.0, 4.0)).ratio(), f64::INFINITY);
        assert!(Deviation::NOT_SEEN.ratio() > 1.0 && Deviation::DIFFERENT.ratio() > 1.0);
    }
}
