//! Views in any direction: every ray gathers the corners of its cell in each slice.

use std::ops::Range;

use super::axes::Axes;
use super::bundle::{Bundle, Course, Row};
use super::slab::{Codes, Slab};
use super::spans::Spans;
use super::sums::{BLOCK, Sums};
use super::{Met, Part};
use crate::engine::cpu::level::{AtLevel, LANES, Level, Wide, load, load_u32, store};
use crate::engine::cpu::path::ROUND;
use crate::error::Result;
use crate::raycast::Beam;

/// Slices that are decoded and crossed together; the places in them have one anchor.
pub(super) const SLICES: usize = 8;

/// Part of some views, and the rays of one driving axis in it. Each view decodes what it reads, but together they read the
/// volume from memory once.
pub(super) struct Gather<'a> {
    pub codes: Codes<'a>,
    pub beams: &'a [&'a Beam],
    /// Width of the detector.
    pub width: usize,
    pub axes: Axes,
    pub part: &'a Part,
    /// Hears of finished rays.
    pub finished: &'a dyn Fn(usize) -> Result<()>,
}

/// A block of columns.
struct Block {
    bundle: Bundle,
    sums: Sums,
    /// In the slices at hand; `None` where no ray is in them.
    bounds: Option<[[f64; 2]; 2]>,
}

impl AtLevel for Gather<'_> {
    type Output = Result<Vec<Met>>;

    #[inline(always)]
    fn run<S: Level>(self, simd: S) -> Self::Output {
        self.sweep(simd)
    }
}

impl Gather<'_> {
    /// The driving axes that rays of a part have.
    pub(super) fn driving(beams: &[&Beam], width: usize, part: &Part) -> Vec<usize> {
        let mut seen = [false; 3];
        for beam in beams {
            for row in part.rows.clone() {
                for column in part.columns(width) {
                    seen[beam.ray(column as f64, row as f64).axis] = true;
                }
            }
        }
        (0..3).filter(|&axis| seen[axis]).collect()
    }

    #[inline(always)]
    fn sweep<S: Level>(&self, simd: S) -> Result<Vec<Met>> {
        let Self { codes, axes, part, finished, .. } = self;
        let (dimensions, rows) = (codes.dimensions, part.rows.clone());
        let (slices, materials) = (dimensions[axes.driving], codes.densities.len());
        let centre = 0.5 * (slices as f64 - 1.0);
        let mut views: Vec<Vec<Block>> = Vec::with_capacity(self.beams.len());
        for beam in self.beams {
            let block = |number: usize| {
                let (first, last) = (number * LANES, self.width - 1);
                let bundle = Bundle::new(beam, dimensions, *axes, rows.clone(), first, last);
                Block { bundle, sums: Sums::new(materials, rows.len()), bounds: None }
            };
            views.push(part.blocks.clone().map(block).collect());
        }
        let Range { start: first, end: last } =
            Spans::around(views.iter().flatten().map(|block| &block.bundle.spans));
        // Groups are of the same slices whatever is swept.
        let groups = first / SLICES..last.div_ceil(SLICES);
        let mut rays = part.shares(self.width, views.len(), groups.len() * views.len());
        let mut slab = Slab::new(*codes, *axes);
        for group in groups.clone() {
            let k = group * SLICES..((group + 1) * SLICES).min(slices);
            for blocks in &mut views {
                rays.next(finished)?;
                for block in blocks.iter_mut() {
                    let some = &block.bundle.spans.some;
                    let apart = some.start >= k.end || some.end <= k.start;
                    block.bounds = if apart { None } else { block.bundle.bounds(&k, centre) };
                }
                if let Some((line, needed, near)) = self.lines(blocks, slab.chunks()) {
                    slab.aim(k.clone(), line, needed, near)?;
                    slab.decode(simd, k.clone())?;
                    let parts = blocks.len();
                    for (nth, block) in blocks.iter_mut().enumerate() {
                        block.add(simd, &k, &slab, (nth, parts));
                    }
                }
                if k.end % BLOCK == 0 || group + 1 == groups.end {
                    for block in blocks.iter_mut() {
                        block.sums.carry();
                    }
                }
            }
        }
        rays.rest(finished)?;
        let met = |blocks: &Vec<Block>| {
            Met::new(part, materials, blocks.iter().map(|block| (&block.bundle.spans, &block.sums)))
        };
        Ok(views.iter().map(met).collect())
    }

    /// The lines that blocks read, from which on, which of their chunks, and how many more than one a block does.
    fn lines(&self, blocks: &[Block], chunks: usize) -> Option<(i64, Vec<Range<usize>>, usize)> {
        let last_line = self.codes.dimensions[self.axes.along] as i64 - 1;
        let line = |at: f64| (at.floor() as i64).clamp(0, last_line);
        let bounds = || blocks.iter().filter_map(|block| block.bounds);
        let first = bounds().map(|[_, [low, _]]| line(low)).min()?;
        let last = bounds().map(|[_, [_, high]]| line(high) + 1).max()?;
        let mut needed = vec![0..0; (last - first + 1) as usize];
        let mut near = 0;
        for [across, [low, high]] in bounds() {
            let chunks = self.chunks(across, chunks);
            near = near.max(chunks.len() - 1);
            for needed in &mut needed[(line(low) - first) as usize..=(line(high) + 1 - first) as usize] {
                *needed = if *needed == (0..0) {
                    chunks.clone()
                } else {
                    needed.start.min(chunks.start)..needed.end.max(chunks.end)
                };
            }
        }
        Some((first, needed, near))
    }

    fn chunks(&self, [left, right]: [f64; 2], chunks: usize) -> Range<usize> {
        let last = self.codes.dimensions[self.axes.across] as f64 - 1.0;
        let chunk = |at: f64| at.clamp(0.0, last) as usize / LANES;
        chunk(left)..(chunk(right + 1.0) + 1).min(chunks)
    }
}

/// Where a row's rays are in each slice of a group.
struct Corners {
    place: [[u32; LANES]; SLICES],
    fraction: [[Wide; SLICES]; 2],
}

impl Block {
    #[inline(always)]
    fn add<S: Level>(&mut self, simd: S, k: &Range<usize>, slab: &Slab<'_>, (nth, parts): (usize, usize)) {
        let rows = self.bundle.rows.len();
        let centre = slab.centre();
        let Some([across, along]) = self.bounds else { return slab.bring(simd, nth, parts) };
        let ends = slab.ends();
        let chunk = |at: f64| at.clamp(0.0, ends[0]) as usize / LANES;
        let present = slab.present(chunk(across[0])..chunk(across[1] + 1.0) + 1);
        if present == 0 {
            return slab.bring(simd, nth, parts);
        }
        let inside = |[low, high]: [f64; 2], end: f64| low >= 0.0 && high < end;
        let inner = inside(across, ends[0]) && inside(along, ends[1]);
        let whole = self.bundle.spans.whole.start <= k.start && k.end <= self.bundle.spans.whole.end;
        let mut corners = Corners { place: [[0; LANES]; SLICES], fraction: [[[0.0; LANES]; SLICES]; 2] };
        for (q, row) in self.bundle.rows.iter().enumerate() {
            slab.bring(simd, nth * rows + q, parts * rows);
            if inner {
                corners.find::<S, false>(simd, row, k, centre, ends, slab);
            } else {
                corners.find::<S, true>(simd, row, k, centre, ends, slab);
            }
            let mut left = present;
            let mut material = 0;
            while left != 0 {
                if left & 1 != 0 {
                    let spans = [&self.bundle.spans.enter[q], &self.bundle.spans.leave[q]];
                    let sum = &mut self.sums.of(material)[q];
                    for n in (0..LANES).step_by(S::F32_LANES) {
                        let mut total = load::<S>(&sum[n..]);
                        for (t, slice) in k.clone().enumerate() {
                            let value = corners.value(simd, slab.plane(slice, material), slab.stride, t, n);
                            total = if whole {
                                simd.add_f32s(total, value)
                            } else {
                                let s = (slice as f64 - centre) as f32;
                                let from = simd.max_f32s(load::<S>(&spans[0][n..]), simd.splat_f32s(s - 0.5));
                                let to = simd.min_f32s(load::<S>(&spans[1][n..]), simd.splat_f32s(s + 0.5));
                                let weight = simd.max_f32s(simd.sub_f32s(to, from), simd.splat_f32s(0.0));
                                simd.times_plus(weight, value, total)
                            };
                        }
                        store::<S>(&mut sum[n..], total);
                    }
                }
                left >>= 1;
                material += 1;
            }
        }
    }
}

/// A coordinate of a row's rays near the middle of a group: whole voxels, and what is left.
struct Anchored {
    whole: Wide,
    rest: Wide,
    slope: Wide,
}

impl Anchored {
    #[inline(always)]
    fn new(course: &Course, middle: f64) -> Self {
        let (mut whole, mut rest, mut slope) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for n in 0..LANES {
            let at = course.base[n] + course.slope[n] * middle;
            let below = at.floor();
            (whole[n], rest[n], slope[n]) = (below as f32, (at - below) as f32, course.slope[n] as f32);
        }
        Self { whole, rest, slope }
    }

    /// How far from a voxel, and which.
    #[inline(always)]
    fn at<S: Level, const EDGE: bool>(
        &self,
        simd: S,
        n: usize,
        from_middle: S::f32s,
        end: f32,
    ) -> (S::f32s, S::f32s) {
        let whole = load::<S>(&self.whole[n..]);
        let mut at = simd.times_plus(from_middle, load::<S>(&self.slope[n..]), load::<S>(&self.rest[n..]));
        if EDGE {
            let low = simd.neg_f32s(whole);
            let high = simd.sub_f32s(simd.splat_f32s(end), whole);
            at = simd.min_f32s(simd.max_f32s(at, low), high);
        }
        let below = floors(simd, at);
        (simd.sub_f32s(at, below), simd.add_f32s(whole, below))
    }
}

impl Corners {
    /// With `EDGE`, where rays may be near the volume's faces: there the outermost voxel holds.
    #[inline(always)]
    fn find<S: Level, const EDGE: bool>(
        &mut self,
        simd: S,
        row: &Row,
        k: &Range<usize>,
        centre: f64,
        ends: [f64; 2],
        slab: &Slab<'_>,
    ) {
        let middle = (k.start as f64 + 0.5 * (SLICES as f64 - 1.0)) - centre;
        let across = Anchored::new(&row.across, middle);
        let along = Anchored::new(&row.along, middle);
        let stride = simd.splat_f32s(slab.stride as f32);
        // Whole numbers below 2²⁴: exact.
        let first = slab.first_line as f32 * slab.stride as f32 + slab.first_place() as f32;
        let first = simd.splat_f32s(first);
        for n in (0..LANES).step_by(S::F32_LANES) {
            for t in 0..k.len() {
                let from_middle = simd.splat_f32s(t as f32 - 0.5 * (SLICES as f32 - 1.0));
                let (x, across) = across.at::<S, EDGE>(simd, n, from_middle, ends[0] as f32);
                let (y, along) = along.at::<S, EDGE>(simd, n, from_middle, ends[1] as f32);
                store::<S>(&mut self.fraction[0][t][n..], x);
                store::<S>(&mut self.fraction[1][t][n..], y);
                let place = simd.times_plus(along, stride, simd.sub_f32s(across, first));
                let place = integer(simd, place);
                S::as_mut_simd_u32s(&mut self.place[t][n..n + S::F32_LANES]).0[0] = place;
            }
        }
    }

    /// The plane between four voxels.
    #[inline(always)]
    fn value<S: Level>(&self, simd: S, plane: &[f32], stride: usize, t: usize, n: usize) -> S::f32s {
        let at = load_u32::<S>(&self.place[t][n..]);
        let (x, y) = (load::<S>(&self.fraction[0][t][n..]), load::<S>(&self.fraction[1][t][n..]));
        let [a, b] = simd.pairs(plane, at);
        let [c, d] = simd.pairs(&plane[stride..], at);
        let low = simd.times_plus(x, simd.sub_f32s(b, a), a);
        let high = simd.times_plus(x, simd.sub_f32s(d, c), c);
        simd.times_plus(y, simd.sub_f32s(high, low), low)
    }
}

/// As [`super::floor`], lane by lane.
#[inline(always)]
fn floors<S: Level>(simd: S, x: S::f32s) -> S::f32s {
    let round = simd.splat_f32s(ROUND);
    let near = simd.sub_f32s(simd.add_f32s(x, round), round);
    let below = simd.sub_f32s(near, simd.splat_f32s(1.0));
    simd.select_f32s(simd.greater_than_f32s(near, x), below, near)
}

/// Of whole numbers in float32; |x| < 2²².
#[inline(always)]
fn integer<S: Level>(simd: S, x: S::f32s) -> S::u32s {
    let shifted = simd.transmute_u32s_f32s(simd.add_f32s(x, simd.splat_f32s(ROUND)));
    simd.sub_u32s(shifted, simd.splat_u32s(ROUND.to_bits()))
}
