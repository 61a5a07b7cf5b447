//! What a registration found, as a table and as JSON.

use drr::alignment::Solution;
use drr::geometry::RigidMotion;
use drr::registration::{CaptureRow, TargetError};
use serde_json::json;

use super::target::Target;
use super::{Capture, Found};
use crate::fit::{in_degrees, stop_name};
use crate::rms::{rms, rmse};
use crate::value::seconds;
use crate::views::Views;

/// The parameters' names and units.
const PARAMETERS: [(&str, &str); 6] =
    [("alpha", "°"), ("beta", "°"), ("phi", "°"), ("x", "mm"), ("y", "mm"), ("z", "mm")];

pub(super) struct Report<'a> {
    pub(super) name: &'a str,
    pub(super) views: &'a Views,
    pub(super) target: &'a Target,
    pub(super) found: &'a Found,
    pub(super) error: &'a TargetError,
}

impl Report<'_> {
    /// In words.
    pub(super) fn scene(&self) -> String {
        let [width, height] = self.views.size;
        format!("{}, {} views of {width}×{height} pixels", self.name, self.views.poses.len())
    }

    /// mTRE before and after, mm.
    pub(super) fn target_errors(&self) -> Option<[f64; 2]> {
        let truth = self.target.truth.as_ref()?;
        Some([RigidMotion::default(), self.found.registration.motion].map(|m| self.error.between(truth, &m)))
    }

    /// RMS of target − projected, before and after.
    pub(super) fn residuals(&self) -> [f64; 2] {
        // Of views of the same size.
        let views = || self.target.images.iter().zip(&self.found.images);
        [0, 1].map(|k| rms(views().map(|(target, images)| rmse(target, &images[k]))))
    }

    /// Why the motion is not to be relied on, in words.
    pub(super) fn doubt(&self) -> Option<String> {
        self.found.registration.levels.last()?.doubt(PARAMETERS.map(|(name, _)| name))
    }

    pub(super) fn table(&self) -> String {
        let registration = &self.found.registration;
        let truth = self.target.truth.map(degrees_and_mm);
        let found = degrees_and_mm(registration.motion);
        let sigma = registration.standard_deviations().map(in_degrees);
        let mut lines = vec![self.scene(), "              hidden      found      error      sigma".into()];
        let number = |value: Option<f64>| value.map_or(" ".repeat(10), |value| format!("{value:>10.4}"));
        for (k, (name, unit)) in PARAMETERS.into_iter().enumerate() {
            let (hidden, sigma) = (truth.map(|truth| truth[k]), sigma.map(|sigma| sigma[k]));
            let error = hidden.map(|hidden| found[k] - hidden);
            let [hidden, own, error, sigma] = [hidden, Some(found[k]), error, sigma].map(number);
            lines.push(format!("{name:>6} {unit:<2} {hidden} {own} {error} {sigma}"));
        }
        if let Some([before, after]) = self.target_errors() {
            lines.push(format!("mTRE    {before:.4} mm before, {after:.4} mm after"));
        }
        let [before, after] = self.residuals();
        lines.push(format!("left    {before:.4} RMS of the line integrals before, {after:.4} after"));
        lines.push(format!(
            "time    {} on {} levels, {} evaluations; {}",
            seconds(self.found.seconds),
            registration.levels.len(),
            registration.evaluations(),
            self.doubt().unwrap_or_else(|| registration.stop().to_string())
        ));
        lines.extend(self.captured());
        lines.join("\n")
    }

    fn captured(&self) -> Vec<String> {
        let Some(capture) = &self.found.capture else { return vec![] };
        let mut lines = vec!["starts at, mTRE      found      median left".into()];
        for row in &capture.range.rows {
            lines.push(format!(
                "{:>14.1} mm   {:>3} of {:<3}   {:>10.4} mm",
                row.distance, row.successes, row.starts, row.median_error
            ));
        }
        lines.push(format!(
            "capture range {}: 95 % of the starts up to there end within {} mm; in {}",
            capture.distance_mm(),
            capture.success,
            seconds(capture.seconds)
        ));
        lines
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        let registration = &self.found.registration;
        let capture = self.found.capture.as_ref().map(|capture| {
            let row = |row: &CaptureRow| {
                json!({
                    "distance_mm": row.distance,
                    "starts": row.starts,
                    "successes": row.successes,
                    "median_error_mm": row.median_error,
                    "largest_success_mm": row.largest_success,
                })
            };
            json!({
                "capture_range_mm": capture.range.distance(),
                "success_mm": capture.success,
                "rows": capture.range.rows.iter().map(row).collect::<Vec<_>>(),
                "seconds": capture.seconds,
            })
        });
        let level =
            |level: &Solution<6>| json!({ "steps": level.steps.len(), "stop": stop_name(level.stop) });
        json!({
            "version": drr::VERSION,
            "input": self.name,
            "detector": self.views.size,
            "views": self.views.poses.len(),
            "parameters": PARAMETERS.map(|(name, unit)| format!("{name}_{}", if unit == "°" { "degrees" } else { unit })),
            "hidden": self.target.truth.map(degrees_and_mm),
            "found": degrees_and_mm(registration.motion),
            "standard_deviations": registration.standard_deviations().map(in_degrees),
            "covariance_radians_mm": registration.covariance,
            "mtre_mm": self.target_errors(),
            "residual_rms": self.residuals(),
            "levels": registration.levels.iter().map(level).collect::<Vec<_>>(),
            "converged": self.found.registration.levels.finest().converged(),
            "doubt": self.doubt(),
            "seconds": self.found.seconds,
            "capture": capture,
        })
    }
}

impl Capture {
    /// The capture range in words; where no start failed it may be larger.
    pub(super) fn distance_mm(&self) -> String {
        let distance = self.range.distance();
        let all = self.range.rows.last().is_some_and(|row| row.distance == distance);
        format!("{}{distance} mm", if all { "at least " } else { "" })
    }
}

fn degrees_and_mm(motion: RigidMotion) -> [f64; 6] {
    in_degrees(motion.to_array())
}
