//! The views before and after, and how they converged.

use std::path::Path;

use anyhow::Result;

use super::aligned::Aligned;
use super::observed::Observed;
use super::scene::Scene;
use crate::charts::{BeforeAfter, Compared, Curves, Drawing as _, Scale, Series};
use crate::fit::taken;

/// Most views in the picture and in the chart.
const SHOWN: usize = 8;

pub(super) struct Pictures<'a> {
    pub(super) scene: &'a Scene,
    pub(super) views: &'a [Observed],
    pub(super) aligned: &'a [Aligned],
}

impl<'a> Pictures<'a> {
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        self.before_after().picture()?.write_png(&folder.join("views.png"))?;
        let chart = self.convergence();
        chart.write_svg(&folder.join("convergence.svg"))?;
        chart.write_png(&folder.join("convergence.png"))
    }

    fn before_after(&self) -> BeforeAfter<'a> {
        let geometry = &self.scene.geometry;
        let compared = |(view, aligned): (&'a Observed, &'a Aligned)| Compared {
            caption: format!("phi = {:.2}°", view.nominal.phi.to_degrees()),
            given: &view.image,
            projected: aligned.images.each_ref().map(Vec::as_slice),
            size: geometry.detector,
            pixel: geometry.pixel,
            head_last: self.scene.head_last,
            upright: self.scene.upright_orientation(&view.nominal),
        };
        BeforeAfter {
            title: format!("Views aligned to {}", self.scene.name),
            subtitle: "Measured line integrals, and measured − projected before and after the alignment: blue where \
                less is measured, red where more."
                .into(),
            given: "measured",
            views: self.views.iter().zip(self.aligned).take(SHOWN).map(compared).collect(),
        }
    }

    fn convergence(&self) -> Curves {
        let series = |(n, aligned): (usize, &Aligned)| {
            let steps = taken(&aligned.alignment.levels).into_iter().flatten();
            let points = steps.map(|step| [step.evaluation as f64, step.rms]).collect();
            Series { name: format!("view {n}"), points }
        };
        Curves {
            title: "How the views converge".into(),
            subtitle: format!(
                "{}. Steps that were taken, on coarse voxels first; where a finer level begins, its noise is larger.",
                self.scene.text()
            ),
            x_scale: Scale::Counts,
            x_label: "evaluations of the loss and its derivatives".into(),
            y_label: "residual of the line integrals, RMS as weighted".into(),
            series: self.aligned.iter().take(SHOWN).enumerate().map(series).collect(),
        }
    }
}
