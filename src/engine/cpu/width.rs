//! How wide a pixel is along its ray.

use crate::raycast::{Footprint, distance_driven};

/// Smallest half-width, voxels.
const LEAST: f32 = distance_driven::POINT as f32;

/// Half-widths across a path, of the pixel whose ray it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Widths {
    /// Along u and v: the two half-sides' extents, each at the middle cell and its change per cell.
    sides: [[[f32; 2]; 2]; 2],
    /// Whether the pixel is nowhere wider than a voxel, so that it covers at most two along each axis.
    pub narrow: bool,
}

impl Widths {
    /// A point, where no algorithm asks.
    pub(super) const POINT: Self = Self { sides: [[[0.0; 2]; 2]; 2], narrow: true };

    /// In cells of one slice, of which the middle one is `from_centre` slices from the volume's centre; the path is in the
    /// cells from `cells[0]` to `cells[1]`, counted from that one.
    pub(super) fn new(footprint: &Footprint, from_centre: f64, cells: [f64; 2]) -> Self {
        let side = |side: usize, t: usize| {
            let slope = footprint.slope[side][t];
            [(footprint.base[side][t] + slope * from_centre) as f32, slope as f32]
        };
        // Half-widths are convex along the ray: the largest is at an end.
        let ends = cells.map(|cell| footprint.half_widths(from_centre + cell));
        let narrow = ends.as_flattened().iter().all(|&half| half <= 0.5);
        Self { sides: [0, 1].map(|t| [side(0, t), side(1, t)]), narrow }
    }

    /// `t` cells from the middle one, along u or v.
    #[inline(always)]
    pub(super) fn at(&self, axis: usize, t: f32) -> f32 {
        let [a, b] = self.sides[axis].map(|[base, slope]| base + slope * t);
        let half = (a * a + b * b).sqrt();
        if half > LEAST { half } else { LEAST }
    }
}
