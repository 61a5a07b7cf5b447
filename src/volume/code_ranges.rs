//! What 16-bit codes stand for, over ranges of them.

use crate::allocation::{collected, reserved};
use crate::error::Result;
use crate::volume::Voxel;

/// What some voxels hold.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Held {
    /// Labels of those with a density above 0, a bit each.
    pub labels: u8,
    /// Largest density, g/cm³, rounded up.
    pub densest: f32,
}

impl Held {
    fn of(voxel: Voxel) -> Self {
        let nearest = voxel.density as f32;
        let densest = if f64::from(nearest) < voxel.density { nearest.next_up() } else { nearest };
        Self { labels: u8::from(voxel.density > 0.0) << voxel.label, densest }
    }

    /// What both hold.
    pub(super) fn and(self, other: Self) -> Self {
        Self { labels: self.labels | other.labels, densest: self.densest.max(other.densest) }
    }
}

/// What the codes of any range hold, in two look-ups: a sparse table (Bender and Farach-Colton, LATIN 2000).
pub(super) struct CodeRanges {
    /// Level n at i: the codes i … i + 2ⁿ − 1.
    levels: Vec<Vec<Held>>,
}

impl CodeRanges {
    /// Of codes with this meaning.
    pub(super) fn new(table: &[Voxel]) -> Result<Self> {
        let what = "ranges of the volume's codes";
        let mut levels = reserved(table.len().ilog2() as usize + 1, what)?;
        let mut finest = collected(table.iter().map(|&voxel| Held::of(voxel)), what)?;
        for width in (0..table.len().ilog2()).map(|level| 1 << level) {
            let pairs = finest.iter().zip(&finest[width..]).map(|(&low, &high)| low.and(high));
            let next = collected(pairs, what)?;
            levels.push(std::mem::replace(&mut finest, next));
        }
        levels.push(finest);
        Ok(Self { levels })
    }

    /// What a voxel with this code holds.
    pub(super) fn of(&self, code: u16) -> Held {
        self.levels[0][usize::from(code)]
    }

    /// What voxels with all codes from `low` to `high` would hold.
    pub(super) fn between(&self, low: u16, high: u16) -> Held {
        let level = (usize::from(high) - usize::from(low) + 1).ilog2() as usize;
        let last = usize::from(high) + 1 - (1 << level);
        self.levels[level][usize::from(low)].and(self.levels[level][last])
    }

    /// What voxels with these codes hold, of which `known` is known, and that it is no more than `most`.
    pub(super) fn of_all(&self, known: Held, most: Held, codes: impl Iterator<Item = u16>) -> Held {
        let mut held = known;
        for code in codes {
            held = held.and(self.of(code));
            if held == most {
                break;
            }
        }
        held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_holds_what_its_codes_hold() {
        let voxel = |code: usize| Voxel {
            density: [0.0, 0.1, 1.0, 0.3, 0.0, 2.0][code % 6] * code as f64,
            label: (code / 10 % 8) as u8,
        };
        let table: Vec<_> = (0..1 << 8).map(voxel).collect();
        let ranges = CodeRanges::new(&table).expect("little memory");
        for low in (0..256).step_by(5) {
            for high in low..256 {
                let each = table[low..=high].iter().map(|&voxel| Held::of(voxel));
                let exact = each.fold(Held::default(), Held::and);
                assert_eq!(ranges.between(low as u16, high as u16), exact, "{low} … {high}");
            }
        }
    }

    #[test]
    fn densities_are_rounded_up() {
        for density in [0.0, 0.1, 0.3, 1.0, 1.7, 1e-50] {
            let held = Held::of(Voxel { density, label: 0 }).densest;
            assert!(f64::from(held) >= density && f64::from(held) <= density * (1.0 + 1.2e-7) + 2e-45);
        }
    }
}
