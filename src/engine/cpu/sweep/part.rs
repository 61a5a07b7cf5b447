//! What one thread sweeps at a time, and what its rays meet.

use std::ops::Range;

use super::gather::SLICES;
use super::spans::Spans;
use super::sums::Sums;
use super::{REPORTED, ROWS};
use crate::engine::cpu::level::{LANES, Wide};
use crate::error::Result;

/// Parts per thread that make threads finish at about the same time.
const PER_THREAD: usize = 4;
/// Fewest blocks of a part: fewer share too little.
const NARROWEST: usize = 4;

/// The rays of a detector, and how many of them, n × n, are a pixel's.
#[derive(Debug, Clone, Copy)]
pub(in crate::engine::cpu) struct RayGrid {
    pub size: [usize; 2],
    pub unit: usize,
}

/// Rows, and blocks of columns, of a view: whole pixels.
#[derive(Debug, Clone)]
pub(in crate::engine::cpu) struct Part {
    pub rows: Range<usize>,
    pub blocks: Range<usize>,
}

impl Part {
    /// All parts of a detector, of one of some groups of as many views, at most `widest` blocks wide. What
    /// a ray meets does not depend on the part.
    pub(super) fn all(
        RayGrid { size, unit }: RayGrid,
        views: usize,
        groups: usize,
        slices: usize,
        widest: usize,
    ) -> impl Iterator<Item = Self> {
        let blocks = size[0].div_ceil(LANES);
        let wanted = PER_THREAD * rayon::current_num_threads().max(1);
        let many = groups * (size[1] / ROWS[1]) >= wanted;
        // Whole pixels, and whole groups of rows and columns.
        let whole = unit / gcd(unit, LANES);
        let rows = whole * ROWS[usize::from(many && whole == 1)];
        let bands = size[1].div_ceil(rows);
        // A few rays at a time are reported, and threads should have their parts.
        let most = REPORTED * slices / SLICES / (views * rows * LANES);
        let split = wanted.div_ceil(groups * bands).min(blocks.div_ceil(NARROWEST)).max(1);
        let width = (blocks.div_ceil(split).min(most).min(widest) / whole).max(1) * whole;
        (0..bands).flat_map(move |band| {
            let rows = band * rows..((band + 1) * rows).min(size[1]);
            (0..blocks)
                .step_by(width)
                .map(move |first| Self { rows: rows.clone(), blocks: first..(first + width).min(blocks) })
        })
    }

    /// Its columns of a detector of some width.
    pub(in crate::engine::cpu) fn columns(&self, width: usize) -> Range<usize> {
        self.blocks.start * LANES..(self.blocks.end * LANES).min(width)
    }

    /// Its pixels: columns, rows.
    pub(in crate::engine::cpu) fn pixels(&self, RayGrid { size, unit }: RayGrid) -> [Range<usize>; 2] {
        [self.columns(size[0]), self.rows.clone()].map(|rays| rays.start / unit..rays.end / unit)
    }

    /// Its rays of some views in as many equal shares as there are steps, and the rest.
    pub(super) fn shares(&self, width: usize, views: usize, steps: usize) -> Shares {
        let rays = views * self.rows.len() * self.columns(width).len();
        Shares { left: rays, share: rays / (steps + 1) }
    }
}

/// Rays that are reported as finished little by little, though they all are at the end.
pub(super) struct Shares {
    left: usize,
    share: usize,
}

impl Shares {
    /// Reports a share.
    pub(super) fn next(&mut self, finished: &dyn Fn(usize) -> Result<()>) -> Result<()> {
        self.left -= self.share;
        report(self.share, finished)
    }

    /// Reports what is left.
    pub(super) fn rest(self, finished: &dyn Fn(usize) -> Result<()>) -> Result<()> {
        report(self.left, finished)
    }
}

fn report(mut rays: usize, finished: &dyn Fn(usize) -> Result<()>) -> Result<()> {
    while rays > REPORTED {
        finished(REPORTED)?;
        rays -= REPORTED;
    }
    finished(rays)
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// What the rays of a part met.
pub(in crate::engine::cpu) struct Met {
    rows: usize,
    blocks: usize,
    /// g/cm², by accumulator, row and block.
    areal_density: Vec<Wide>,
}

impl Met {
    pub(super) fn nothing(part: &Part, accumulators: usize) -> Self {
        let (rows, blocks) = (part.rows.len(), part.blocks.len());
        Self { rows, blocks, areal_density: vec![[0.0; LANES]; accumulators * rows * blocks] }
    }

    /// Of the blocks in order.
    pub(super) fn new<'a>(
        part: &Part,
        accumulators: usize,
        blocks: impl Iterator<Item = (&'a Spans, &'a Sums)>,
    ) -> Self {
        let mut met = Self::nothing(part, accumulators);
        for (b, (spans, sums)) in blocks.enumerate() {
            for accumulator in 0..accumulators {
                for row in 0..met.rows {
                    let at = met.at(accumulator, row, b);
                    met.areal_density[at] = sums.areal_density(accumulator, row, spans);
                }
            }
        }
        met
    }

    fn at(&self, accumulator: usize, row: usize, block: usize) -> usize {
        (accumulator * self.rows + row) * self.blocks + block
    }

    /// As well what the same rays met elsewhere.
    pub(super) fn add(&mut self, other: &Self) {
        for (sum, more) in
            self.areal_density.as_flattened_mut().iter_mut().zip(other.areal_density.as_flattened())
        {
            *sum += more;
        }
    }

    /// Areal densities of a block's rays in a row, g/cm².
    pub(in crate::engine::cpu) fn areal_density(
        &self,
        accumulator: usize,
        row: usize,
        block: usize,
    ) -> &Wide {
        &self.areal_density[self.at(accumulator, row, block)]
    }
}
