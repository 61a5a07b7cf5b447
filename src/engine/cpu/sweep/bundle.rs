//! The rays of a block of pixels, whatever their directions.

use std::ops::Range;

use super::MARGIN;
use super::axes::Axes;
use super::spans::{RowSpans, Spans};
use crate::engine::cpu::level::LANES;
use crate::raycast::Beam;
use crate::raycast::ray::TRANSVERSE;

/// A coordinate along each ray of a row: `base + slope·(s − centre)`.
#[derive(Clone, Copy)]
pub(super) struct Course {
    pub base: [f64; LANES],
    pub slope: [f64; LANES],
}

/// Along lines, and from line to line.
pub(super) struct Row {
    pub across: Course,
    pub along: Course,
}

/// A block of rays. Those that have another driving axis are not in the volume.
pub(super) struct Bundle {
    pub rows: Vec<Row>,
    pub spans: Spans,
}

impl Bundle {
    pub(super) fn new(
        beam: &Beam,
        dimensions: [usize; 3],
        axes: Axes,
        rows: Range<usize>,
        first_column: usize,
        last_column: usize,
    ) -> Self {
        let nowhere = Course { base: [0.0; LANES], slope: [0.0; LANES] };
        let mut courses = Vec::with_capacity(rows.len());
        let centre = 0.5 * (dimensions[axes.driving] as f64 - 1.0);
        let spans: Vec<_> = rows
            .map(|j| {
                let mut row = Row { across: nowhere, along: nowhere };
                let mut spans = RowSpans::default();
                for n in 0..LANES {
                    let ray = beam.ray((first_column + n).min(last_column) as f64, j as f64);
                    if ray.axis != axes.driving {
                        continue;
                    }
                    let swapped = usize::from(TRANSVERSE[ray.axis][0] != axes.across);
                    for (course, t) in [(&mut row.across, swapped), (&mut row.along, 1 - swapped)] {
                        (course.base[n], course.slope[n]) = (ray.base[t], ray.slope[t]);
                    }
                    if let Some(span) = ray.clip(dimensions) {
                        let [enter, leave] = [span.enter, span.leave].map(|s| (s - centre) as f32);
                        (spans.enter[n], spans.leave[n]) = (enter, leave);
                    }
                    spans.cm[n] = (0.1 * ray.mm_per_slice) as f32;
                }
                courses.push(row);
                spans
            })
            .collect();
        let spans = Spans::new(spans.into_iter(), centre, dimensions[axes.driving]);
        Self { rows: courses, spans }
    }

    /// Least and largest coordinate along lines and from line to line, of rays while they are in the volume, in some slices, with a
    /// margin.
    #[inline(always)]
    pub(super) fn bounds(&self, slices: &Range<usize>, centre: f64) -> Option<[[f64; 2]; 2]> {
        let ends = [slices.start as f64 - centre, (slices.end - 1) as f64 - centre];
        let [mut least, mut most] = [[[f64::INFINITY; LANES]; 2], [[f64::NEG_INFINITY; LANES]; 2]];
        let faces = [ends[0] - 0.5, ends[1] + 0.5].map(|s| s as f32);
        for (q, row) in self.rows.iter().enumerate() {
            let (enter, leave) = (&self.spans.enter[q], &self.spans.leave[q]);
            for (axis, course) in [&row.across, &row.along].into_iter().enumerate() {
                let (least, most) = (&mut least[axis], &mut most[axis]);
                for n in 0..LANES {
                    let [a, b] = ends.map(|s| course.base[n] + course.slope[n] * s);
                    let (low, high) = if a < b { (a, b) } else { (b, a) };
                    let inside = leave[n] > enter[n] && leave[n] > faces[0] && enter[n] < faces[1];
                    least[n] = if inside && low < least[n] { low } else { least[n] };
                    most[n] = if inside && high > most[n] { high } else { most[n] };
                }
            }
        }
        let low = least.map(|lanes| lanes.into_iter().fold(f64::INFINITY, f64::min));
        let high = most.map(|lanes| lanes.into_iter().fold(f64::NEG_INFINITY, f64::max));
        let wider = |axis: usize| [low[axis] - MARGIN, high[axis] + MARGIN];
        (low[0] <= high[0]).then(|| [wider(0), wider(1)])
    }
}
