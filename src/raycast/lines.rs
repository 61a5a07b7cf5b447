//! A view's rays in closed form: every quantity changes evenly from pixel to pixel.

use glam::DVec3;

/// A vector that changes evenly: `constant + column·i + row·j` at pixel (i, j).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Even {
    pub constant: DVec3,
    pub column: DVec3,
    pub row: DVec3,
}

impl Even {
    /// The vector at a pixel, or between pixels.
    pub(crate) fn at(&self, column: f64, row: f64) -> DVec3 {
        self.constant + column * self.column + row * self.row
    }

    /// The same vector everywhere.
    pub(super) fn constant(constant: DVec3) -> Self {
        Self { constant, column: DVec3::ZERO, row: DVec3::ZERO }
    }

    /// Multiplied by a number.
    pub(super) fn times(self, factor: f64) -> Self {
        Self { constant: factor * self.constant, column: factor * self.column, row: factor * self.row }
    }
}

/// What places a line in space, beside its direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Anchor {
    /// One of its points, near the volume.
    Point(Even),
    /// Its moment about the grid's centre, (point − centre) × direction, the same for all its points (Plücker).
    Moment(Even),
}

/// All rays of a view in index space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lines {
    /// The grid's centre.
    pub centre: DVec3,
    /// From the source on; of any length.
    pub direction: Even,
    pub anchor: Anchor,
    /// Where rays start; `None`: nowhere.
    pub source: Option<DVec3>,
    /// Where rays end; `None`: nowhere.
    pub pixel: Option<Even>,
}
