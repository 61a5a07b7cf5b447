//! How far aside of their pencil photons are scattered, and whether there is an object as far aside.
//!
//! Much of the scatter behind a thick slab comes from photons that were scattered more than once, some of them centimetres
//! aside of their pencil. In an object that ends or gets thinner within that distance they are fewer: kernels of slabs
//! overestimate the scatter near edges (the edge effect of Sun & Star-Lack, Phys Med Biol 55, 6695, 2010). Kernels are therefore
//! kept apart by the largest distance of a photon's interactions from its pencil, and of each part as much is used as there
//! is object at that distance.

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::Result;

/// Upper bounds of the classes, cm; the last class has none. The first is that of photons scattered along their pencil, in
/// particular of all that were scattered once.
const BOUNDS_CM: [f64; 6] = [0.75, 2.0, 4.0, 7.0, 11.0, 16.0];
/// Distances that stand for the classes, cm.
const TYPICAL_CM: [f64; CLASSES] = [0.0, 1.4, 3.0, 5.4, 8.8, 13.3, 20.0];
/// Number of classes.
pub(super) const CLASSES: usize = BOUNDS_CM.len() + 1;
/// Width of the border that tells how the object goes on beyond it, cm.
const INWARDS_CM: f64 = 2.0;
/// Directions in which the object is looked at.
const DIRECTIONS: usize = 12;

/// The class of a largest distance in cm.
pub(super) fn class(distance: f64) -> usize {
    BOUNDS_CM.iter().filter(|bound| distance >= **bound).count()
}

/// Means over cells of the areal density.
#[derive(Debug)]
pub(super) struct Surroundings<'a> {
    /// g/cm².
    pub(super) areal_density: &'a [f64],
    /// Number of cells along each axis.
    pub(super) count: [usize; 2],
    /// Size of a cell at the object, cm.
    pub(super) cell_cm: [f64; 2],
}

impl Surroundings<'_> {
    /// For each cell c and class m, at `c*CLASSES + m`, the part of an object as thick as here that is there at the class's
    /// distance: mean over directions of min(1, A there/A here)²,
    /// because photons as far aside mostly interacted there more than once. Of the powers 1, 3/2 and 2 this one comes
    /// nearest to cylinders of water. What lies beyond the detector goes on as its border does.
    pub(super) fn parts(&self) -> Result<Vec<f64>> {
        let mut parts = filled(self.areal_density.len() * CLASSES, 1.0, "the scatter estimate's cells")?;
        parts.par_chunks_mut(CLASSES).enumerate().for_each(|(cell, parts)| {
            let (x, y, here) = (cell % self.count[0], cell / self.count[0], self.areal_density[cell]);
            if here > 0.0 {
                for (part, distance) in parts.iter_mut().zip(TYPICAL_CM).skip(1) {
                    *part = self.part([x as f64, y as f64], distance, here);
                }
            }
        });
        Ok(parts)
    }

    fn part(&self, [x, y]: [f64; 2], distance: f64, here: f64) -> f64 {
        let there = |[dx, dy]: [f64; 2]| {
            let part = (self.at([x + distance * dx, y + distance * dy]) / here).min(1.0);
            part * part
        };
        self.directions().map(there).sum::<f64>() / DIRECTIONS as f64
    }

    /// Steps of 1 cm in all directions, in cells.
    fn directions(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        (0..DIRECTIONS).map(|direction| {
            let angle = TAU * (direction as f64 + 0.5) / DIRECTIONS as f64;
            [angle.cos() / self.cell_cm[0], angle.sin() / self.cell_cm[1]]
        })
    }

    /// Sums over directions of what `terms` makes of the areal densities at two distances from a cell, cm.
    pub(super) fn sum(
        &self,
        cell: usize,
        distances: [f64; 2],
        terms: impl Fn(f64, f64) -> [f64; 2],
    ) -> [f64; 2] {
        let (x, y) = ((cell % self.count[0]) as f64, (cell / self.count[0]) as f64);
        self.directions().fold([0.0; 2], |sums, [dx, dy]| {
            let [near, far] = distances.map(|cm| self.at([x + cm * dx, y + cm * dy]));
            let terms = terms(near, far);
            [0, 1].map(|k| sums[k] + terms[k])
        })
    }

    /// At a place in cells, whose centres are at whole numbers. Beyond the border A² goes on falling as it does in the last
    /// 2 cm, as that of a cylinder nearly does, but does not rise.
    fn at(&self, place: [f64; 2]) -> f64 {
        let border = [0, 1].map(|k| place[k].clamp(0.0, (self.count[k] - 1) as f64));
        let here = self.inside(border);
        let mut square = here * here;
        for k in 0..2 {
            let beyond = (place[k] - border[k]) * self.cell_cm[k];
            if beyond != 0.0 {
                let mut inner = border;
                inner[k] -= beyond.signum() * INWARDS_CM / self.cell_cm[k];
                let fall = self.inside(inner).powi(2) - here * here;
                square -= fall.max(0.0) * beyond.abs() / INWARDS_CM;
            }
        }
        square.max(0.0).sqrt()
    }

    /// Bilinear; what lies outside is as its border.
    fn inside(&self, place: [f64; 2]) -> f64 {
        let axis = |k: usize| {
            let last = self.count[k] - 1;
            let at = place[k].clamp(0.0, last as f64);
            (at as usize, (at as usize + 1).min(last), at.fract())
        };
        let ((x0, x1, fx), (y0, y1, fy)) = (axis(0), axis(1));
        let value = |x: usize, y: usize| self.areal_density[y * self.count[0] + x];
        let [low, high] = [y0, y1].map(|y| value(x0, y) + fx * (value(x1, y) - value(x0, y)));
        low + fy * (high - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_lie_in_their_classes() {
        for (m, typical) in TYPICAL_CM.into_iter().enumerate() {
            assert_eq!(class(typical), m);
        }
        assert_eq!(class(f64::INFINITY), CLASSES - 1);
    }

    #[test]
    fn a_slab_is_everywhere_and_half_a_slab_on_one_side() {
        let (count, cell_cm) = ([61, 61], [1.0, 1.0]);
        let slab = Surroundings { areal_density: &vec![20.0; 61 * 61], count, cell_cm };
        assert!(slab.parts().unwrap().iter().all(|part| (part - 1.0).abs() < 1e-12));
        let half: Vec<f64> = (0..61 * 61).map(|cell| if cell % 61 <= 30 { 20.0 } else { 0.0 }).collect();
        let parts = Surroundings { areal_density: &half, count, cell_cm }.parts().unwrap();
        // On the edge half of the directions lead out, far from it none; where nothing is, nothing is asked.
        for m in 2..CLASSES {
            let part = |x: usize| parts[(30 * 61 + x) * CLASSES + m];
            assert!((part(30) - 0.5).abs() < 0.1, "{m}: {}", part(30));
            assert!((part(5) - 1.0).abs() < 1e-12 && (part(60) - 1.0).abs() < 1e-12);
        }
        // A wedge: less on its thin side, no more than all on its thick one.
        let wedge: Vec<f64> = (0..61 * 61).map(|cell| f64::from(cell % 61) + 1.0).collect();
        let parts = Surroundings { areal_density: &wedge, count, cell_cm }.parts().unwrap();
        // The mean over the thin half of (1 − x cos)², x = 20/31, by the midpoints of 1000 directions.
        let thin = |k: i32| (std::f64::consts::PI * ((f64::from(k) + 0.5) / 1000.0 - 0.5)).cos();
        let power = |k: i32| (1.0 - TYPICAL_CM[6] / 31.0 * thin(k)).powi(2);
        let expected = 0.5 + 0.5 * (0..1000).map(power).sum::<f64>() / 1000.0;
        assert!((parts[(30 * 61 + 30) * CLASSES + 6] - expected).abs() < 5e-3);
    }
}
