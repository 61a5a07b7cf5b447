//! HU in, voxels out: slab by slab, so that a reader never holds the volume twice.

use rayon::prelude::*;

use crate::allocation::{filled, reserved};
use crate::error::{Error, Result};
use crate::geometry::Grid;
use crate::physics::{Calibration, MAX_MATERIALS, Thresholds};
use crate::volume::seen::Seen;
use crate::volume::{MaterialStatistics, Volume, Voxel, Voxels};

/// How HU become density and material.
#[derive(Debug, Clone)]
pub struct Classification {
    /// HU → density.
    pub calibration: Calibration,
    /// HU → material where no label is given.
    pub thresholds: Thresholds,
}

impl Classification {
    /// Built-in curves by name; see [`Calibration::names`] and [`Thresholds::names`].
    pub fn named(calibration: &str, thresholds: &str) -> Result<Self> {
        Ok(Self { calibration: Calibration::named(calibration)?, thresholds: Thresholds::named(thresholds)? })
    }
}

/// Below this HU a voxel is padding, not tissue: it lies outside the scan and is vacuum whatever the calibration.
const PADDING_BELOW_HU: f64 = -1024.0;

impl Classification {
    /// Density and material of a voxel; a given label wins over the thresholds.
    pub fn voxel(&self, hu: f64, label: Option<u8>) -> Voxel {
        let density = if hu < PADDING_BELOW_HU { 0.0 } else { self.calibration.density(hu) };
        Voxel { density, label: label.unwrap_or_else(|| self.thresholds.class(hu)) }
    }
}

/// What a 16-bit code means.
#[derive(Debug, Clone, Copy)]
pub(super) enum Code {
    /// The HU itself, moved to 0 … 65535.
    Hu,
    /// The label in the upper 3 bits, HU + 1025 limited to 0 … 8191 in the lower 13. The limit changes no density:
    /// 0 is padding, and calibrations are constant above 3071 HU.
    LabelAndHu,
}

impl Code {
    fn encode(self, hu: i16, label: u8) -> u16 {
        match self {
            Self::Hu => hu.cast_unsigned() ^ 0x8000,
            Self::LabelAndHu => {
                u16::from(label) << 13 | hu.saturating_add(1025).clamp(0, 8191).cast_unsigned()
            }
        }
    }

    /// The CT number, limited or not.
    pub(super) fn hu(self, code: u16) -> i32 {
        match self {
            Self::Hu => (code ^ 0x8000).cast_signed().into(),
            Self::LabelAndHu => i32::from(code & 0x1fff) - 1025,
        }
    }

    pub(super) fn meaning(self, code: u16, how: &Classification) -> Voxel {
        let label = match self {
            Self::Hu => None,
            Self::LabelAndHu => Some((code >> 13) as u8),
        };
        how.voxel(f64::from(self.hu(code)), label)
    }
}

/// Voxels per parallel piece of work.
pub(super) const PIECE: usize = 1 << 16;

/// Makes a [`Volume`] from voxels that arrive in order, in pieces of any size. They are copied: with two slabs in turns, a
/// reader fills one while the other is made voxels of.
///
/// ```
/// # use drr::{geometry::Grid, physics::{Calibration, Thresholds}, volume::{Classification, VolumeBuilder}};
/// # use std::{sync::mpsc::channel, thread};
/// # let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT)?;
/// # let grid = Grid::centred([64, 64, 40], glam::DVec3::ONE)?;
/// # let read = |slice: usize, slab: &mut Vec<i16>| slab.fill(slice as i16);
/// let mut builder = VolumeBuilder::int16(grid, &how, false)?;
/// let ((filled, slabs), (done, free)) = (channel(), channel());
/// (0..2).try_for_each(|_| done.send(vec![0; 64 * 64]))?;
/// thread::scope(|scope| {
///     scope.spawn(move || {
///         for (slice, mut slab) in (0..40).zip(free) {
///             read(slice, &mut slab);
///             if filled.send(slab).is_err() {
///                 return;
///             }
///         }
///     });
///     for slab in slabs {
///         builder.push_int16(&slab, None)?;
///         // The reader may have all it needs.
///         let _ = done.send(slab);
///     }
///     drr::Result::Ok(())
/// })?;
/// let volume = builder.finish()?;
/// # let density = |slice: usize| volume.voxels().get(64 * 64 * slice).density;
/// # assert!((1..40).all(|slice| density(slice) > density(slice - 1)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct VolumeBuilder {
    grid: Grid,
    how: Classification,
    store: Store,
    /// Whether any piece came with labels.
    labelled: bool,
}

/// The voxels that have come; memory for all is reserved from the start, and touched when they come.
#[derive(Debug)]
enum Store {
    Int16 { code: Code, codes: Vec<u16>, seen: Seen },
    Float32 { density: Vec<f32>, label: Vec<u8> },
}

impl Store {
    /// Voxels that have come.
    fn filled(&self) -> usize {
        match self {
            Self::Int16 { codes, .. } => codes.len(),
            Self::Float32 { label, .. } => label.len(),
        }
    }
}

impl VolumeBuilder {
    /// For integer HU. `labelled` says whether every piece comes with labels or none does.
    pub fn int16(grid: Grid, how: &Classification, labelled: bool) -> Result<Self> {
        let code = if labelled { Code::LabelAndHu } else { Code::Hu };
        let codes = reserved(grid.voxel_count(), "the volume")?;
        let store = Store::Int16 { code, codes, seen: Seen::none() };
        Ok(Self { grid, how: how.clone(), store, labelled: false })
    }

    /// For HU that are not integers.
    pub fn float32(grid: Grid, how: &Classification) -> Result<Self> {
        let n = grid.voxel_count();
        let store = Store::Float32 {
            density: reserved(n, "the volume's densities")?,
            label: reserved(n, "the volume's labels")?,
        };
        Ok(Self { grid, how: how.clone(), store, labelled: false })
    }

    /// The next voxels, with their labels if the builder was made for labels.
    pub fn push_int16(&mut self, hu: &[i16], labels: Option<&[u8]>) -> Result<()> {
        let first = self.check(hu.len(), labels)?;
        let Store::Int16 { code, codes, seen } = &mut self.store else {
            self.extend_float32(hu, labels);
            return Ok(());
        };
        let each = hu.par_iter().with_min_len(PIECE);
        match (*code, labels) {
            (Code::Hu, None) => codes.par_extend(each.map(|&hu| Code::Hu.encode(hu, 0))),
            (Code::LabelAndHu, Some(labels)) => {
                codes.par_extend(each.zip(labels).map(|(&hu, &label)| Code::LabelAndHu.encode(hu, label)));
            }
            _ => {
                let given = if labels.is_some() { "labels" } else { "no labels" };
                return Err(Error::invalid(
                    "labels",
                    given,
                    "labels with every piece of the volume or with none",
                ));
            }
        }
        // Apart from the encoding, which is as fast as a copy as long as nothing else is done.
        seen.note(&codes[first..]);
        self.labelled |= labels.is_some();
        Ok(())
    }

    /// The next voxels of a float32 volume, with or without labels.
    pub fn push_float32(&mut self, hu: &[f32], labels: Option<&[u8]>) -> Result<()> {
        let first = self.check(hu.len(), labels)?;
        if matches!(self.store, Store::Int16 { .. }) {
            return Err(Error::invalid("hu", "float32", "int16, as the builder was made for"));
        }
        if let Some(bad) = hu.iter().position(|v| !v.is_finite()) {
            let count = hu.iter().filter(|v| !v.is_finite()).count();
            let at = self.position(first + bad);
            return Err(Error::invalid(
                format!("hu at voxel {at:?}"),
                hu[bad],
                format!("finite HU ({count} are not)"),
            ));
        }
        self.extend_float32(hu, labels);
        Ok(())
    }

    /// Appends checked voxels to a float32 volume.
    fn extend_float32<T: Copy + Into<f64> + Sync>(&mut self, hu: &[T], labels: Option<&[u8]>) {
        let Store::Float32 { density, label } = &mut self.store else {
            unreachable!("the callers have looked");
        };
        let voxel = |i: usize, hu: T| self.how.voxel(hu.into(), labels.map(|labels| labels[i]));
        let voxels = hu.par_iter().with_min_len(PIECE).enumerate().map(|(i, &hu)| voxel(i, hu));
        let mut vectors = (std::mem::take(density), std::mem::take(label));
        vectors.par_extend(voxels.map(|voxel| (voxel.density as f32, voxel.label)));
        (*density, *label) = vectors;
        self.labelled |= labels.is_some();
    }

    /// The volume, once all voxels have come.
    pub fn finish(self) -> Result<Volume> {
        let expected = self.grid.voxel_count();
        let given = self.store.filled();
        if given != expected {
            return Err(Error::invalid("number of voxels", given, format!("{expected}, the grid's")));
        }
        let mut materials = [MaterialStatistics::default(); MAX_MATERIALS];
        let mut note = |voxel: Voxel| materials[usize::from(voxel.label)].note(voxel);
        let voxels = match self.store {
            Store::Int16 { code, codes, seen } => {
                let mut table = filled(1 << 16, Voxel::default(), "the volume's table")?;
                for c in (0..=u16::MAX).filter(|&c| seen.has(c)) {
                    let voxel = code.meaning(c, &self.how);
                    table[usize::from(c)] = voxel;
                    note(voxel);
                }
                Voxels::Coded { codes, table }
            }
            Store::Float32 { density, label } => {
                let each = density.iter().zip(&label);
                each.for_each(|(&d, &label)| note(Voxel { density: f64::from(d), label }));
                Voxels::Dense { density, label }
            }
        };
        let classes = (!self.labelled).then(|| self.how.thresholds.materials().to_vec());
        Ok(Volume::made(self.grid, voxels, materials, classes, self.how))
    }

    /// Checks the next piece and returns the number of its first voxel.
    fn check(&self, count: usize, labels: Option<&[u8]>) -> Result<usize> {
        let filled = self.store.filled();
        let left = self.grid.voxel_count() - filled;
        if count > left {
            return Err(Error::invalid(
                "number of voxels",
                filled + count,
                format!("{}", self.grid.voxel_count()),
            ));
        }
        if let Some(labels) = labels {
            if labels.len() != count {
                return Err(Error::invalid(
                    "number of labels",
                    labels.len(),
                    format!("{count}, one per voxel"),
                ));
            }
            let valid = |&label: &u8| usize::from(label) < MAX_MATERIALS;
            // Piece by piece without early exit, which the compiler vectorises.
            let all_valid = |piece: &[u8]| piece.iter().fold(true, |all, label| all & valid(label));
            if !labels.par_chunks(PIECE).all(all_valid)
                && let Some(bad) = labels.iter().position(|label| !valid(label))
            {
                let at = self.position(filled + bad);
                return Err(Error::invalid(format!("labels at voxel {at:?}"), labels[bad], "0 … 7"));
            }
        }
        Ok(filled)
    }

    fn position(&self, index: usize) -> [usize; 3] {
        let [n0, n1, _] = self.grid.dimensions();
        [index % n0, index / n0 % n1, index / (n0 * n1)]
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn grid(n: usize) -> Grid {
        Grid::centred([n, 1, 1], DVec3::ONE).expect("valid")
    }

    #[test]
    fn labels_win_over_thresholds_and_padding_is_vacuum() {
        let hu = [-32768, -2048, -1000, 0, 3071, i16::MAX];
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
        let plain = Volume::from_int16(grid(6), &hu, None, &how).expect("valid");
        let labels = [3, 3, 3, 1, 0, 7];
        let labelled = Volume::from_int16(grid(6), &hu, Some(&labels), &how).expect("valid");
        for (i, label) in labels.into_iter().enumerate() {
            let (a, b) = (plain.voxels().get(i), labelled.voxels().get(i));
            assert_eq!(a.density, how.calibration.density(f64::from(hu[i])));
            assert_eq!(a.density, b.density);
            assert_eq!(b.label, label);
        }
        assert_eq!([0, 1, 2, 3, 4, 5].map(|i| plain.voxels().get(i).label), [0, 0, 0, 2, 3, 3]);
        assert_eq!(plain.voxels().get(0).density, 0.0);
        assert_eq!(labelled.materials()[3], MaterialStatistics { labelled: true, max_density: 0.0 });
        assert!(!labelled.materials()[2].labelled);
    }

    #[test]
    fn pieces_of_any_size_make_the_same_volume() {
        let grid = Grid::centred([256, 256, 3], DVec3::ONE).expect("valid");
        let hu: Vec<i16> = (0..grid.voxel_count()).map(|n| (n.wrapping_mul(40_503) >> 3) as i16).collect();
        let labels: Vec<u8> = (0..hu.len()).map(|n| (n % 7) as u8).collect();
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
        for labels in [None, Some(&labels[..])] {
            let whole = Volume::from_int16(grid, &hu, labels, &how).expect("valid");
            let mut builder = VolumeBuilder::int16(grid, &how, labels.is_some()).expect("memory");
            let ends = [0, 1, 63, 127, PIECE, PIECE, 2 * PIECE + 130, hu.len()];
            for piece in ends.windows(2).map(|ends| ends[0]..ends[1]) {
                let labels = labels.map(|labels| &labels[piece.clone()]);
                builder.push_int16(&hu[piece], labels).expect("valid");
            }
            let pieces = builder.finish().expect("complete");
            for volume in [&whole, &pieces] {
                for (n, &hu) in hu.iter().enumerate() {
                    let expected = how.voxel(f64::from(hu), labels.map(|labels| labels[n]));
                    assert_eq!(volume.voxels().get(n), expected, "voxel {n} of {hu} HU");
                }
            }
            assert_eq!(whole.materials(), pieces.materials());
        }
    }

    #[test]
    fn bad_voxels_are_refused_by_place_and_count() {
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
        let hu = [0.0, f32::NAN, 3.0, f32::INFINITY];
        let error = Volume::from_float32(grid(4), &hu, None, &how).expect_err("NaN");
        assert_eq!(error.to_string(), "hu at voxel [1, 0, 0] is NaN; valid: finite HU (2 are not)");
        let error = Volume::from_int16(grid(2), &[0, 0], Some(&[0, 8]), &how).expect_err("label 8");
        assert_eq!(error.to_string(), "labels at voxel [1, 0, 0] is 8; valid: 0 … 7");
        assert!(Volume::from_int16(grid(3), &[0, 0], None, &how).is_err(), "a voxel is missing");
        assert!(Volume::from_int16(grid(1), &[0, 0], None, &how).is_err(), "a voxel too many");
    }
}
