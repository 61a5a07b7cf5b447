//! An axis of either kind.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::counts::Counts;
use super::decades::{Decades, number};

/// An axis: its range, its ticks and their texts.
#[derive(Debug, Clone, Copy)]
pub(super) enum Axis {
    Decades(Decades),
    Counts(Counts),
}

impl Axis {
    /// Its lower end.
    pub(super) fn least(self) -> f64 {
        self.range().start
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        match self {
            Self::Decades(axis) => axis.map(value, limit),
            Self::Counts(axis) => axis.map(value, limit),
        }
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match self {
            Self::Decades(axis) => axis.key_points(hint),
            Self::Counts(axis) => axis.key_points(hint),
        }
    }

    fn range(&self) -> Range<f64> {
        match self {
            Self::Decades(axis) => axis.range(),
            Self::Counts(axis) => axis.range(),
        }
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        match self {
            Self::Decades(axis) => axis.text(*value),
            Self::Counts(_) => number(*value),
        }
    }
}
