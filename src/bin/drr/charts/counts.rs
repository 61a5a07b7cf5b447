//! A linear axis of counts, from 0.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged};

use super::decades::STEPS;

/// Most ticks.
const TICKS: f64 = 12.0;
/// Room beyond the last, as a factor.
const ROOM: f64 = 1.03;
/// Counts beyond this one are at the edge: those below it are exact in float64.
const LARGEST: f64 = 9e15;

/// From 0 to the largest value, and a little more.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Counts {
    most: f64,
}

impl Counts {
    /// An axis with room for the values. Of those that are not finite it takes no notice.
    pub(crate) fn up_to(values: impl IntoIterator<Item = f64>) -> Self {
        let most = values.into_iter().filter(|value| value.is_finite()).fold(1.0, f64::max);
        Self { most: ROOM * most.min(LARGEST) }
    }

    /// Whole numbers, the same distance apart, which is 1, 2 or 5 of a decade.
    fn ticks(self) -> Vec<f64> {
        let steps = (0..16).flat_map(|decade| STEPS.map(|step| step * 10f64.powi(decade)));
        let step = steps.into_iter().find(|step| self.most / step <= TICKS).unwrap_or(self.most);
        (0..=(self.most / step) as u32).map(|n| f64::from(n) * step).collect()
    }
}

impl Ranged for Counts {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        from + (f64::from(to - from) * value.clamp(0.0, self.most) / self.most).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks()
    }

    fn range(&self) -> Range<f64> {
        0.0..self.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_even_and_few() {
        assert_eq!(Counts::up_to([]).ticks(), [0.0, 1.0]);
        assert_eq!(Counts::up_to([f64::NAN, -3.0, 7.0]).ticks(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(Counts::up_to([60.0]).ticks().last(), Some(&60.0));
        assert!(Counts::up_to([f64::MAX]).ticks().len() < 20);
    }

    #[test]
    fn equal_differences_are_equal_distances() {
        let axis = Counts::up_to([100.0]);
        let [a, b, c] = [0.0, 50.0, 100.0].map(|value| axis.map(&value, (10, 1040)));
        assert_eq!([a, b, c], [10, 510, 1010]);
        assert_eq!(axis.map(&1e9, (10, 1040)), 1040);
    }
}
