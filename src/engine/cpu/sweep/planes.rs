//! Views whose columns each stay in a plane: a slice is resampled along its lines, once for all rows, and then along the columns.

use std::ops::Range;

use super::columns::{Column, Columns};
use super::slab::{Codes, Slab};
use super::spans::Spans;
use super::sums::{BLOCK, Sums};
use super::{MARGIN, Met, Part, floor, integer};
use crate::engine::cpu::level::{AtLevel, LANES, Level, Wide, load, load_u32, store};
use crate::error::Result;

/// Rows whose places have one anchor.
const ANCHORED: usize = 16;
/// Slices whose lines are looked for together.
const SLICES: usize = 16;

/// Part of some views, which have the same axes.
pub(super) struct Planes<'a> {
    pub codes: Codes<'a>,
    pub views: &'a [Columns],
    pub part: &'a Part,
    /// Hears of finished rays.
    pub finished: &'a dyn Fn(usize) -> Result<()>,
}

/// A block of columns of one view.
struct Block {
    view: usize,
    number: usize,
    spans: Spans,
    sums: Sums,
}

impl AtLevel for Planes<'_> {
    type Output = Result<Vec<Met>>;

    #[inline(always)]
    fn run<S: Level>(self, simd: S) -> Self::Output {
        self.sweep(simd)
    }
}

/// Some slices a few at a time.
fn runs(slices: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let Range { start: first, end: last } = slices;
    let group = move |n: usize| (n * SLICES).max(first)..((n + 1) * SLICES).min(last);
    (first / SLICES..last.div_ceil(SLICES)).map(group)
}

impl Planes<'_> {
    #[inline(always)]
    fn sweep<S: Level>(&self, simd: S) -> Result<Vec<Met>> {
        let Self { codes, views, part, finished } = self;
        let (axes, centre, rows) = (views[0].axes, views[0].centre, part.rows.clone());
        let slices = codes.dimensions[axes.driving];
        let materials = codes.densities.len();
        let mut blocks = Vec::new();
        for (view, columns) in views.iter().enumerate() {
            for number in part.blocks.clone() {
                let spans = rows.clone().map(|row| columns.spans(number, row));
                let spans = Spans::new(spans, centre, slices);
                blocks.push(Block { view, number, spans, sums: Sums::new(materials, rows.len()) });
            }
        }
        let Range { start: first, end: last } = Spans::around(blocks.iter().map(|block| &block.spans));
        let mut slab = Slab::new(*codes, axes);
        let near = self.near(slices, centre);
        let mut rays = part.shares(views[0].width, views.len(), last - first);
        let mut held = Vec::new();
        for group in runs(first..last) {
            let Some((line, needed)) = self.lines(&blocks, &group, centre, &slab) else { continue };
            slab.aim(group.clone(), line, needed, near)?;
            for k in group {
                rays.next(finished)?;
                slab.decode(simd, k..k + 1)?;
                let parts = blocks.len();
                for (nth, block) in blocks.iter_mut().enumerate() {
                    slab.bring(simd, nth, parts);
                    if !block.spans.some.contains(&k) {
                        continue;
                    }
                    block.add(simd, k, &views[block.view], &rows, &slab, &mut held);
                }
                if (k + 1) % BLOCK == 0 || k + 1 == last {
                    for block in &mut blocks {
                        block.sums.carry();
                    }
                }
            }
        }
        rays.rest(finished)?;
        let met = |view: usize| {
            let blocks = blocks.iter().filter(|block| block.view == view);
            Met::new(part, materials, blocks.map(|block| (&block.spans, &block.sums)))
        };
        Ok((0..views.len()).map(met).collect())
    }

    /// Most chunks beyond its first that a block's window reaches.
    fn near(&self, slices: usize, centre: f64) -> usize {
        let ends = [-0.5, slices as f64 - 0.5].map(|s| s - centre);
        let width = |columns: &[Column]| {
            let [a, b] = [&columns[0], &columns[LANES - 1]];
            ends.map(|s| (a.across.at(s) - b.across.at(s)).abs()).into_iter().fold(0.0, f64::max)
        };
        let blocks = self.views.iter().flat_map(|view| view.all.chunks(LANES));
        let most = blocks.map(width).fold(0.0, f64::max);
        let length = self.codes.dimensions[self.views[0].axes.across];
        (most.min(length as f64) / LANES as f64) as usize + 2
    }

    /// The lines that rays read in some slices, from which on, and which of their chunks.
    #[inline(always)]
    fn lines(
        &self,
        blocks: &[Block],
        slices: &Range<usize>,
        centre: f64,
        slab: &Slab<'_>,
    ) -> Option<(i64, Vec<Range<usize>>)> {
        let axes = self.views[0].axes;
        let last_line = self.codes.dimensions[axes.along] as i64 - 1;
        let rows = [self.part.rows.start as f64, (self.part.rows.end - 1) as f64];
        let ends = [slices.start as f64 - centre, (slices.end - 1) as f64 - centre];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for block in blocks {
            if block.spans.some.start >= slices.end || block.spans.some.end <= slices.start {
                continue;
            }
            let columns = self.views[block.view].block(block.number);
            for column in [&columns[0], &columns[LANES - 1]] {
                for s in ends {
                    for row in rows {
                        let at = column.along(row, s);
                        low = if at < low { at } else { low };
                        high = if at > high { at } else { high };
                    }
                    let at = column.across.at(s);
                    left = if at < left { at } else { left };
                    right = if at > right { at } else { right };
                }
            }
        }
        if !(low <= high) {
            return None;
        }
        // A row of which some ray is in the volume has none two lines before it.
        // What float32 makes of a place may be across a line.
        let first = ((low - MARGIN).floor() as i64).clamp(-2, last_line);
        let last = ((high + MARGIN).floor() as i64 + 2).clamp(first + 2, last_line + 3);
        let length = self.codes.dimensions[axes.across] as f64;
        let chunk = |at: f64| at.clamp(0.0, length - 1.0) as usize / LANES;
        let chunks = chunk(left)..(chunk(right + 1.0) + 1).min(slab.chunks());
        Some((first, vec![chunks; (last - first + 1) as usize]))
    }
}

impl Block {
    /// Adds a slice to all rays.
    #[inline(always)]
    fn add<S: Level>(
        &mut self,
        simd: S,
        k: usize,
        columns: &Columns,
        rows: &Range<usize>,
        slab: &Slab<'_>,
        held: &mut Vec<Wide>,
    ) {
        let s = k as f64 - columns.centre;
        let columns = columns.block(self.number);
        let places = Places::new(columns, s, slab.length());
        let present = slab.present(places.first / LANES..(places.last + 1) / LANES + 1);
        held.resize(slab.lines, [0.0; LANES]);
        let whole = self.spans.whole.contains(&k);
        let mut material = 0;
        let mut left = present;
        while left != 0 {
            if left & 1 != 0 {
                places.resample(simd, slab, slab.plane(k, material), held);
                let sums = self.sums.of(material);
                for (group, sums) in sums.chunks_mut(ANCHORED).enumerate() {
                    let row = group * ANCHORED;
                    let lines = Lines::new(columns, (rows.start + row) as f64, s, slab.first_line);
                    if whole {
                        lines.add::<S, false>(simd, held, s as f32, [&[], &[]], sums);
                    } else {
                        let spans =
                            [&self.spans.enter, &self.spans.leave].map(|ends| &ends[row..][..sums.len()]);
                        lines.add::<S, true>(simd, held, s as f32, spans, sums);
                    }
                }
            }
            left >>= 1;
            material += 1;
        }
    }
}

/// Where the columns of a block cross the lines of a slice.
struct Places {
    /// The first and last voxel that any reads, not counting the ones behind them.
    first: usize,
    last: usize,
    /// From the first one.
    voxel: [u32; LANES],
    fraction: Wide,
}

impl Places {
    #[inline(always)]
    fn new(columns: &[Column; LANES], s: f64, length: usize) -> Self {
        let end = (length - 1) as f64;
        let inside = |column: &Column| {
            let at = column.across.at(s);
            let at = if at > 0.0 { at } else { 0.0 };
            if at < end { at } else { end }
        };
        let [a, b] = [&columns[0], &columns[LANES - 1]].map(inside);
        let [first, last] = [if a < b { a } else { b }, if a < b { b } else { a }].map(f64::floor);
        let (mut voxel, mut fraction) = ([0; LANES], [0.0; LANES]);
        for n in 0..LANES {
            // Where all columns meet, in the source's slice, they may be out of order by a rounding.
            let from = inside(&columns[n]) - first;
            let whole = from.floor();
            let whole = if whole > 0.0 { whole } else { 0.0 };
            let whole = if whole < last - first { whole } else { last - first };
            voxel[n] = integer(whole as f32).cast_unsigned();
            fraction[n] = (from - whole) as f32;
        }
        Self { first: first as usize, last: last as usize, voxel, fraction }
    }

    /// All lines of a plane at these places.
    #[inline(always)]
    fn resample<S: Level>(&self, simd: S, slab: &Slab<'_>, plane: &[f32], held: &mut [Wide]) {
        let first = self.first - slab.first_place();
        let narrow = self.last - self.first < 2 * LANES - 1;
        for (line, held) in plane.chunks_exact(slab.stride).zip(held) {
            let line = &line[first..];
            for n in (0..LANES).step_by(S::F32_LANES) {
                let at = load_u32::<S>(&self.voxel[n..]);
                let [low, high] = match line.first_chunk() {
                    Some(window) if narrow => simd.near_pairs(window, at),
                    _ => simd.pairs(line, at),
                };
                let fraction = load::<S>(&self.fraction[n..]);
                let value = simd.times_plus(fraction, simd.sub_f32s(high, low), low);
                store::<S>(&mut held[n..], value);
            }
        }
    }
}

/// Where the rays of a group of rows cross a slice's lines.
struct Lines {
    /// Of the first row, from its anchor, and from one row to the next beside whole lines: small, so that float32 holds places to
    /// a millionth of a line.
    base: Wide,
    step: Wide,
    /// The line below all rays of each row among those held, and whole lines from there to where `base` and `step` lead.
    line: [i32; ANCHORED],
    whole: [f32; ANCHORED],
    /// Whether a row's rays are all within two lines.
    close: bool,
}

impl Lines {
    #[inline(always)]
    fn new(columns: &[Column; LANES], row: f64, s: f64, first_line: i64) -> Self {
        let at = |column: &Column| column.along(row, s);
        let [a, b] = [at(&columns[0]), at(&columns[LANES - 1])];
        // The anchor is the group's own, so that no ray's rounding depends on what else is swept.
        let anchor = (if a < b { a } else { b }).floor();
        let per_row = columns[0].per_row.at(s).round();
        let (mut base, mut step) = ([0.0; LANES], [0.0; LANES]);
        for n in 0..LANES {
            base[n] = (at(&columns[n]) - anchor) as f32;
            step[n] = (columns[n].per_row.at(s) - per_row) as f32;
        }
        let (offset, per_row) = ((anchor as i64 - first_line) as i32, per_row as f32);
        let (mut whole, mut line, mut apart) = ([0.0; ANCHORED], [0; ANCHORED], [0.0; ANCHORED]);
        for q in 0..ANCHORED {
            let a = base[0] + q as f32 * step[0];
            let b = base[LANES - 1] + q as f32 * step[LANES - 1];
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            apart[q] = high - low;
            let below = floor(low);
            whole[q] = -below;
            line[q] = offset.wrapping_add(integer(below + q as f32 * per_row));
        }
        let mut spread = 0.0;
        for apart in apart {
            spread = if apart > spread { apart } else { spread };
        }
        Self { base, step, line, whole, close: spread < 1.0 }
    }

    /// Adds to the sums what the rays meet of the lines held; `WEIGHTED` by how much of the slice is between each ray's ends.
    #[inline(always)]
    fn add<S: Level, const WEIGHTED: bool>(
        &self,
        simd: S,
        held: &[Wide],
        s: f32,
        [enter, leave]: [&[Wide]; 2],
        sums: &mut [Wide],
    ) {
        for (q, sum) in sums.iter_mut().enumerate() {
            // Rays that are not in the slice may be anywhere: whatever they read is weighted 0.
            let line = (self.line[q].max(0) as usize).min(held.len() - 3);
            let lines: &[Wide; 3] = held[line..].first_chunk().expect("three lines");
            for n in (0..LANES).step_by(S::F32_LANES) {
                let [base, step] = [load::<S>(&self.base[n..]), load::<S>(&self.step[n..])];
                let at = simd.times_plus(simd.splat_f32s(q as f32), step, base);
                let above = simd.add_f32s(at, simd.splat_f32s(self.whole[q]));
                let value = if self.close {
                    // Across the first cell, and on into the second.
                    let first = simd.min_f32s(above, simd.splat_f32s(1.0));
                    let second = simd.sub_f32s(above, first);
                    let (a, b, c) =
                        (load::<S>(&lines[0][n..]), load::<S>(&lines[1][n..]), load::<S>(&lines[2][n..]));
                    let value = simd.times_plus(first, simd.sub_f32s(b, a), a);
                    simd.times_plus(second, simd.sub_f32s(c, b), value)
                } else {
                    self.apart::<S>(held, n, above, q)
                };
                let old = load::<S>(&sum[n..]);
                let new = if WEIGHTED {
                    let from = simd.max_f32s(load::<S>(&enter[q][n..]), simd.splat_f32s(s - 0.5));
                    let to = simd.min_f32s(load::<S>(&leave[q][n..]), simd.splat_f32s(s + 0.5));
                    let weight = simd.max_f32s(simd.sub_f32s(to, from), simd.splat_f32s(0.0));
                    simd.times_plus(weight, value, old)
                } else {
                    simd.add_f32s(old, value)
                };
                store::<S>(&mut sum[n..], new);
            }
        }
    }

    /// The values of a row's rays that may be several lines apart.
    #[inline(never)]
    fn apart<S: Level>(&self, held: &[Wide], first: usize, above: S::f32s, q: usize) -> S::f32s {
        let from = f64::from(self.line[q]);
        let mut values = [0.0; LANES];
        store::<S>(&mut values, above);
        for (n, value) in values.iter_mut().enumerate().take(S::F32_LANES) {
            let at = (f64::from(*value) + from).clamp(0.0, (held.len() - 1) as f64);
            let line = (at as usize).min(held.len() - 2);
            let [low, high] = [held[line][first + n], held[line + 1][first + n]];
            *value = ((at - line as f64) as f32).mul_add(high - low, low);
        }
        load::<S>(&values)
    }
}
