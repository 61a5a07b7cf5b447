//! Where rays are in the volume, block by block.

use std::ops::Range;

use crate::engine::cpu::level::{LANES, Wide};

/// The rays of a block, row by row: where they enter and leave, slices from the centre, and cm per slice. Rays that miss leave
/// where they enter.
pub(super) struct Spans {
    pub enter: Vec<Wide>,
    pub leave: Vec<Wide>,
    pub cm: Vec<Wide>,
    /// Slices that any ray is in, and those that all rays are in from face to face.
    pub some: Range<usize>,
    pub whole: Range<usize>,
}

/// A row's rays.
#[derive(Clone, Copy, Default)]
pub(super) struct RowSpans {
    pub enter: Wide,
    pub leave: Wide,
    pub cm: Wide,
}

impl Spans {
    /// Slices that a ray of any of them is in.
    pub(super) fn around<'a>(all: impl Iterator<Item = &'a Self>) -> Range<usize> {
        let some = all.map(|spans| spans.some.clone()).filter(|some| !some.is_empty());
        some.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
    }

    #[inline(always)]
    pub(super) fn new(rows: impl Iterator<Item = RowSpans>, centre: f64, slices: usize) -> Self {
        let (mut enter, mut leave, mut cm) = (Vec::new(), Vec::new(), Vec::new());
        let (mut first, mut last) = (f32::INFINITY, f32::NEG_INFINITY);
        let (mut all_in, mut any_out) = (f32::NEG_INFINITY, f32::INFINITY);
        for row in rows {
            for n in 0..LANES {
                let (from, to) = (row.enter[n], row.leave[n]);
                let hits = to > from;
                first = if hits && from < first { from } else { first };
                last = if hits && to > last { to } else { last };
                all_in = if from > all_in { from } else { all_in };
                let until = if hits { to } else { f32::NEG_INFINITY };
                any_out = if until < any_out { until } else { any_out };
            }
            enter.push(row.enter);
            leave.push(row.leave);
            cm.push(row.cm);
        }
        // Slice k is from k − ½ to k + ½.
        let face = |s: f32| (f64::from(s) + centre + 0.5).clamp(0.0, slices as f64);
        let some = if first < last { face(first).floor() as usize..face(last).ceil() as usize } else { 0..0 };
        let whole = face(all_in).ceil() as usize..face(any_out).floor() as usize;
        Self { enter, leave, cm, some, whole }
    }
}
