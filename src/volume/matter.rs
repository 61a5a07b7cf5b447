//! Which matter counts.

use crate::error::{Error, Result};

/// Largest floor, g/cm³: nothing is as dense.
const MAX_FLOOR: f64 = 1000.0;

/// The matter of a volume that counts: that of some labels, in bricks where it is denser than a floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matter {
    labels: u8,
    floor: f64,
}

impl Matter {
    /// All but vacuum.
    pub const ANY: Self = Self { labels: u8::MAX, floor: 0.0 };

    /// That of some labels, bit m for label m, above a density of `floor`, g/cm³. With a floor of 0 all matter of the labels
    /// counts; else what does not is at most `floor` dense, and a ray loses at most `floor` times the length in it.
    ///
    /// # Errors
    /// `InvalidArgument` for a floor outside 0 … 1000 g/cm³.
    pub fn new(labels: u8, floor: f64) -> Result<Self> {
        if !(0.0..=MAX_FLOOR).contains(&floor) {
            return Err(Error::invalid("floor", floor, format!("0 … {MAX_FLOOR} g/cm³")));
        }
        Ok(Self { labels, floor })
    }

    /// The labels, bit m for label m.
    pub fn labels(&self) -> u8 {
        self.labels
    }

    /// The floor, g/cm³.
    pub fn floor(&self) -> f64 {
        self.floor
    }

    /// What a ray loses at most that passes `mm` through what does not count, g/cm²: floor × length.
    pub fn lost(&self, mm: f64) -> f64 {
        0.1 * mm * self.floor
    }
}
