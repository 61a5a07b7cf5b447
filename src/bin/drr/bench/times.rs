//! Durations of one stage.

use serde_json::json;

use crate::console::Console;
use crate::times::{median, spread};
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

    pub(super) fn median(&self) -> f64 {
        median(&self.all)
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        let [least, most] = spread(&self.all);
        json!({ "median_seconds": self.median(), "min_seconds": least, "max_seconds": most })
    }

    pub(super) fn say(&self, console: Console) {
        let [least, most] = spread(&self.all);
        console.say(format_args!(
            "  {:<20} median {:>10}   min {:>10}   max {:>10}",
            self.name,
            seconds(self.median()),
            seconds(least),
            seconds(most),
        ));
    }
}
