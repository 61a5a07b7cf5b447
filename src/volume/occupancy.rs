//! Where a volume holds what: of every brick of voxels the materials, and the largest density.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::{Error, Result};
use crate::volume::code_ranges::CodeRanges;
use crate::volume::{Matter, Occupied, Voxel, Voxels};

/// Voxels along each side of a brick; `DRR_BRICK` of the GPU engines.
pub(crate) const BRICK: usize = 8;

/// Bricks along each axis of a volume; the last ones may reach beyond its end.
pub(crate) fn bricks(dimensions: [usize; 3]) -> [usize; 3] {
    dimensions.map(|n| n.div_ceil(BRICK))
}

/// What the bricks of 8 × 8 × 8 voxels of a volume hold: 5 bytes each, 0.5 % of 16-bit voxels.
///
/// Coarser levels are made by [`Occupied`], of what counts: there they are tighter than of labels and densities apart.
#[derive(Debug)]
pub struct Occupancy {
    dimensions: [usize; 3],
    /// By brick, x fastest: bit m is set where a voxel of label m has a density above 0.
    labels: Vec<u8>,
    /// By brick: its largest density, g/cm³, rounded up.
    densest: Vec<f32>,
}

impl Occupancy {
    /// Of the voxels of a volume.
    ///
    /// # Errors
    /// `Unsupported` for voxels in a texture; `OutOfMemory`.
    pub(super) fn new(dimensions: [usize; 3], voxels: &Voxels) -> Result<Self> {
        let count = bricks(dimensions).iter().product();
        let mut made = Self {
            dimensions,
            labels: filled(count, 0, "the volume's occupancy")?,
            densest: filled(count, 0.0, "the volume's occupancy")?,
        };
        match voxels {
            Voxels::Coded { codes, table } => made.note_codes(codes, table)?,
            Voxels::Dense { density, label } => made.note_densities(density, label),
            Voxels::Texture { .. } => {
                let text =
                    "what is where is not known of a volume in a texture, which the host does not read";
                return Err(Error::Unsupported(text.into()));
            }
        }
        Ok(made)
    }

    /// One pass over the codes: the least and the largest of each brick, which the processor finds many at a time, mostly
    /// say what it holds. Where they do not, its voxels are looked up.
    fn note_codes(&mut self, codes: &[u16], table: &[Voxel]) -> Result<()> {
        let ranges = CodeRanges::new(table)?;
        let rows = Rows::new(self.dimensions);
        let [n0, ..] = self.dimensions;
        let extremes = || (vec![u16::MAX; n0], vec![u16::MIN; n0]);
        self.lines().for_each_init(extremes, |(low, high), (line, labels, densest)| {
            low.fill(u16::MAX);
            high.fill(u16::MIN);
            for row in rows.of(line) {
                let least_and_largest = low.iter_mut().zip(high.iter_mut());
                for ((low, high), &code) in least_and_largest.zip(&codes[row..row + n0]) {
                    *low = (*low).min(code);
                    *high = (*high).max(code);
                }
            }
            let columns = low.chunks(BRICK).zip(high.chunks(BRICK)).enumerate();
            for ((brick, (low, high)), (labels, densest)) in columns.zip(labels.iter_mut().zip(densest)) {
                let low = low.iter().copied().min().unwrap_or_default();
                let high = high.iter().copied().max().unwrap_or_default();
                let within = ranges.between(low, high);
                let ends = ranges.of(low).and(ranges.of(high));
                let held = if ends == within {
                    ends
                } else {
                    let columns = brick * BRICK..((brick + 1) * BRICK).min(n0);
                    let voxels = rows.of(line).flat_map(|row| &codes[row + columns.start..row + columns.end]);
                    ranges.of_all(ends, within, voxels.copied())
                };
                (*labels, *densest) = (held.labels, held.densest);
            }
        });
        Ok(())
    }

    fn note_densities(&mut self, density: &[f32], label: &[u8]) {
        let rows = Rows::new(self.dimensions);
        let [n0, ..] = self.dimensions;
        self.lines().for_each(|(line, labels, densest)| {
            for row in rows.of(line) {
                let bricks = density[row..row + n0].chunks(BRICK).zip(label[row..row + n0].chunks(BRICK));
                for ((density, label), (labels, densest)) in bricks.zip(labels.iter_mut().zip(&mut *densest))
                {
                    for (&density, &label) in density.iter().zip(label) {
                        *labels |= u8::from(density > 0.0) << label;
                        *densest = densest.max(density);
                    }
                }
            }
        });
    }

    /// Each line of bricks along x with its number.
    fn lines(&mut self) -> impl IndexedParallelIterator<Item = (usize, &mut [u8], &mut [f32])> {
        let [b0, ..] = bricks(self.dimensions);
        let lines = self.labels.par_chunks_mut(b0).zip(self.densest.par_chunks_mut(b0)).enumerate();
        lines.map(|(line, (labels, densest))| (line, labels, densest))
    }

    /// Voxels along each axis.
    pub fn dimensions(&self) -> [usize; 3] {
        self.dimensions
    }

    /// Bricks along each axis; the last ones may reach beyond the volume's end.
    pub fn bricks(&self) -> [usize; 3] {
        bricks(self.dimensions)
    }

    /// The labels of the voxels in a brick whose density is above 0: bit m stands for label m. Brick (i, j, k) is at
    /// `(k*b1 + j)*b0 + i`.
    pub fn labels(&self, brick: usize) -> u8 {
        self.labels[brick]
    }

    /// Those of all bricks, x fastest.
    pub(crate) fn all_labels(&self) -> &[u8] {
        &self.labels
    }

    /// The part of all bricks that hold nothing of these labels.
    pub(crate) fn empty(&self, labels: u8) -> f64 {
        let empty = self.labels.iter().filter(|&&held| held & labels == 0).count();
        empty as f64 / self.labels.len() as f64
    }

    /// The largest density in a brick, g/cm³, rounded up to a float32.
    pub fn densest(&self, brick: usize) -> f32 {
        self.densest[brick]
    }

    /// Which bricks hold matter that counts.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn of(&self, matter: Matter) -> Result<Occupied> {
        let counts = |brick: usize| {
            self.labels[brick] & matter.labels() != 0 && f64::from(self.densest[brick]) > matter.floor()
        };
        Occupied::new(self.dimensions, counts)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.labels[..]) + size_of_val(&self.densest[..])
    }
}

/// Where the rows of voxels are that a line of bricks consists of.
#[derive(Clone, Copy)]
struct Rows {
    dimensions: [usize; 3],
}

impl Rows {
    fn new(dimensions: [usize; 3]) -> Self {
        Self { dimensions }
    }

    /// Flat indices of the first voxel of each row.
    fn of(self, line: usize) -> impl Iterator<Item = usize> {
        let [n0, n1, n2] = self.dimensions;
        let [j, k] = [line % n1.div_ceil(BRICK), line / n1.div_ceil(BRICK)].map(|brick| brick * BRICK);
        let slices = k..(k + BRICK).min(n2);
        slices.flat_map(move |k| (j..(j + BRICK).min(n1)).map(move |j| (k * n1 + j) * n0))
    }
}

#[cfg(test)]
mod tests;
