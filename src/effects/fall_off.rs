//! How the beam thins out from the foot of the perpendicular to the detector's edge.

use crate::effects::Sight;

/// Photons per area of a flat detector that a point source sends there, relative to the foot of the perpendicular from
/// the source: (D/d)² cos θ = cos³ θ at the distance d = D/cos θ, where photons spread over more area (inverse square)
/// and the detector's area is seen at the angle θ (obliquity). In a parallel beam it is 1.
///
/// H. H. Barrett and W. Swindell, Radiological Imaging, Academic Press 1981, on the geometry of a point source and a
/// plane detector.
pub(crate) fn fall_off(sight: &Sight) -> f64 {
    sight.normal * sight.normal * sight.normal
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::effects::Sights;
    use crate::effects::sight::tests::{SIZE, upright};
    use crate::geometry::{DetectorPose, View};

    #[test]
    fn it_is_the_part_of_a_sphere_that_a_small_pixel_covers() {
        let pose = DetectorPose { row_step: DVec3::new(3.0, 2.0, 5.0), ..upright() };
        let sights = Sights::new(&View::Pose(pose), SIZE);
        let normal = pose.column_step.cross(pose.row_step);
        let distance = normal.dot(pose.first_pixel - pose.source).abs() / normal.length();
        for (i, j) in [(0.0, 0.0), (39.0, 0.0), (7.0, 29.0), (39.0, 29.0)] {
            let ray = pose.pixel(i, j) - pose.source;
            // Solid angle per area, of which the foot of the perpendicular has 1/D².
            let seen = normal.dot(ray).abs() / normal.length() / ray.length().powi(3);
            let factor = fall_off(&sights.at(i, j));
            assert!((factor / (seen * distance * distance) - 1.0).abs() < 1e-13, "{factor}");
        }
    }

    #[test]
    fn all_pixels_together_are_the_solid_angle_of_the_detector() {
        let (pose, size) = (upright(), [200, 150]);
        let sights = Sights::new(&View::Pose(pose), size);
        let [pixel, distance] = [4.0 * 6.0, 1000.0];
        let factors = (0..size[1]).flat_map(|j| (0..size[0]).map(move |i| (i as f64, j as f64)));
        let sum: f64 = factors.map(|(i, j)| fall_off(&sights.at(i, j))).sum();
        // A. Khadjavi, J. Opt. Soc. Am. 58, 1417 (1968): a rectangle with a corner at the foot of the perpendicular.
        let quarter =
            |x: f64, y: f64| (x * y / (distance * (x * x + y * y + distance * distance).sqrt())).atan();
        let [x, y] = [[-50.0, 750.0], [-33.0, 867.0]];
        let exact = quarter(x[1], y[1]) - quarter(x[0], y[1]) - quarter(x[1], y[0]) + quarter(x[0], y[0]);
        let ratio = sum * pixel / (distance * distance) / exact;
        assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
    }

    #[test]
    fn the_corner_of_a_wide_beam() {
        // 45°: a distance of √2 D, seen at cos 45°.
        let sight = Sight { column: 0.5_f64.sqrt(), row: 0.0, normal: 0.5_f64.sqrt() };
        assert!((fall_off(&sight) - 0.5 / 2.0_f64.sqrt()).abs() < 1e-15);
    }
}
