//! Some slices of the volume, their lines decoded to partial densities where there is anything.

use std::ops::Range;

use super::axes::Axes;
use super::densities::Densities;
use crate::allocation::grow;
use crate::engine::cpu::level::{LANES, Level};
use crate::error::Result;
use crate::volume::{BRICK, bricks};

/// Slices that are turned at once.
const TURN: usize = 16;

/// A volume's codes, what they mean, and where there is what.
#[derive(Clone, Copy)]
pub(super) struct Codes<'a> {
    pub voxels: &'a [u16],
    pub dimensions: [usize; 3],
    pub densities: &'a [Densities],
    /// By brick, x fastest: bit m is set where there is something of label m.
    pub labels: &'a [u8],
    /// Which materials a brick's labels are, bit by bit.
    pub accumulators: &'a [u8; 256],
}

impl Codes<'_> {
    fn strides(&self) -> [usize; 3] {
        [1, self.dimensions[0], self.dimensions[0] * self.dimensions[1]]
    }
}

/// Chunks of a line in which one material is somewhere, or is nowhere but near.
struct Run {
    material: usize,
    chunks: Range<usize>,
    holds: bool,
}

/// Decoded slices. Lines are numbered from `first_line` on, which may be before the volume: there the outermost line holds.
pub(super) struct Slab<'a> {
    codes: Codes<'a>,
    axes: Axes,
    /// Chunks that a block may read beyond its first.
    near: usize,
    chunks: usize,
    first_chunk: usize,
    pub stride: usize,
    pub first_line: i64,
    pub lines: usize,
    /// By line, the chunks that are read.
    needed: Vec<Range<usize>>,
    /// Slices.
    decoded: Range<usize>,
    /// By slice, material, line.
    values: Vec<f32>,
    /// By chunk, with `near` more on both sides.
    present: Vec<u8>,
    runs: Vec<Run>,
    turned: Turned,
}

/// Slices across x, turned: their lines are not in order in memory.
#[derive(Default)]
struct Turned {
    first_slice: usize,
    /// By slice, line, place.
    codes: Vec<u16>,
}

impl<'a> Slab<'a> {
    pub(super) fn new(codes: Codes<'a>, axes: Axes) -> Self {
        let chunks = codes.dimensions[axes.across].div_ceil(LANES);
        Self {
            codes,
            axes,
            near: 0,
            chunks,
            first_chunk: 0,
            stride: 0,
            first_line: 0,
            lines: 0,
            needed: Vec::new(),
            decoded: 0..0,
            values: Vec::new(),
            present: Vec::new(),
            runs: Vec::new(),
            turned: Turned::default(),
        }
    }

    pub(super) fn chunks(&self) -> usize {
        self.chunks
    }

    /// The middle slice, or between two.
    pub(super) fn centre(&self) -> f64 {
        0.5 * (self.codes.dimensions[self.axes.driving] as f64 - 1.0)
    }

    /// The last voxel's place along lines and from line to line.
    pub(super) fn ends(&self) -> [f64; 2] {
        [self.axes.across, self.axes.along].map(|axis| (self.codes.dimensions[axis] - 1) as f64)
    }

    /// Voxels in a line.
    pub(super) fn length(&self) -> usize {
        self.codes.dimensions[self.axes.across]
    }

    /// Materials in some chunks of the slices.
    #[inline(always)]
    pub(super) fn present(&self, chunks: Range<usize>) -> u8 {
        let chunks = chunks.start + self.near..chunks.end.min(self.chunks) + self.near;
        self.present[chunks].iter().fold(0, |all, bits| all | bits)
    }

    /// All lines of one material in one slice.
    #[inline(always)]
    pub(super) fn plane(&self, slice: usize, material: usize) -> &[f32] {
        let plane = self.lines * self.stride;
        let at = (slice - self.decoded.start) * self.codes.densities.len() + material;
        &self.values[at * plane..(at + 1) * plane]
    }

    /// Makes ready for some slices: of each line from `first_line` on, as many as `needed` has, the chunks that it says. A block
    /// reads at most `near` chunks beyond its first.
    #[inline(always)]
    pub(super) fn aim(
        &mut self,
        slices: Range<usize>,
        first_line: i64,
        needed: Vec<Range<usize>>,
        near: usize,
    ) -> Result<()> {
        (self.first_line, self.lines, self.near) = (first_line, needed.len(), near);
        let read = || needed.iter().filter(|chunks| chunks.start < chunks.end);
        self.first_chunk = read().map(|chunks| chunks.start).min().unwrap_or(0);
        let last = read().map(|chunks| chunks.end).max().unwrap_or(0);
        // A window of 32 values may begin at the last one.
        self.stride = (last - self.first_chunk + 3) * LANES;
        self.find(slices.clone(), &needed);
        self.find_runs();
        if self.axes.across != 0 {
            self.turn(slices.clone(), &needed)?;
        }
        self.needed = needed;
        Ok(())
    }

    /// Decodes some of the slices.
    #[inline(always)]
    pub(super) fn decode<S: Level>(&mut self, simd: S, slices: Range<usize>) -> Result<()> {
        let materials = self.codes.densities.len();
        let plane = self.lines * self.stride;
        self.decoded = slices.clone();
        grow(&mut self.values, slices.len() * materials * plane, 0.0, "decoded slices")?;
        let mut values = std::mem::take(&mut self.values);
        for line in 0..self.lines {
            let needed = self.needed[line].clone();
            for slice in slices.clone() {
                let codes = self.line(slice, line);
                let first = (slice - slices.start) * materials;
                for run in &self.runs {
                    let chunks = run.chunks.start.max(needed.start)..run.chunks.end.min(needed.end);
                    if chunks.is_empty() {
                        continue;
                    }
                    let [from, to] =
                        [chunks.start, chunks.end].map(|chunk| (chunk - self.first_chunk) * LANES);
                    let out = &mut values[(first + run.material) * plane + line * self.stride..][from..to];
                    if !run.holds {
                        out.fill(0.0);
                        continue;
                    }
                    let whole = to.min(codes.len() / LANES * LANES);
                    let densities = &self.codes.densities[run.material];
                    let (inner, rest) = out.split_at_mut(whole - from);
                    densities.decode(simd, &codes[from..whole], inner);
                    if !rest.is_empty() {
                        let tail: [u16; LANES] =
                            std::array::from_fn(|n| codes[(whole + n).min(codes.len() - 1)]);
                        densities.decode(simd, &tail, rest);
                    }
                }
            }
        }
        self.values = values;
        Ok(())
    }

    /// The codes of a line, from the first chunk on.
    fn line(&self, slice: usize, line: usize) -> &[u16] {
        if self.axes.across != 0 {
            let of = (slice - self.turned.first_slice) * self.lines + line;
            return &self.turned.codes[of * self.stride..][..self.stride];
        }
        let from = self.start(slice, line);
        &self.codes.voxels[from + self.first_place()..from + self.length()]
    }

    /// The place in a line where values begin.
    pub(super) fn first_place(&self) -> usize {
        self.first_chunk * LANES
    }

    /// Where a line is in memory; outside the volume the outermost one.
    #[inline(always)]
    fn start(&self, slice: usize, line: usize) -> usize {
        let last = self.codes.dimensions[self.axes.along] as i64 - 1;
        let line = (self.first_line + line as i64).clamp(0, last) as usize;
        let strides = self.codes.strides();
        slice * strides[self.axes.driving] + line * strides[self.axes.along]
    }

    /// Has a part, `nth` of `parts`, of what will be decoded next brought near, while there is other work: as many slices as have
    /// been decoded, of the same lines.
    #[inline(always)]
    pub(super) fn bring<S: Level>(&self, simd: S, nth: usize, parts: usize) {
        if self.axes.across != 0 {
            return;
        }
        let all = self.lines * self.decoded.len();
        for item in nth * all / parts..(nth + 1) * all / parts {
            let (line, slice) = (item / self.decoded.len(), self.decoded.end + item % self.decoded.len());
            let from = self.start(slice, line);
            let needed = &self.needed[line];
            let codes = from + needed.start * LANES..from + (needed.end * LANES).min(self.length());
            if let Some(codes) = self.codes.voxels.get(codes) {
                simd.prefetch(codes);
            }
        }
    }

    /// What is in the chunks that are needed, as far as bricks tell.
    fn find(&mut self, slices: Range<usize>, needed: &[Range<usize>]) {
        let Axes { driving, across, along } = self.axes;
        let bricks = bricks(self.codes.dimensions);
        let strides = [1, bricks[0], bricks[0] * bricks[1]];
        let last_line = self.codes.dimensions[along] as i64 - 1;
        let of = |line: usize| (self.first_line + line as i64).clamp(0, last_line) as usize / BRICK;
        self.present.clear();
        self.present.resize(self.chunks + 2 * self.near, 0);
        let present = &mut self.present[self.near..];
        let per_chunk = LANES / BRICK;
        let mut line = 0;
        while line < needed.len() {
            let mut range = needed[line].clone();
            let brick = of(line);
            line += 1;
            while line < needed.len() && of(line) == brick {
                if !needed[line].is_empty() {
                    let wider = range.start.min(needed[line].start)..range.end.max(needed[line].end);
                    range = if range.is_empty() { needed[line].clone() } else { wider };
                }
                line += 1;
            }
            for slice in slices.start / BRICK..=(slices.end - 1) / BRICK {
                let first = slice * strides[driving] + brick * strides[along];
                for chunk in range.clone() {
                    for place in chunk * per_chunk..((chunk + 1) * per_chunk).min(bricks[across]) {
                        present[chunk] |= self.codes.labels[first + place * strides[across]];
                    }
                }
            }
        }
        for labels in present {
            *labels = self.codes.accumulators[usize::from(*labels)];
        }
    }

    fn find_runs(&mut self) {
        self.runs.clear();
        for material in 0..self.codes.densities.len() {
            for chunk in 0..self.chunks {
                let near = &self.present[chunk..=chunk + 2 * self.near];
                if near.iter().fold(0, |all, bits| all | bits) >> material & 1 == 0 {
                    continue;
                }
                let holds = near[self.near] >> material & 1 != 0;
                match self.runs.last_mut() {
                    Some(run) if (run.material, run.chunks.end, run.holds) == (material, chunk, holds) => {
                        run.chunks.end += 1;
                    }
                    _ => self.runs.push(Run { material, chunks: chunk..chunk + 1, holds }),
                }
            }
        }
    }

    /// Turns slices so that lines are in order, unless it has them.
    #[inline(always)]
    fn turn(&mut self, slices: Range<usize>, needed: &[Range<usize>]) -> Result<()> {
        let Axes { driving, across, along } = self.axes;
        let codes = &self.codes;
        let strides = codes.strides();
        let (last_line, length) = (codes.dimensions[along] as i64 - 1, codes.dimensions[across]);
        self.turned.first_slice = slices.start;
        grow(&mut self.turned.codes, slices.len() * self.lines * self.stride, 0, "turned slices")?;
        for (line, needed) in needed.iter().enumerate() {
            let at = (self.first_line + line as i64).clamp(0, last_line) as usize;
            for chunk in needed.clone().filter(|&chunk| self.present[chunk + self.near] != 0) {
                for part in slices.clone().step_by(TURN) {
                    let part = part..(part + TURN).min(slices.end);
                    // Lines of x, one for each place of the chunk: of slices, or of lines where x runs along them.
                    let mut tile = [[0_u16; LANES]; TURN];
                    let first = at * strides[along] + part.start * strides[driving];
                    for n in 0..LANES {
                        let place = (chunk * LANES + n).min(length - 1);
                        let voxels = &codes.voxels[first + place * strides[across]..];
                        match voxels.first_chunk::<TURN>() {
                            Some(voxels) if driving == 0 && part.len() == TURN => {
                                tile.iter_mut().zip(voxels).for_each(|(slice, &code)| slice[n] = code);
                            }
                            _ => {
                                for (s, slice) in tile.iter_mut().enumerate().take(part.len()) {
                                    slice[n] = voxels[s * strides[driving]];
                                }
                            }
                        }
                    }
                    for slice in part.clone() {
                        let of = (slice - slices.start) * self.lines + line;
                        self.turned.codes[of * self.stride + (chunk - self.first_chunk) * LANES..][..LANES]
                            .copy_from_slice(&tile[slice - part.start]);
                    }
                }
            }
        }
        Ok(())
    }
}
