//! The numbers, as a table and as JSON.

use drr::accuracy::CONFIDENCE;
use drr::planner::Choice;
use serde_json::json;

use super::Study;
use super::measured::Measured;
use crate::certificate::short;
use crate::times::{median, spread};
use crate::value::seconds;

/// Everything that was measured.
pub(super) struct Report {
    pub(super) scene: String,
    pub(super) measured: Vec<Measured>,
    pub(super) choice: Choice,
    planning_seconds: f64,
    /// Place of the chosen one.
    pub(super) chosen: Option<usize>,
    /// Time of the chosen one over that of the fastest candidate that was measured to keep the tolerance.
    regret: Option<f64>,
}

impl Report {
    pub(super) fn new(
        study: &Study<'_>,
        mut measured: Vec<Measured>,
        choice: Choice,
        planning_seconds: f64,
    ) -> Self {
        measured.sort_by(|a, b| median(&a.seconds).total_cmp(&median(&b.seconds)));
        let chosen = measured.iter().position(|m| Study::is_chosen(&choice, &m.setting));
        let keeps = |m: &&Measured| {
            let within =
                |error: Option<drr::accuracy::Estimate>, most: f64| error.is_none_or(|e| e.rms <= most);
            m.setting.is_candidate()
                && m.errors.hu.is_some()
                && within(m.errors.hu, study.tolerance.hu)
                && within(m.errors.mm, study.tolerance.mm)
        };
        let fastest = measured.iter().find(keeps).map(|m| median(&m.seconds));
        let regret = chosen.zip(fastest).map(|(n, fastest)| median(&measured[n].seconds) / fastest);
        let [n0, n1, n2] = study.volume.grid().dimensions();
        let [width, height] = study.scene.detector;
        let context = &study.setup.context;
        let scene = format!(
            "{}: {n0}×{n1}×{n2} voxels, {} view(s) of {width}×{height} pixels, engine {} on {}",
            study.setup.name(),
            study.views.poses.len(),
            context.backend().name(),
            super::machine(context),
        );
        Self { scene, measured, choice, planning_seconds, chosen, regret }
    }

    /// Whether no other setting that computes the same is both faster and more accurate.
    pub(super) fn is_on_front(&self, n: usize) -> bool {
        let error = |m: &Measured| m.errors.hu.map_or(0.0, |e| e.rms);
        let own = &self.measured[n];
        let better = |m: &Measured| !m.setting.is_of_another_model() && error(m) <= error(own);
        own.errors.hu.is_some()
            && !own.setting.is_of_another_model()
            && !self.measured[..n].iter().any(better)
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        let row = |(n, m): (usize, &Measured)| {
            let [least, most] = spread(&m.seconds);
            json!({
                "setting": m.setting.name,
                "method": m.setting.method,
                "supersampling": m.setting.supersampling,
                "early_exit": m.setting.early_exit,
                "energies": m.energies,
                "median_seconds": median(&m.seconds),
                "min_seconds": least,
                "max_seconds": most,
                "runs": m.seconds.len(),
                "predicted_seconds": m.predicted,
                "errors": m.errors,
                "pixel_area_hu": m.area,
                "difference_of_model": m.setting.is_of_another_model(),
                "on_front": self.is_on_front(n),
                "chosen": self.chosen == Some(n),
            })
        };
        json!({
            "version": drr::VERSION,
            "scene": self.scene,
            "confidence": CONFIDENCE,
            "settings": self.measured.iter().enumerate().map(row).collect::<Vec<_>>(),
            "choice": self.choice,
            "planning_seconds": self.planning_seconds,
            "chosen_over_fastest": self.regret,
        })
    }

    pub(super) fn table(&self) -> String {
        let mut lines = vec![
            self.scene.clone(),
            format!(
                "  {:<34} {:>10} {:>17} {:>8} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8}",
                "setting",
                "median",
                "spread",
                "model",
                "HU RMSE",
                "+sampling",
                "HU max",
                "rel. L2",
                "mm",
                "area HU"
            ),
        ];
        for (n, m) in self.measured.iter().enumerate() {
            let mark = match (self.chosen == Some(n), self.is_on_front(n)) {
                (true, _) => ">",
                (_, true) => "*",
                _ => " ",
            };
            let [least, most] = spread(&m.seconds);
            let [rms, high, max] = m
                .errors
                .hu
                .map_or(["-"; 3].map(String::from), |e| [e.rms, e.rms_high - e.rms, e.max].map(short));
            lines.push(format!(
                "{mark} {:<34} {:>10} {:>17} {:>7.2}x {rms:>9} {high:>9} {max:>8} {:>8} {:>8} {:>8}",
                m.setting.name,
                seconds(median(&m.seconds)),
                format!("{}–{}", seconds(least), seconds(most)),
                m.predicted / median(&m.seconds),
                format!("{:.1e}", m.errors.relative_l2),
                m.errors.mm.map_or("-".into(), |e| short(e.rms)),
                m.area.map_or("-".into(), |e| short(e.rms)),
            ));
        }
        lines.extend(self.notes());
        lines.join("\n")
    }

    fn notes(&self) -> Vec<String> {
        let rays = self.measured.iter().find_map(|m| m.errors.hu).map_or(0, |e| e.rays);
        let mut notes = vec![
            format!(
                "  * none is both faster and more accurate; > chosen for {}; model: predicted time over measured",
                self.choice.tolerance
            ),
            format!(
                "  HU: 1000 (p - p_exact)/p_exact over {rays} rays, of all rays at most RMSE + sampling ({:.0} % confidence);",
                100.0 * CONFIDENCE
            ),
            "  mm: displacement of edges that would explain it; area: against the mean over the pixel; Siddon, distance_driven: a \
             difference of model"
                .into(),
        ];
        let regret = self.regret.map_or(String::new(), |r| {
            format!("; the chosen method took {r:.2} times as long as the fastest that keeps the tolerance")
        });
        notes.push(format!("  planning took {}{regret}", seconds(self.planning_seconds)));
        notes
    }
}
