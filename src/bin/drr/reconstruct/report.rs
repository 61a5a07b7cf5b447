//! What a reconstruction leaves: volume, picture, chart, numbers.

use std::path::Path;

use anyhow::Result;
use drr::formats::NiftiWriter;
use drr::geometry::Grid;
use serde_json::json;

use super::Scan;
use super::method::{Found, MethodArguments};
use super::pictures::{Picture, Shown};
use crate::charts::{Curves, Drawing as _, Scale, Series};
use crate::rms::rms;
use crate::value::seconds;

/// Where there was no iteration.
const NOTHING: &str =
    "no iteration: data are 0, or no ray meets the volume, and 0 fits them as well as any volume";

pub(super) struct Report<'a> {
    pub(super) scan: &'a Scan,
    pub(super) method: &'a MethodArguments,
    pub(super) found: &'a Found,
}

impl Report<'_> {
    /// Writes all but the JSON.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let hu = self.scan.hu(&self.found.volume);
        write_nifti(&folder.join("reconstruction.nii.gz"), &self.scan.grid, &hu)?;
        self.picture(&hu, &folder.join("reconstruction.png"))?;
        let chart = self.chart();
        chart.write_svg(&folder.join("convergence.svg"))?;
        chart.write_png(&folder.join("convergence.png"))
    }

    fn picture(&self, hu: &[f32], path: &Path) -> Result<()> {
        let Found { residuals, rmse_hu, .. } = self.found;
        let caption = |residual: f64, rmse: Option<&f64>| match rmse {
            Some(rmse) => format!("RMSE {rmse:.1} HU"),
            None => format!("residual {residual:.2e}"),
        };
        let first = self.scan.hu(&self.found.first);
        let truth = self.scan.truth.as_ref().map(|truth| self.scan.hu(&truth.values));
        let error: Option<Vec<f32>> =
            truth.as_ref().map(|truth| hu.iter().zip(truth).map(|(own, truth)| own - truth).collect());
        let shown = |name: &str, caption: String, values| Shown { name: name.into(), caption, values };
        let mut volumes: Vec<Shown<'_>> =
            truth.iter().map(|truth| shown("truth", "means of blocks of voxels".into(), truth)).collect();
        if let (Some(&initial), Some(&last)) = (residuals.first(), residuals.last()) {
            volumes.push(shown("first iteration", caption(initial, rmse_hu.first()), &first));
            let name = format!("iteration {}", residuals.len());
            volumes.push(shown(&name, caption(last, rmse_hu.last()), hu));
        } else {
            volumes.push(shown("start", "no iteration: nothing fits better".into(), hu));
        }
        let errors = error.iter().map(|error| shown("error", "result − truth, HU".into(), error)).collect();
        Picture {
            title: format!("Reconstruction of {}", self.scan.name),
            subtitle: format!("{} by {}.", self.scan.describe(), self.method.describe()),
            grid: &self.scan.grid,
            volumes,
            errors,
        }
        .write(path)
    }

    fn chart(&self) -> Curves {
        let numbered = |values: &[f64], scale: f64| {
            let point = |(n, value): (usize, &f64)| [(n + 1) as f64, value * scale];
            values.iter().enumerate().map(point).collect::<Vec<_>>()
        };
        let mut series = vec![Series {
            name: "residual |b − Ax| / |b|".into(),
            points: numbered(&self.found.residuals, 1.0),
        }];
        if let Some(truth) = &self.scan.truth {
            let size = 1000.0 / self.scan.water * rms(truth.values.iter().map(|&value| value.into()));
            series.push(Series {
                name: format!("RMSE / {size:.0} HU, the truth's root mean square"),
                points: numbered(&self.found.rmse_hu, 1.0 / size),
            });
        }
        Curves {
            title: format!("Convergence of {}", self.method.describe()),
            subtitle: format!("{}: {}", self.scan.name, self.scan.describe()),
            x_scale: Scale::Counts,
            x_label: "iteration".into(),
            y_label: "relative to data and truth".into(),
            series,
        }
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        let [width, height] = self.scan.geometry.size();
        let last = |values: &[f64]| values.last().copied();
        json!({
            "version": drr::VERSION,
            "input": self.scan.name,
            "energy_keV": self.scan.kev,
            "water_per_mm": self.scan.water,
            "volume": self.scan.grid.dimensions(),
            "index_to_world": self.scan.grid.index_to_world().to_cols_array(),
            "views": self.scan.geometry.count(),
            "detector": [width, height],
            "method": self.method.describe(),
            "iterations": self.found.residuals.len(),
            "residuals": self.found.residuals,
            "rmse_hu": self.found.rmse_hu,
            "residual": last(&self.found.residuals),
            "final_rmse_hu": last(&self.found.rmse_hu),
            "seconds": { "data": self.scan.seconds, "reconstruction": self.found.seconds },
        })
    }

    pub(super) fn table(&self) -> String {
        let Found { residuals, rmse_hu, .. } = self.found;
        let mut lines = vec![format!("method  {}, {} iterations", self.method.describe(), residuals.len())];
        let Some(last) = residuals.len().checked_sub(1) else {
            lines.push(format!("        {NOTHING}"));
            return lines.join("\n");
        };
        let mut shown = vec![0, last / 4, last / 2, last];
        shown.dedup();
        for n in shown {
            let rmse = rmse_hu.get(n).map_or(String::new(), |rmse| format!("   RMSE {rmse:7.1} HU"));
            lines.push(format!("        iteration {:>4}   residual {:.3e}{rmse}", n + 1, residuals[n]));
        }
        if let Some((best, rmse)) = rmse_hu.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)) {
            lines.push(format!("error   least RMSE {rmse:.1} HU, in iteration {}", best + 1));
        }
        let per_iteration = self.found.seconds / residuals.len() as f64;
        lines.push(format!(
            "time    data in {}, reconstruction in {}, {} per iteration",
            seconds(self.scan.seconds),
            seconds(self.found.seconds),
            seconds(per_iteration)
        ));
        lines.join("\n")
    }
}

/// Whole HU; what lies beyond int16 is at its end.
pub(super) fn write_nifti(path: &Path, grid: &Grid, hu: &[f32]) -> Result<()> {
    let [n0, n1, _] = grid.dimensions();
    let mut file = NiftiWriter::<i16>::create(path, grid)?;
    for slice in hu.chunks(n0 * n1) {
        let whole: Vec<i16> = slice.iter().map(|hu| hu.round() as i16).collect();
        file.push_slice(&whole)?;
    }
    Ok(file.finish()?)
}
