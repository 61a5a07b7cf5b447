//! Line integrals through a phantom, in closed form.

use glam::DVec3;

use super::Phantom;
use super::sweep::Sweep;
use crate::error::{Error, Result};

impl Phantom {
    /// Exact length in mm of the segment `from` → `to` (world mm) inside the visible region of every part; one number
    /// per part, in the order of `parts`. A part is visible where no later part contains the point.
    pub fn lengths(&self, from: DVec3, to: DVec3) -> Vec<f64> {
        let mut lengths = vec![0.0; self.parts().len()];
        self.visit(from, to, |part, length| lengths[part] = length);
        lengths
    }

    /// Areal density in g/cm² of every material along the segment `from` → `to` (world mm):
    /// `A[m] = 0.1 * Σ density(hu) * length` over the parts made of m, with `density` in g/cm³ and the length in mm.
    /// What surrounds the parts counts as vacuum.
    ///
    /// # Errors
    /// `InvalidArgument` when a part's material is not one of the `materials` that are asked for.
    pub fn areal_densities(
        &self,
        from: DVec3,
        to: DVec3,
        density: &dyn Fn(i16) -> f64,
        materials: usize,
    ) -> Result<Vec<f64>> {
        let needed = self.parts().iter().map(|part| usize::from(part.material) + 1).max().unwrap_or(0);
        if materials < needed {
            return Err(Error::invalid(
                "materials",
                materials,
                format!("at least {needed} for this phantom"),
            ));
        }
        let mut sums = vec![0.0; materials];
        self.visit(from, to, |index, length| {
            let part = &self.parts()[index];
            sums[usize::from(part.material)] += 0.1 * density(part.hu) * length;
        });
        Ok(sums)
    }

    /// Calls `found(part, length in mm)` for every part that the segment meets.
    fn visit(&self, from: DVec3, to: DVec3, mut found: impl FnMut(usize, f64)) {
        let length = (to - from).length();
        let Some(first) = self.parts().first() else { return };
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        // Count from the point next to the phantom, found from the nearer end: a far end costs no digits.
        let direction = (to - from) / length;
        let middle = first.shape.centre();
        let range = [from, to].map(|end| (end - middle).dot(direction));
        let (end, at) = if range[0].abs() < range[1].abs() { (from, range[0]) } else { (to, range[1]) };
        let origin = direction.mul_add(DVec3::splat(-at), end);
        for span in Sweep::default().run(self.parts().iter().enumerate(), origin, direction, range) {
            found(span.part, span.visible);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phantom::{Part, Shape};

    fn part(shape: Shape, hu: i16, material: u8) -> Part {
        Part { shape, hu, material }
    }

    fn overlapping() -> Phantom {
        let along = DVec3::new(0.6, 0.0, 0.8);
        Phantom::new(
            "overlapping",
            vec![
                part(Shape::sphere(DVec3::ZERO, 50.0), 0, 2),
                part(Shape::sphere(DVec3::new(30.0, 5.0, 0.0), 35.0), 500, 3),
                part(
                    Shape::Cylinder {
                        centre: DVec3::new(5.0, 0.0, 0.0),
                        axis: along,
                        radius: 12.0,
                        half_length: 60.0,
                    },
                    -800,
                    1,
                ),
                part(
                    Shape::Cuboid { minimum: DVec3::new(-20.0, -9.0, -15.0), maximum: DVec3::splat(25.0) },
                    40,
                    2,
                ),
            ],
        )
        .unwrap()
    }

    /// Segments in many directions past the phantom's middle.
    fn segments(count: u32) -> impl Iterator<Item = (DVec3, DVec3)> {
        (0..count).map(move |n| {
            let a = f64::from(n) * 2.399_963;
            let z = 1.98 * (f64::from(n) + 0.5) / f64::from(count) - 0.99;
            let direction = (DVec3::new(a.cos(), a.sin(), 0.0) * (1.0 - z * z).sqrt()).with_z(z);
            let offset = 25.0 * DVec3::new((3.0 * a).sin(), (5.0 * a).cos(), (7.0 * a).sin());
            (offset - 300.0 * direction, offset + 250.0 * direction)
        })
    }

    /// Midpoint rule over `contains`: wrong by at most one step per change of the visible part.
    fn by_quadrature(phantom: &Phantom, from: DVec3, to: DVec3, samples: u32) -> (Vec<f64>, f64) {
        let mut lengths = vec![0.0; phantom.parts().len()];
        let step = (to - from).length() / f64::from(samples);
        let mut changes = 0;
        let mut last = None;
        for n in 0..samples {
            let point = from.lerp(to, (f64::from(n) + 0.5) / f64::from(samples));
            let top = phantom.parts().iter().rposition(|p| p.shape.contains(point));
            changes += u32::from(top != last);
            last = top;
            if let Some(index) = top {
                lengths[index] += step;
            }
        }
        (lengths, step * f64::from(changes + 2))
    }

    #[test]
    fn lengths_agree_with_quadrature_of_contains() {
        for (phantom, rays) in [
            (overlapping(), 100),
            (Phantom::spheres(), 30),
            (Phantom::boxes(), 30),
            (Phantom::rods(), 30),
            (Phantom::thorax(), 8),
        ] {
            for (from, to) in segments(rays) {
                let exact = phantom.lengths(from, to);
                let (measured, bound) = by_quadrature(&phantom, from, to, 4000);
                for (index, (a, b)) in exact.iter().zip(&measured).enumerate() {
                    assert!((a - b).abs() <= bound, "{} part {index}: {a} {b} ± {bound}", phantom.name());
                }
            }
        }
    }

    #[test]
    fn lengths_sum_to_the_chord_of_the_union() {
        // Every part inside the first: the union is the first, whatever is painted on it.
        let phantom = Phantom::new(
            "nested",
            vec![
                part(Shape::sphere(DVec3::ZERO, 50.0), 0, 2),
                part(Shape::sphere(DVec3::new(10.0, 0.0, 0.0), 30.0), 1, 2),
                part(Shape::sphere(DVec3::new(-10.0, 5.0, 0.0), 30.0), 2, 2),
                part(
                    Shape::Cuboid { minimum: DVec3::splat(-20.0), maximum: DVec3::new(5.0, 9.0, 20.0) },
                    3,
                    2,
                ),
            ],
        )
        .unwrap();
        let mut crossed = 0;
        for (from, to) in segments(300) {
            let chord = Phantom::new("union", phantom.parts()[..1].to_vec()).unwrap().lengths(from, to)[0];
            let sum: f64 = phantom.lengths(from, to).iter().sum();
            assert!((sum - chord).abs() < 1e-12, "{sum} {chord}");
            crossed += usize::from(phantom.lengths(from, to).iter().filter(|&&l| l > 0.0).count() > 2);
        }
        assert!(crossed > 100, "the rays must cross several parts: {crossed}");
    }

    #[test]
    fn later_parts_hide_earlier_ones() {
        let inner = part(Shape::sphere(DVec3::ZERO, 10.0), 1000, 3);
        let outer = part(Shape::sphere(DVec3::ZERO, 30.0), 0, 2);
        let lengths = |parts| Phantom::new("p", parts).unwrap().lengths(-99.0 * DVec3::X, 99.0 * DVec3::X);
        assert_eq!(lengths(vec![outer, inner]), [40.0, 20.0]);
        assert_eq!(lengths(vec![inner, outer]), [0.0, 60.0]);
    }

    #[test]
    fn segments_end_at_source_and_pixel() {
        let phantom = Phantom::water_cylinder();
        let (a, b) = (DVec3::new(-30.0, 0.0, 10.0), DVec3::new(45.0, 0.0, 10.0));
        assert_eq!(phantom.lengths(a, b), [75.0], "both ends inside");
        assert_eq!(phantom.lengths(a, DVec3::new(500.0, 0.0, 10.0)), [130.0], "source inside");
        assert_eq!(phantom.lengths(DVec3::new(-500.0, 0.0, 10.0), a), [70.0], "pixel inside");
        let outside = DVec3::new(101.0, 0.0, 10.0);
        assert_eq!(phantom.lengths(outside, 5.0 * outside), [0.0], "all behind the source");
        assert_eq!(phantom.lengths(a, a), [0.0], "no length");
    }

    #[test]
    fn the_reversed_segment_has_the_same_lengths() {
        for phantom in [overlapping(), Phantom::thorax()] {
            for (from, to) in segments(40) {
                for (a, b) in phantom.lengths(from, to).iter().zip(phantom.lengths(to, from)) {
                    assert!((a - b).abs() < 1e-12, "{}: {a} {b}", phantom.name());
                }
            }
        }
    }

    #[test]
    fn a_far_source_costs_no_digits() {
        let phantom = overlapping();
        for (_, to) in segments(40) {
            for far in [1e4, 1e6, 1e8] {
                // Powers of two times the direction: near and far sources lie on one line up to rounding of `to`.
                let near = phantom.lengths(to - 2.0 * to, to);
                let distant = phantom.lengths(to - far / 256.0 * to, to);
                for (a, b) in near.iter().zip(distant) {
                    assert!((a - b).abs() < 1e-11, "{far}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn areal_density_is_in_grams_per_square_centimetre() {
        let water = |hu: i16| f64::from(hu) / 1000.0 + 1.0;
        let (from, to) = (DVec3::new(0.0, -1000.0, 0.0), DVec3::new(0.0, 500.0, 0.0));
        let sums = Phantom::water_cylinder().areal_densities(from, to, &water, 4).unwrap();
        assert!((sums[2] - 20.0).abs() < 1e-13, "200 mm of water are 20 g/cm²: {sums:?}");
        assert_eq!([sums[0], sums[1], sums[3]], [0.0; 3]);
        let refused = Phantom::rods().areal_densities(from, to, &water, 3);
        assert!(matches!(refused, Err(Error::InvalidArgument { .. })), "bone is material 3");
    }
}
