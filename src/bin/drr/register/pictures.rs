//! The views before and after, how the motion was found, and from how far off.

use std::path::Path;

use anyhow::Result;
use drr::geometry::RigidMotion;
use drr::registration::CaptureRow;
use glam::DVec3;

use super::report::Report;
use crate::charts::{BeforeAfter, Compared, Curves, Drawing as _, Scale, Series};
use crate::fit::{Taken, taken};

/// Most views in the picture.
const SHOWN: usize = 4;

pub(super) struct Pictures<'a> {
    pub(super) report: &'a Report<'a>,
}

impl<'a> Pictures<'a> {
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        self.before_after().picture()?.write_png(&folder.join("views.png"))?;
        let charts = [("convergence", Some(self.convergence())), ("capture_range", self.capture_range())];
        for (name, chart) in charts {
            if let Some(chart) = chart {
                chart.write_svg(&folder.join(format!("{name}.svg")))?;
                chart.write_png(&folder.join(format!("{name}.png")))?;
            }
        }
        Ok(())
    }

    fn before_after(&self) -> BeforeAfter<'a> {
        let Report { target, found, views, .. } = self.report;
        let compared = |view: usize| Compared {
            caption: "p = −ln(I/I0)".into(),
            given: &target.images[view],
            projected: found.images[view].each_ref().map(Vec::as_slice),
            size: views.size,
            pixel: [views.poses[view].column_step, views.poses[view].row_step].map(DVec3::length),
            head_last: views.head_last(view),
            upright: views.upright_orientation(view),
        };
        let moved = match self.report.target_errors() {
            Some([before, after]) => format!("mTRE {before:.2} mm before, {after:.3} mm after. "),
            None => String::new(),
        };
        BeforeAfter {
            title: format!("Registration of {}", self.report.name),
            subtitle: format!(
                "{moved}Target line integrals, and target − projected: blue where the target has less, red where more."
            ),
            given: "target",
            views: (0..SHOWN.min(target.images.len())).map(compared).collect(),
        }
    }

    fn convergence(&self) -> Curves {
        let target_error = |truth: &RigidMotion, parameters: [f64; 6]| {
            self.report.error.between(truth, &RigidMotion::from_array(parameters))
        };
        let mut series = Vec::new();
        for (n, steps) in taken(&self.report.found.registration.levels).into_iter().enumerate() {
            let mut curve = |name: &str, value: &dyn Fn(&Taken<6>) -> f64| {
                let points = steps.iter().map(|step| [step.evaluation as f64, value(step)]).collect();
                series.push(Series { name: format!("level {n}: {name}"), points });
            };
            curve("residual, RMS", &|step| step.rms);
            if let Some(truth) = &self.report.target.truth {
                curve("mTRE, mm", &|step| target_error(truth, step.parameters));
            }
        }
        Curves {
            title: "How the motion is found".into(),
            subtitle: format!(
                "{}. Steps that were taken, on coarse voxels and pixels first.",
                self.report.scene()
            ),
            x_scale: Scale::Counts,
            x_label: "evaluations of loss and derivatives".into(),
            y_label: "RMS of line integrals; mm".into(),
            series,
        }
    }

    fn capture_range(&self) -> Option<Curves> {
        let capture = self.report.found.capture.as_ref()?;
        let of = |value: &dyn Fn(&CaptureRow) -> f64| {
            capture.range.rows.iter().map(|row| [row.distance, value(row)]).collect()
        };
        let success = of(&|row| 100.0 * row.successes as f64 / row.starts as f64);
        Some(Curves {
            title: format!("Capture range: {}", capture.distance_mm()),
            subtitle: format!(
                "{}. From {} random starts at each distance; a success ends within {} mm.",
                self.report.scene(),
                capture.range.rows[0].starts,
                capture.success
            ),
            x_scale: Scale::Decades,
            x_label: "mTRE of the start, mm".into(),
            y_label: "percent; mm".into(),
            series: vec![
                Series { name: "starts that succeed, percent".into(), points: success },
                Series { name: "mTRE that is left, median, mm".into(), points: of(&|row| row.median_error) },
            ],
        })
    }
}
