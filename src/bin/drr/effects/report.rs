//! The numbers, as a table and as JSON.

use std::path::Path;

use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};

use super::Study;
use super::case::Beside;
use super::cases::LeftOut;
use super::measured::Measured;
use crate::times::{median, spread};
use crate::value::seconds;

/// Everything that was measured, as `effects.json` has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Report {
    pub(super) version: String,
    /// What was projected.
    pub(super) scene: String,
    /// What on.
    pub(super) engine: String,
    pub(super) machine: String,
    /// Median time of the plain projection of all views, s.
    pub(super) plain_seconds: f64,
    pub(super) effects: Vec<Row>,
    /// Names, and why they are not there.
    pub(super) left_out: Vec<(String, String)>,
}

/// One effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) name: String,
    /// Its parameters.
    pub(super) what: String,
    pub(super) median_seconds: f64,
    /// Least and most.
    pub(super) spread_seconds: [f64; 2],
    pub(super) runs: usize,
    /// What it adds to the plain projection; of what takes its place, how much more that takes.
    pub(super) marginal_seconds: f64,
    /// The plain projection with it, relative to the plain one; the same of the least and the most.
    pub(super) ratio: f64,
    pub(super) ratio_spread: [f64; 2],
    /// Whether it takes the place of a projection.
    pub(super) instead: bool,
}

impl Report {
    pub(super) fn new(study: &Study<'_>, measured: Vec<Measured>, left_out: Vec<LeftOut>) -> Self {
        let context = &study.setup.context;
        let plain = measured.first().map_or(f64::NAN, |m| median(&m.seconds));
        let mut previous = plain;
        let mut effects = Vec::new();
        for m in measured {
            let (own, [least, most]) = (median(&m.seconds), spread(&m.seconds));
            let base = if m.beside == Beside::Previous { previous } else { plain };
            let ratio = |seconds: f64| 1.0 + (seconds - base) / plain;
            previous = own;
            if m.beside == Beside::Nothing {
                continue;
            }
            effects.push(Row {
                name: m.name.into(),
                what: m.what,
                median_seconds: own,
                spread_seconds: [least, most],
                runs: m.seconds.len(),
                marginal_seconds: own - base,
                ratio: ratio(own),
                ratio_spread: [ratio(least), ratio(most)],
                instead: m.beside == Beside::Instead,
            });
        }
        Self {
            version: drr::VERSION.into(),
            scene: study.name(),
            engine: context.backend().name().into(),
            machine: crate::tradeoff::machine(context),
            plain_seconds: plain,
            effects,
            left_out: left_out.into_iter().map(|(name, why)| (name.into(), why)).collect(),
        }
    }

    /// Reads what [`Self::to_json`] wrote.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        let report: Self = serde_json::from_str(&text)
            .with_context(|| format!("{} is not what drr effects writes", path.display()))?;
        Ok(report)
    }

    pub(super) fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)?)
    }

    pub(super) fn table(&self) -> String {
        let mut lines = vec![
            format!("{}, engine {} on {}", self.scene, self.engine, self.machine),
            format!("  {:<24} {:>10}", "plain", seconds(self.plain_seconds)),
            format!(
                "  {:<24} {:>10} {:>21} {:>8} {:>11}  {}",
                "with", "median", "spread", "ratio", "adds", "parameters"
            ),
        ];
        lines.extend(self.effects.iter().map(Row::line));
        lines.push(
            "  ratio: relative to the plain projection; another spectrum takes the place of a projection"
                .into(),
        );
        lines.extend(self.left_out.iter().map(|(name, why)| format!("  left out: {name}: {why}")));
        lines.join("\n")
    }
}

impl Row {
    fn line(&self) -> String {
        let [least, most] = self.spread_seconds;
        format!(
            "  {:<24} {:>10} {:>21} {:>7.2}x {:>11}  {}",
            self.name,
            seconds(self.median_seconds),
            format!("{}–{}", seconds(least), seconds(most)),
            self.ratio,
            signed(self.marginal_seconds),
            self.what
        )
    }
}

/// With its sign.
fn signed(value: f64) -> String {
    format!("{}{}", if value < 0.0 { '-' } else { '+' }, seconds(value.abs()))
}
