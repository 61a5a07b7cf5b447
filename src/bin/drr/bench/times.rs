//! Durations of one stage.

use serde_json::json;

use crate::console::Console;
use crate::value::seconds;

/// Durations of one stage, s.
pub(super) struct Times {
    pub(super) name: &'static str,
    pub(super) all: Vec<f64>,
}

impl Times {
    pub(super) fn new(name: &'static str) -> Self {
        Self { name, all: Vec::new() }
    }

    fn sorted(&self) -> Vec<f64> {
        let mut sorted = self.all.clone();
        sorted.sort_by(f64::total_cmp);
        sorted
    }

    pub(super) fn median(&self) -> f64 {
        let sorted = self.sorted();
        let middle = sorted.len() / 2;
        if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) }
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        let sorted = self.sorted();
        json!({ "median_seconds": self.median(), "min_seconds": sorted[0], "max_seconds": sorted[sorted.len() - 1] })
    }

    pub(super) fn say(&self, console: Console) {
        let sorted = self.sorted();
        console.say(format_args!(
            "  {:<20} median {:>10}   min {:>10}   max {:>10}",
            self.name,
            seconds(self.median()),
            seconds(sorted[0]),
            seconds(sorted[sorted.len() - 1]),
        ));
    }
}
