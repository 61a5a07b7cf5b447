//! How far two motions of an object are apart.

use glam::DVec3;

use crate::geometry::{Grid, RigidMotion};

/// The mean target registration error (van de Kraats, Penney, Tomaževič, van Walsum & Niessen, IEEE TMI 24(9), 1177, 2005,
/// §II-D), with the eight corners of a volume's box as targets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetError {
    corners: [DVec3; 8],
    pivot: DVec3,
}

impl TargetError {
    /// For motions about `pivot`, world mm.
    pub fn new(grid: &Grid, pivot: DVec3) -> Self {
        let corner = |n: usize| {
            let at =
                |axis: usize| if n >> axis & 1 == 1 { grid.dimensions()[axis] as f64 - 0.5 } else { -0.5 };
            grid.index_to_world().transform_point3(DVec3::new(at(0), at(1), at(2)))
        };
        Self { corners: std::array::from_fn(corner), pivot }
    }

    /// Distance of a corner from the box's centre, mm: the mean of all.
    pub(super) fn radius(&self) -> f64 {
        let centre = self.corners.iter().sum::<DVec3>() / 8.0;
        self.corners.iter().map(|corner| corner.distance(centre)).sum::<f64>() / 8.0
    }

    /// Mean distance of the corners after one motion and after the other, mm.
    pub fn between(&self, one: &RigidMotion, other: &RigidMotion) -> f64 {
        let distance =
            |&corner: &DVec3| (one.moved(corner, self.pivot) - other.moved(corner, self.pivot)).length();
        self.corners.iter().map(distance).sum::<f64>() / 8.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_length_of_a_translation_and_a_turn_s_mean_chord() {
        let grid = Grid::centred([10, 20, 30], DVec3::ONE).expect("valid");
        let error = TargetError::new(&grid, grid.centre());
        let still = RigidMotion::default();
        let shift = RigidMotion { translation: DVec3::new(3.0, 4.0, 12.0), ..still };
        assert!((error.between(&still, &shift) - 13.0).abs() < 1e-12);
        let turn = RigidMotion { angles: [0.0, 0.0, 0.2], ..still };
        // All corners are √(5² + 10²) from the axis.
        let chord = 2.0 * 125.0_f64.sqrt() * 0.1_f64.sin();
        assert!((error.between(&still, &turn) - chord).abs() < 1e-12);
    }
}
