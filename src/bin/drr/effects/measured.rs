//! Times of all cases, and what they show.

use anyhow::Result;
use drr::engine::Images;

use super::Study;
use super::case::{Beside, Case};
use crate::console::Console;

/// All runs of a case together take no longer, unless two do, s.
const MOST_SECONDS: f64 = 20.0;
/// Most columns and rows of a picture.
const PICTURED: usize = 200;

/// A case, measured.
pub(super) struct Measured {
    pub(super) name: &'static str,
    pub(super) what: String,
    pub(super) beside: Beside,
    /// All runs, s.
    pub(super) seconds: Vec<f64>,
}

/// What a case makes of the first view, every few pixels, head up.
pub(super) struct Shown {
    pub(super) name: &'static str,
    pub(super) size: [usize; 2],
    /// Of each detector layer.
    pub(super) intensity: Vec<Vec<f32>>,
    pub(super) line_integral: Vec<Vec<f32>>,
}

/// Measures all cases; their runs take turns, so that what else the machine does meets them alike.
pub(super) fn all(
    study: &Study<'_>,
    cases: Vec<Case>,
    runs: u32,
    console: Console,
) -> Result<(Vec<Measured>, Vec<Shown>)> {
    let bar = console.bar("measuring", cases.len() * (runs as usize + 1));
    let mut shown = Vec::new();
    for case in &cases {
        // The first run compiles what a GPU runs, and makes kernels of scatter.
        shown.push(Shown::new(case.name, study, &case.run.timed(study)?.0));
        bar.inc(1);
    }
    let mut seconds = vec![Vec::new(); cases.len()];
    for run in 0..runs {
        for (case, seconds) in cases.iter().zip(&mut seconds) {
            if run < 2 || seconds.iter().sum::<f64>() < MOST_SECONDS {
                seconds.push(case.run.timed(study)?.1);
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let measured = cases.into_iter().zip(seconds).map(|(case, seconds)| {
        let Case { name, what, beside, run: _ } = case;
        Measured { name, what, beside, seconds }
    });
    Ok((measured.collect(), shown))
}

impl Shown {
    fn new(name: &'static str, study: &Study<'_>, images: &Images<f32>) -> Self {
        let [width, height] = images.size;
        let stride = width.max(height).div_ceil(PICTURED);
        let few = |layer: &[f32]| -> Vec<f32> {
            let upright = study.views.upright(0, layer, width);
            let rows = upright.chunks_exact(width).step_by(stride);
            rows.flat_map(|row| row.iter().step_by(stride).copied()).collect()
        };
        let layers = |of: &[f32]| -> Vec<Vec<f32>> {
            (0..images.detector_layers)
                .map(|layer| {
                    let start = layer * width * height;
                    few(&of[start..start + width * height])
                })
                .collect()
        };
        Self {
            name,
            size: images.size.map(|side| side.div_ceil(stride)),
            intensity: layers(&images.intensity),
            line_integral: layers(&images.line_integral),
        }
    }
}
