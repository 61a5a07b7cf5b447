//! What a joint reconstruction leaves.

use std::path::Path;

use anyhow::Result;
use serde_json::json;

use super::{Joint, Misaligned, Round};
use crate::charts::{Curves, Drawing as _, Scale, Series};
use crate::reconstruct::Scan;
use crate::reconstruct::method::{Found, MethodArguments};
use crate::reconstruct::pictures::{Picture, Shown};
use crate::reconstruct::report::write_nifti;
use crate::value::seconds;

pub(in crate::reconstruct) struct Report<'a> {
    pub(in crate::reconstruct) scan: &'a Scan,
    pub(in crate::reconstruct) method: &'a MethodArguments,
    pub(in crate::reconstruct) joint: &'a Joint,
}

impl Report<'_> {
    /// Writes all but the JSON.
    pub(in crate::reconstruct) fn write(&self, folder: &Path) -> Result<()> {
        let after = self.scan.hu(&self.joint.after.volume);
        write_nifti(&folder.join("reconstruction.nii.gz"), &self.scan.grid, &after)?;
        super::write_found(folder, self.joint)?;
        self.picture(&after, &folder.join("reconstruction.png"))?;
        let chart = self.chart();
        chart.write_svg(&folder.join("convergence.svg"))?;
        chart.write_png(&folder.join("convergence.png"))
    }

    fn picture(&self, after: &[f32], path: &Path) -> Result<()> {
        let before = self.scan.hu(&self.joint.before.volume);
        let truth = self.scan.truth.as_ref().map(|truth| self.scan.hu(&truth.values));
        let best = self.joint.best.as_ref().map(|best| self.scan.hu(&best.volume));
        let error = |own: &[f32]| -> Option<Vec<f32>> {
            truth.as_ref().map(|truth| own.iter().zip(truth).map(|(own, truth)| own - truth).collect())
        };
        let errors = [("error, as thought", error(&before)), ("error, joint", error(after))];
        let shown = |name: &str, caption: String, values| Shown { name: name.into(), caption, values };
        let mut volumes: Vec<Shown<'_>> =
            truth.iter().map(|truth| shown("truth", "means of blocks of voxels".into(), truth)).collect();
        volumes.push(shown("views as thought", quality(&self.joint.before), &before));
        volumes.push(shown("joint", quality(&self.joint.after), after));
        if let (Some(best), Some(found)) = (&best, &self.joint.best) {
            volumes.push(shown("views as they are", quality(found), best));
        }
        let errors = errors.iter().filter_map(|(name, error)| {
            error.as_ref().map(|error| shown(name, "result − truth, HU".into(), error))
        });
        Picture {
            title: format!("Joint alignment and reconstruction of {}", self.scan.name),
            subtitle: format!("{} by {}.", self.scan.describe(), self.method.describe()),
            grid: &self.scan.grid,
            volumes,
            errors: errors.collect(),
        }
        .write(path)
    }

    fn chart(&self) -> Curves {
        let rounds = &self.joint.rounds;
        let numbered = |value: &dyn Fn(&Round) -> Option<f64>| {
            let point = |(n, round): (usize, &Round)| value(round).map(|value| [(n + 1) as f64, value]);
            rounds.iter().enumerate().filter_map(point).collect::<Vec<_>>()
        };
        let error = |value: fn(Misaligned) -> f64| numbered(&|round| round.errors.map(value));
        let series = [
            ("errors of angles, degrees", error(|error| error.degrees)),
            ("errors of translations, mm", error(|error| error.mm)),
            ("residual, percent of the data", numbered(&|round| Some(100.0 * round.residual))),
        ];
        let series = series.into_iter().filter(|(_, points)| !points.is_empty());
        Curves {
            title: "Where views are and what they show, found together".into(),
            subtitle: format!(
                "{}: {}. Root mean squares over all views, after the best motion in common; round 1 is the start.",
                self.scan.name,
                self.scan.describe()
            ),
            x_scale: Scale::Counts,
            x_label: "round".into(),
            y_label: "degrees, mm, percent".into(),
            series: series.map(|(name, points)| Series { name: name.into(), points }).collect(),
        }
    }

    pub(in crate::reconstruct) fn to_json(&self) -> serde_json::Value {
        let round = |round: &Round| {
            json!({
                "residual": round.residual,
                "degrees_rms": round.errors.map(|error| error.degrees),
                "mm_rms": round.errors.map(|error| error.mm),
            })
        };
        let found =
            |found: &Found| json!({ "residual": found.residuals.last(), "rmse_hu": found.rmse_hu.last() });
        json!({
            "version": drr::VERSION,
            "input": self.scan.name,
            "energy_keV": self.scan.kev,
            "water_per_mm": self.scan.water,
            "volume": self.scan.grid.dimensions(),
            "views": self.scan.geometry.count(),
            "detector": self.scan.geometry.size(),
            "method": self.method.describe(),
            "rounds": self.joint.rounds.iter().map(round).collect::<Vec<_>>(),
            "views_as_thought": found(&self.joint.before),
            "joint": found(&self.joint.after),
            "views_as_they_are": self.joint.best.as_ref().map(found),
            "seconds": {
                "data": self.scan.seconds,
                "alignment": self.joint.seconds,
                "reconstruction": self.joint.after.seconds,
            },
        })
    }

    pub(in crate::reconstruct) fn table(&self) -> String {
        let mut lines = vec!["round   angles, °   shifts, mm   residual".into()];
        for (n, Round { residual, errors }) in self.joint.rounds.iter().enumerate() {
            let [degrees, mm] = match errors {
                Some(Misaligned { degrees, mm }) => [format!("{degrees:.4}"), format!("{mm:.4}")],
                None => [String::new(), String::new()],
            };
            lines.push(format!("{:>5}   {degrees:>9}   {mm:>10}   {residual:.3e}", n + 1));
        }
        let row = |name: &str, found: &Found| format!("{name:22}{}", quality(found));
        lines.push(row("views as thought", &self.joint.before));
        lines.push(row("joint", &self.joint.after));
        lines.extend(self.joint.best.as_ref().map(|best| row("views as they are", best)));
        lines.push(format!(
            "time    data in {}, alignment in {}, each reconstruction in {}",
            seconds(self.scan.seconds),
            seconds(self.joint.seconds),
            seconds(self.joint.after.seconds)
        ));
        lines.join("\n")
    }
}

fn quality(found: &Found) -> String {
    let Some(residual) = found.residuals.last() else { return "no iteration: nothing fits better".into() };
    match found.rmse_hu.last() {
        Some(rmse) => format!("RMSE {rmse:.1} HU, residual {residual:.1e}"),
        None => format!("residual {residual:.1e}"),
    }
}
