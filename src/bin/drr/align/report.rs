//! The numbers, as a table, as JSON and as CSV.

use anyhow::Result;
use drr::alignment::Solution;
use drr::formats::VIEW_COLUMNS;
use drr::parallel::ViewParameters;
use serde::Serialize;

use super::aligned::Aligned;
use super::observed::Observed;
use crate::fit::{in_degrees, stop_name};
use crate::value::seconds;

/// What is promised of simulated views: degrees, and mm.
pub(super) const PROMISE: [f64; 2] = [0.02, 0.05];
/// Of the parameters, in their order.
const NAMES: [&str; 5] = ["α", "β", "φ", "Δx", "Δz"];

/// Everything that was found, as `align.json` has it. Angles in degrees, translations in mm, in the order α, β, φ, Δx,
/// Δz.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Report {
    version: &'static str,
    /// What was projected.
    scene: String,
    photons: Option<f64>,
    levels: usize,
    /// Of all views, where the truth is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    errors: Option<Errors>,
    seconds: f64,
    views: Vec<Row>,
}

/// Sizes of errors.
#[derive(Debug, Clone, Serialize)]
struct Errors {
    mean_before: [f64; 5],
    max_before: [f64; 5],
    mean_after: [f64; 5],
    max_after: [f64; 5],
    /// Whether all are below 0.02 degrees and 0.05 mm.
    promise_kept: bool,
}

/// One view.
#[derive(Debug, Clone, Serialize)]
struct Row {
    nominal: [f64; 5],
    aligned: [f64; 5],
    standard_deviations: Option<[f64; 5]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    truth: Option<[f64; 5]>,
    residual_rms_before: f64,
    residual_rms_after: f64,
    /// On each level, the coarsest first.
    evaluations: Vec<usize>,
    stop: &'static str,
    converged: bool,
    /// What is wrong where it did not converge.
    #[serde(skip_serializing_if = "Option::is_none")]
    doubt: Option<String>,
    seconds: f64,
}

impl Report {
    pub(super) fn new(
        scene: String,
        photons: Option<f64>,
        levels: usize,
        views: &[Observed],
        aligned: &[Aligned],
    ) -> Self {
        let rows: Vec<Row> =
            views.iter().zip(aligned).map(|(view, aligned)| Row::new(view, aligned)).collect();
        let seconds = aligned.iter().map(|aligned| aligned.seconds).sum();
        Self {
            version: drr::VERSION,
            scene,
            photons,
            levels,
            errors: Errors::of(&rows),
            seconds,
            views: rows,
        }
    }

    pub(super) fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)?)
    }

    /// The aligned parameters: what `--views` reads, and more.
    pub(super) fn csv(&self) -> String {
        let deviations = VIEW_COLUMNS.map(|name| format!("sd_{name}"));
        let mut lines =
            vec![format!("view,{},{},residual_rms", VIEW_COLUMNS.join(","), deviations.join(","))];
        for (n, row) in self.views.iter().enumerate() {
            let numbers = row.aligned.iter().map(ToString::to_string);
            let deviations =
                (0..5).map(|k| row.standard_deviations.map_or(String::new(), |sd| sd[k].to_string()));
            let cells: Vec<String> = numbers.chain(deviations).collect();
            lines.push(format!("{n},{},{}", cells.join(","), row.residual_rms_after));
        }
        lines.join("\n") + "\n"
    }

    pub(super) fn table(&self) -> String {
        let mut lines = vec![self.scene.clone()];
        if let Some(errors) = &self.errors {
            lines.extend(errors.lines());
        }
        lines.push(self.mean_deviations());
        lines.push("  view      moved by α, β, φ (degrees), Δx, Δz (mm)        residual before → after  evaluations     time".into());
        lines.extend(self.views.iter().enumerate().map(|(n, row)| row.line(n)));
        lines.push(format!("  all views in {}", seconds(self.seconds)));
        lines.join("\n")
    }

    /// Views whose parameters are not to be relied on, in words.
    pub(super) fn doubts(&self) -> Option<String> {
        let doubts: Vec<_> = self.views.iter().map(|row| row.doubt.as_deref()).collect();
        let (view, first) = doubts.iter().enumerate().find_map(|(n, doubt)| Some((n, (*doubt)?)))?;
        let count = doubts.iter().flatten().count();
        Some(format!("{count} of {} views did not converge; view {view}: {first}", doubts.len()))
    }

    fn mean_deviations(&self) -> String {
        let known: Vec<[f64; 5]> = self.views.iter().filter_map(|row| row.standard_deviations).collect();
        if known.is_empty() {
            return "  standard deviations: the images do not tell all five parameters".into();
        }
        let mean: [f64; 5] =
            std::array::from_fn(|k| known.iter().map(|sd| sd[k]).sum::<f64>() / known.len() as f64);
        numbers("standard deviation", &mean)
    }
}

impl Errors {
    fn of(rows: &[Row]) -> Option<Self> {
        let sizes = |of: fn(&Row) -> [f64; 5]| -> Option<Vec<[f64; 5]>> {
            let size = |row: &Row| {
                let (own, truth) = (of(row), row.truth?);
                Some(std::array::from_fn(|k| (own[k] - truth[k]).abs()))
            };
            rows.iter().map(size).collect()
        };
        let (before, after) = (sizes(|row| row.nominal)?, sizes(|row| row.aligned)?);
        let mean = |sizes: &[[f64; 5]]| {
            std::array::from_fn(|k| sizes.iter().map(|size| size[k]).sum::<f64>() / sizes.len() as f64)
        };
        let max = |sizes: &[[f64; 5]]| -> [f64; 5] {
            std::array::from_fn(|k| sizes.iter().map(|size| size[k]).fold(0.0, f64::max))
        };
        let max_after = max(&after);
        let promise_kept = (0..5).all(|k| max_after[k] < PROMISE[usize::from(k > 2)]);
        Some(Self {
            mean_before: mean(&before),
            max_before: max(&before),
            mean_after: mean(&after),
            max_after,
            promise_kept,
        })
    }

    fn lines(&self) -> Vec<String> {
        let head = NAMES.map(|name| format!("{name:>11}")).concat();
        let [degrees, mm] = PROMISE;
        let kept = if self.promise_kept { "all errors are below" } else { "not all errors are below" };
        vec![
            format!("  {:<22}{head}   (degrees, mm)", "errors"),
            numbers("before, mean", &self.mean_before),
            numbers("before, largest", &self.max_before),
            numbers("after, mean", &self.mean_after),
            numbers("after, largest", &self.max_after),
            format!("  {kept} {degrees} degrees and {mm} mm"),
        ]
    }
}

fn numbers(name: &str, values: &[f64; 5]) -> String {
    let values = values.map(|value| format!("{value:>11.5}")).concat();
    format!("  {name:<22}{values}")
}

impl Row {
    fn new(view: &Observed, aligned: &Aligned) -> Self {
        let alignment = &aligned.alignment;
        let evaluations = |level: &Solution<{ ViewParameters::COUNT }>| level.steps.len();
        let [before, after] = aligned.residuals;
        let doubt = alignment.levels.last().and_then(|finest| finest.doubt(NAMES));
        Self {
            nominal: in_degrees(view.nominal.to_array()),
            aligned: in_degrees(alignment.parameters.to_array()),
            standard_deviations: alignment.standard_deviations.map(in_degrees),
            truth: view.truth.map(|truth| in_degrees(truth.to_array())),
            residual_rms_before: before,
            residual_rms_after: after,
            evaluations: alignment.levels.iter().map(evaluations).collect(),
            stop: stop_name(alignment.stop()),
            converged: alignment.levels.finest().converged(),
            doubt,
            seconds: aligned.seconds,
        }
    }

    fn line(&self, view: usize) -> String {
        let moved = [0, 1, 2, 3, 4].map(|k| format!("{:>+10.4}", self.aligned[k] - self.nominal[k])).concat();
        let evaluations: Vec<String> = self.evaluations.iter().map(ToString::to_string).collect();
        format!(
            "  {view:<4}{moved}      {:>8.5} → {:<8.5}  {:>11}  {:>9}{}",
            self.residual_rms_before,
            self.residual_rms_after,
            evaluations.join("+"),
            seconds(self.seconds),
            self.doubt.as_ref().map_or(String::new(), |doubt| format!("  {doubt}"))
        )
    }
}
