//! The chart, and maps of errors.

use std::path::Path;

use anyhow::Result;
use drr::accuracy::{FLOOR, Sample};
use drr::engine::{Layers, SILENT};
use drr::formats::error_map;
use drr::{Algorithm, Tolerance};

use super::Study;
use super::measured::Measured;
use super::report::Report;
use crate::charts::{Chart, Drawing as _, Point, mark_views, with_colour_bar};
use crate::console::Console;
use crate::times::{median, spread};

/// Pixels of each view of an error map, about.
const MAP_PIXELS: usize = 40_000;
/// Most views of an error map.
const MAP_VIEWS: usize = 2;
/// The part of a map's pixels whose errors are beyond its colours.
const BEYOND: f64 = 0.01;

pub(super) struct Pictures<'a> {
    pub(super) study: &'a Study<'a>,
    pub(super) report: &'a Report,
    pub(super) folder: &'a Path,
}

impl Pictures<'_> {
    pub(super) fn write(&self, console: Console) -> Result<()> {
        if self.report.measured.iter().all(|m| m.errors.hu.is_none()) {
            Console::warn("no ray of these views meets anything: there is nothing to draw");
            return Ok(());
        }
        let chart = self.chart();
        chart.write_svg(&self.folder.join("tradeoff.svg"))?;
        chart.write_png(&self.folder.join("tradeoff.png"))?;
        self.write_maps(console)
    }

    fn chart(&self) -> Chart {
        let point = |(n, m): (usize, &Measured)| {
            let error = m.errors.hu.unwrap_or_default();
            Point {
                name: m.setting.name.clone(),
                group: m.setting.group(),
                seconds: median(&m.seconds),
                seconds_range: spread(&m.seconds),
                error_hu: error.rms,
                error_range: [error.rms, error.rms_high],
                on_front: self.report.is_on_front(n),
                chosen: self.report.chosen == Some(n),
                of_another_model: m.setting.is_of_another_model(),
            }
        };
        Chart {
            title: "What accuracy costs in time".into(),
            subtitle: self.report.scene.clone(),
            points: self.report.measured.iter().enumerate().map(point).collect(),
            limit_hu: Some((Tolerance::STANDARD.hu, "the specification's 2 HU".into())),
        }
    }

    /// One map per method: of the chosen one, of Joseph's rule and of Siddon's lengths.
    fn write_maps(&self, console: Console) -> Result<()> {
        let chosen = self.report.chosen.map(|n| self.report.measured[n].setting.method);
        let methods = [chosen, Some(super::joseph()), Some(Algorithm::Siddon.into())];
        let names = ["chosen", "joseph", "siddon"];
        let poses: Vec<_> = self.study.poses().into_iter().take(MAP_VIEWS).collect();
        let sample = Sample::even(&poses, self.study.scene.detector, MAP_PIXELS);
        let requests = sample.views([0.0; 2]);
        let layers = Layers { line_integral: true, ..Layers::default() };
        let projector = |method| {
            let scene = drr::Scene { detector: sample.size(), method, ..self.study.scene.clone() };
            self.study.projector(scene)
        };
        let bar = console.bar("error maps", 1 + methods.len());
        let exact = projector(super::joseph())?.reference(Algorithm::Exact, &requests, layers, SILENT)?;
        bar.inc(1);
        let floor = FLOOR * exact.line_integral.iter().copied().filter(|p| p.is_finite()).fold(0.0, f64::max);
        for (method, name) in methods.into_iter().zip(names) {
            let Some(method) = method else { continue };
            let images = projector(method)?.project(&requests, layers, SILENT)?;
            let error = |(p, exact): (&f32, &f64)| {
                if *exact > floor { (1000.0 * (f64::from(*p) - exact) / exact) as f32 } else { f32::NAN }
            };
            let errors: Vec<f32> = images.line_integral.iter().zip(&exact.line_integral).map(error).collect();
            let upright: Vec<Vec<f32>> = (0..images.views)
                .map(|view| self.study.views.upright(view, images.view(&errors, view), sample.size()[0]))
                .collect();
            let shown: Vec<&[f32]> = upright.iter().map(Vec::as_slice).collect();
            let sides: Vec<_> =
                (0..shown.len()).map(|view| self.study.views.upright_orientation(view)).collect();
            let range = range(&errors);
            let [width, height] = sample.size();
            let mut map = error_map(&shown, width, height, range)?;
            mark_views(&mut map, sample.size(), &sides)?;
            let map = with_colour_bar(&map, range, "HU")?;
            map.write_png(&self.folder.join(format!("error_{name}.png")))?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(())
    }
}

/// Where the colours end, HU: a round number that few errors are beyond.
fn range(errors: &[f32]) -> f64 {
    let mut sizes: Vec<f32> =
        errors.iter().filter(|error| error.is_finite()).map(|error| error.abs()).collect();
    if sizes.is_empty() {
        return 1.0;
    }
    let rank = ((1.0 - BEYOND) * (sizes.len() - 1) as f64) as usize;
    let most = f64::from(*sizes.select_nth_unstable_by(rank, f32::total_cmp).1).max(1e-6);
    let decade = 10_f64.powf(most.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|step| step * decade).find(|step| *step >= most).unwrap_or(most)
}
