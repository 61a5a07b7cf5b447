//! A logarithmic axis: its range, its ticks and their texts.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged};

/// Grid lines of a decade, where the axis may end, too.
const LINES: [f64; 9] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
/// Those that have texts, where there are few decades.
pub(super) const STEPS: [f64; 3] = [1.0, 2.0, 5.0];
/// How many decades are few.
const FEW_DECADES: f64 = 2.3;
/// Room around the values, as a factor.
const ROOM: f64 = 1.25;

/// In what the values of an axis are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unit {
    /// A bare number; the axis says what it is.
    Number,
    /// Seconds, shown with a prefix.
    Seconds,
}

/// A logarithmic axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Decades {
    pub(crate) least: f64,
    pub(crate) most: f64,
    unit: Unit,
}

impl Decades {
    /// An axis with room for the values, but for those so many decades below the largest. Of values that are not
    /// positive and finite it takes no notice.
    pub(crate) fn around(values: impl IntoIterator<Item = f64>, decades: i32, unit: Unit) -> Self {
        let shown = values.into_iter().filter(|v| v.is_normal() && *v > 0.0);
        let ends = shown.fold(None, |ends: Option<[f64; 2]>, v| {
            Some(ends.map_or([v, v], |[least, most]| [least.min(v), most.max(v)]))
        });
        let [least, most] = ends.unwrap_or([1.0, 1.0]);
        // One value alone stands in the middle of a decade; numbers at the ends of f64 keep a range.
        let [least, most] = [least, most].map(|end| end.clamp(1e-290, 1e290));
        let spread = if most / least < 3.0 { 3.0 } else { ROOM };
        let most = tick_above(most * spread);
        let least = tick_below(least / spread).max(most * 10f64.powi(-decades));
        Self { least, most, unit }
    }

    /// Where the value lies between the ends: 0 to 1.
    fn fraction(self, value: f64) -> f64 {
        let inside = value.clamp(self.least, self.most);
        (inside / self.least).log10() / (self.most / self.least).log10()
    }

    /// Whether the value lies between the ends.
    pub(crate) fn shows(self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }

    /// The text of a value.
    pub(crate) fn text(self, value: f64) -> String {
        match self.unit {
            Unit::Number => number(value),
            Unit::Seconds if value < 0.9995e-3 => format!("{} \u{b5}s", number(value * 1e6)),
            Unit::Seconds if value < 0.09995 => format!("{} ms", number(value * 1e3)),
            Unit::Seconds => format!("{} s", number(value)),
        }
    }

    fn ticks(self, steps: &[f64]) -> Vec<f64> {
        let exponents = self.least.log10().floor() as i32..=self.most.log10().ceil() as i32;
        let all = exponents.flat_map(|exponent| steps.iter().map(move |step| step * 10f64.powi(exponent)));
        let slack = 1.0 + 1e-9;
        all.filter(|tick| (self.least / slack..=self.most * slack).contains(tick)).collect()
    }
}

/// A number in few digits.
pub(crate) fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

fn tick_below(value: f64) -> f64 {
    let decade = 10f64.powi(value.log10().floor() as i32);
    LINES.iter().rev().map(|step| step * decade).find(|tick| *tick <= value * (1.0 + 1e-9)).unwrap_or(decade)
}

fn tick_above(value: f64) -> f64 {
    let decade = 10f64.powi(value.log10().floor() as i32);
    LINES.iter().map(|step| step * decade).find(|tick| *tick >= value / (1.0 + 1e-9)).unwrap_or(10.0 * decade)
}

impl Ranged for Decades {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        from + (f64::from(to - from) * self.fraction(*value)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            return self.ticks(&LINES);
        }
        let few = (self.most / self.least).log10() <= FEW_DECADES;
        self.ticks(if few { &STEPS } else { &STEPS[..1] })
    }

    fn range(&self) -> Range<f64> {
        self.least..self.most
    }
}

#[cfg(test)]
mod tests {
    use plotters::coord::ranged1d::BoldPoints;
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn ticks_are_decades_with_readable_texts() {
        let texts = |axis: Decades| -> Vec<String> {
            axis.key_points(BoldPoints(9)).iter().map(|tick| axis.text(*tick)).collect()
        };
        let seconds = Decades::around([0.0012, 17.0], 7, Unit::Seconds);
        assert_eq!(texts(seconds), ["1 ms", "10 ms", "0.1 s", "1 s", "10 s"]);
        let errors = Decades::around([0.012, 9.0], 7, Unit::Number);
        assert_eq!(texts(errors), ["0.01", "0.1", "1", "10"]);
        let narrow = Decades::around([0.25, 0.9], 7, Unit::Seconds);
        assert_eq!(texts(narrow), ["0.2 s", "0.5 s", "1 s", "2 s"]);
        assert_eq!(Decades::around([1e-5], 7, Unit::Seconds).text(2e-5), "20 \u{b5}s");
    }

    #[test]
    fn what_lies_far_below_is_at_the_edge() {
        let axis = Decades::around([1e-30, 0.0, 1.0], 7, Unit::Number);
        assert!((1e-8..1e-6).contains(&axis.least), "{}", axis.least);
        assert_eq!(axis.map(&0.0, (100, 0)), 100);
    }

    proptest! {
        #[test]
        fn every_value_has_a_place(values in proptest::collection::vec(any::<f64>(), 0..5)) {
            let axis = Decades::around(values.iter().copied(), 7, Unit::Number);
            prop_assert!(axis.least > 0.0 && axis.least < axis.most && axis.most.is_finite());
            prop_assert!(axis.key_points(BoldPoints(9)).len() >= 2 || axis.most / axis.least > 1e9);
            for value in values.iter().filter(|v| !v.is_nan()) {
                prop_assert!((10..=110).contains(&axis.map(value, (10, 110))));
            }
        }
    }
}
