//! How the projection's time grows: with threads, pixels, voxels and views, each alone.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context as _, Result};
use drr::engine::{Layers, SILENT};
use drr::formats::write_text;
use drr::phantom::Phantom;
use drr::volume::{Volume, VolumeBuilder};
use drr::{Context, Projector};
use serde_json::json;

use crate::bench::times::Times;
use crate::charts::{Drawing as _, Growth, GrowthSheet};
use crate::console::Console;
use crate::inputs::Setup;
use crate::output::prepare;
use crate::times::{median, spread};
use crate::value::seconds;
use crate::views::ViewArguments;

/// How often the largest volume's and detector's sides are halved, and what is held of them while something else grows.
const VOLUMES: u32 = 3;
const DETECTORS: u32 = 4;
const HELD: usize = 4;
/// Views lie so far apart at most, degrees: of a stereo pair, so that all cost the same.
const ANGLES: f64 = 12.0;
/// A point that takes so long, s, has fewer runs, but not fewer than this.
const LONG: f64 = 8.0;
const FEWEST: usize = 3;

/// The largest voxels per side, pixels per side, and views; each at least 1.
pub(super) type Most = [usize; 3];

/// Times of growing counts of one thing.
struct Series {
    name: &'static str,
    growth: Growth,
    steps: Vec<(usize, Times)>,
}

/// What is projected, and how often.
struct Stand<'a> {
    setup: &'a Setup<'a>,
    runs: u32,
    console: Console,
}

/// Voxels per side, pixels per side, views.
#[derive(Clone, Copy)]
struct Size {
    voxels: usize,
    pixels: usize,
    views: usize,
}

/// `drr bench --scaling`.
pub(super) fn run(
    setup: &Setup<'_>,
    most: Most,
    (runs, folder): (u32, &Path),
    as_json: bool,
    console: Console,
) -> Result<ExitCode> {
    prepare(folder)?;
    let all_series = Stand { setup, runs, console }.all_series(most)?;
    let context = &setup.context;
    let report = json!({
        "engine": context.backend().name(),
        "device": context.device_name().to_string_lossy(),
        "algorithm": setup.method.to_string(),
        "threads": context.threads(),
        "version": drr::VERSION,
        "series": all_series.each_ref().map(Series::to_json),
    });
    write_text(&folder.join("scaling.json"), &format!("{report:#}\n"))?;
    if as_json {
        Console::answer(&report);
    }
    let scene = format!("{} on {}", setup.method, context.backend().name());
    for series in &all_series {
        series.say(&scene, console);
    }
    let sheet = GrowthSheet {
        title: "How the time of a projection grows".into(),
        subtitle: format!(
            "{scene}, a thorax with noise; {} threads where they do not grow.",
            context.threads()
        ),
        panels: all_series.map(|series| series.growth),
    };
    sheet.write_svg(&folder.join("scaling.svg"))?;
    sheet.write_png(&folder.join("scaling.png"))?;
    Ok(ExitCode::SUCCESS)
}

impl Stand<'_> {
    fn all_series(&self, [voxels, pixels, views]: Most) -> Result<[Series; 4]> {
        let held = Size { voxels: voxels.div_ceil(HELD), pixels: pixels.div_ceil(HELD), views: 1 };
        let context = &self.setup.context;
        let volume = self.volume(held.voxels)?;
        let on = |threads: usize| match threads {
            all if all == context.work_threads() => Ok(context.clone()),
            fewer => Context::new(context.backend(), fewer).context("--threads"),
        };
        let threads = self.series("threads", -1.0, held, doubled(context.work_threads()), |threads| {
            self.times(&on(threads)?, &volume, held)
        })?;
        let detectors = self.series("pixels per side", 2.0, held, halved(pixels, DETECTORS), |pixels| {
            self.times(context, &volume, Size { pixels, ..held })
        })?;
        let volumes = self.series("voxels per side", 1.0, held, halved(voxels, VOLUMES), |voxels| {
            self.times(context, &self.volume(voxels)?, Size { voxels, ..held })
        })?;
        let views = self.series("views", 1.0, held, doubled(views), |views| {
            self.times(context, &volume, Size { views, ..held })
        })?;
        Ok([threads, detectors, volumes, views])
    }

    fn series(
        &self,
        name: &'static str,
        power: f64,
        held: Size,
        counts: Vec<usize>,
        times: impl Fn(usize) -> Result<Times>,
    ) -> Result<Series> {
        let bar = self.console.bar(name, counts.len());
        let mut steps = Vec::new();
        for count in counts {
            steps.push((count, times(count)?));
            bar.inc(1);
        }
        bar.finish_and_clear();
        let point = |(count, times): &(usize, Times)| {
            let [least, most] = spread(&times.all);
            (*count as f64, [least, median(&times.all), most])
        };
        let parts = [
            ("voxels per side", format!("{}³ voxels", held.voxels)),
            ("pixels per side", format!("{}² pixels", held.pixels)),
            ("views", format!("{} view", held.views)),
        ];
        let held: Vec<String> =
            parts.into_iter().filter(|(of, _)| *of != name).map(|(_, text)| text).collect();
        let points = steps.iter().map(point).collect();
        Ok(Series {
            name,
            growth: Growth { held: held.join(", "), x_label: name.into(), points, power },
            steps,
        })
    }

    /// The thorax, of so many voxels along each axis.
    fn volume(&self, voxels: usize) -> Result<Arc<Volume>> {
        let phantom = Phantom::thorax().with_noise(true);
        let grid = phantom.grid([voxels; 3]).context("--scaling")?;
        self.setup.context.install(|| {
            let mut builder = VolumeBuilder::int16(grid, &self.setup.physics.classification, false)?;
            phantom.voxelise(&grid, |_, hu, _| builder.push_int16(hu, None))?;
            Ok(Arc::new(builder.finish()?))
        })
    }

    /// Projects again and again; the first time is not counted.
    fn times(&self, context: &Context, volume: &Arc<Volume>, size: Size) -> Result<Times> {
        let angle = |view: usize| ANGLES * ((view as f64 + 0.5) / size.views as f64 - 0.5);
        let views = ViewArguments::of((0..size.views).map(angle).collect(), [size.pixels; 2]);
        let views = views.views(volume.grid())?;
        let requests = views.requests();
        let projector = Projector::new(context, volume.clone(), self.setup.scene(&views))?;
        let layers = Layers { intensity: true, line_integral: true, ..Layers::default() };
        let mut times = Times::new("projection");
        for run in 0..=self.runs {
            let start = Instant::now();
            std::hint::black_box(projector.project(&requests, layers, SILENT)?);
            if run > 0 {
                times.all.push(start.elapsed().as_secs_f64());
            }
            if times.all.len() >= FEWEST && times.all.iter().sum::<f64>() > LONG {
                break;
            }
        }
        Ok(times)
    }
}

impl Series {
    fn to_json(&self) -> serde_json::Value {
        let steps: Vec<_> = self
            .steps
            .iter()
            .map(|(count, times)| {
                let [least, most] = spread(&times.all);
                json!({
                    "count": count,
                    "runs": times.all.len(),
                    "median_seconds": times.median(),
                    "min_seconds": least,
                    "max_seconds": most,
                    "proportional_seconds": self.growth.ideal(*count as f64),
                })
            })
            .collect();
        json!({ "of": self.name, "held": self.growth.held, "power": self.growth.power, "steps": steps })
    }

    fn say(&self, scene: &str, console: Console) {
        console.say(format_args!("{} ({}, {scene})", self.name, self.growth.held));
        for (count, times) in &self.steps {
            let [least, most] = spread(&times.all);
            console.say(format_args!(
                "  {count:>6}   median {:>10}   min {:>10}   max {:>10}   in proportion {:>10}",
                seconds(times.median()),
                seconds(least),
                seconds(most),
                seconds(self.growth.ideal(*count as f64)),
            ));
        }
    }
}

/// 1, 2, 4, … and `most`.
fn doubled(most: usize) -> Vec<usize> {
    let powers = std::iter::successors(Some(1), |n| Some(2 * n));
    powers.take_while(|n| *n < most).chain([most]).collect()
}

/// `most`, halved so often, from the smallest; whole numbers, each once.
fn halved(most: usize, times: u32) -> Vec<usize> {
    let mut sides: Vec<usize> = (0..=times).rev().map(|n| most.div_ceil(1 << n)).collect();
    sides.dedup();
    sides
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_grow_to_the_largest() {
        assert_eq!(
            [1, 2, 6, 32].map(doubled),
            [vec![1], vec![1, 2], vec![1, 2, 4, 6], vec![1, 2, 4, 8, 16, 32]]
        );
        assert_eq!([halved(720, 3), halved(3, 3)], [vec![90, 180, 360, 720], vec![1, 2, 3]]);
    }
}
