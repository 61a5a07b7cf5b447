//! How the source is seen from the pixels of a view.

use glam::DVec3;

use crate::geometry::{DetectorPose, Projection, View};

/// The direction of a ray, from the source to the pixel, in the frame of the detector: a unit vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sight {
    /// Along the columns' direction, in which i grows.
    pub column: f64,
    /// In the detector's plane across the columns' direction, on the side to which j grows.
    pub row: f64,
    /// Along the detector's normal, away from the source: the cosine of the angle to the normal, above 0.
    pub normal: f64,
}

impl Sight {
    /// Along the detector's normal.
    pub(crate) const NORMAL: Self = Self { column: 0.0, row: 0.0, normal: 1.0 };

    /// That of a direction of any length.
    pub(super) fn along(direction: DVec3) -> Self {
        let DVec3 { x: column, y: row, z: normal } = direction.normalize();
        Self { column, row, normal }
    }

    /// The components as a vector.
    pub(super) fn direction(&self) -> DVec3 {
        DVec3::new(self.column, self.row, self.normal)
    }
}

/// The sights of all pixels of a view: each ray's direction changes evenly from pixel to pixel, up to its length.
///
/// The detector of a projection matrix is any of its image planes, on which clip w is the same: all are parallel. There
/// i grows where clip x/w grows and y/w stays, j where y/w falls and x/w stays. In a parallel beam every ray runs along
/// the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sights {
    /// Towards pixel (0, 0).
    first: DVec3,
    /// What each column adds.
    column: DVec3,
    /// What each row adds.
    row: DVec3,
}

impl Sights {
    /// Those of a view that is valid (`View::validate`) on a detector of `size` = width × height pixels.
    pub(crate) fn new(view: &View, size: [usize; 2]) -> Self {
        match view {
            View::Pose(pose) => Self::of_pose(pose),
            View::Projection(projection) if projection.is_parallel() => {
                Self { first: DVec3::Z, column: DVec3::ZERO, row: DVec3::ZERO }
            }
            View::Projection(projection) => Self::of_projection(projection, size),
        }
    }

    fn of_pose(pose: &DetectorPose) -> Self {
        let axis = unit(pose.column_step);
        let first = pose.first_pixel - pose.source;
        let normal = unit(axis.cross(unit(pose.row_step)));
        Self::in_frame(axis, normal * normal.dot(first).signum(), [first, pose.column_step, pose.row_step])
    }

    /// The direction d to the pixel at clip (X, Y) has x·d = X s, y·d = Y s and w·d = s with the matrix's rows: by
    /// Cramer's rule it is X (y×w) + Y (w×x) + x×y, times the sign of the determinant.
    fn of_projection(projection: &Projection, size: [usize; 2]) -> Self {
        let rows = projection.rows().map(glam::DVec4::truncate);
        // One factor for all rows changes no direction; it keeps the products within float64.
        let largest = rows.map(|row| row.abs().max_element()).into_iter().fold(0.0, f64::max);
        let [x, y, w] = rows.map(|row| row / largest);
        let forward = unit(x).cross(unit(y)).dot(unit(w)).signum();
        let [along_x, along_y, middle] = [forward * y.cross(w), forward * w.cross(x), forward * x.cross(y)];
        let [width, height] = size.map(|n| n as f64);
        let first = middle + (1.0 / width - 1.0) * along_x + (1.0 - 1.0 / height) * along_y;
        let steps = [first, 2.0 / width * along_x, -2.0 / height * along_y];
        Self::in_frame(forward * unit(unit(y).cross(unit(w))), unit(w), steps)
    }

    /// From world directions, with the unit vectors of the columns' direction and of the normal.
    fn in_frame(axis: DVec3, normal: DVec3, [first, column, row]: [DVec3; 3]) -> Self {
        let across = normal.cross(axis);
        let across = across * across.dot(row).signum();
        let components = |v: DVec3| DVec3::new(v.dot(axis), v.dot(across), v.dot(normal));
        // The steps lie in the plane: what rounding leaves beside it would add up over the pixels.
        let [column, row] = [column.dot(axis) * DVec3::X, components(row).with_z(0.0)];
        Self { first: components(first), column, row }
    }

    /// The sight from the point (column, row), in pixels; whole numbers are pixel centres.
    pub(crate) fn at(&self, column: f64, row: f64) -> Sight {
        Sight::along(self.towards(column, row))
    }

    /// As `at`, of another length: in a plane parallel to the detector.
    pub(super) fn towards(&self, column: f64, row: f64) -> DVec3 {
        self.first + column * self.column + row * self.row
    }

    /// The (column, row) of the foot of the perpendicular from the source.
    pub(crate) fn foot(&self) -> [f64; 2] {
        self.pixel(DVec3::Z)
    }

    /// The (column, row) towards which a direction points; not finite where it points to no pixel.
    pub(super) fn pixel(&self, direction: DVec3) -> [f64; 2] {
        let offset = self.first.z / direction.z * direction - self.first;
        let row = offset.y / self.row.y;
        [(offset.x - row * self.row.x) / self.column.x, row]
    }
}

/// The unit vector along `v`, whose square need not fit float64.
fn unit(v: DVec3) -> DVec3 {
    (v / v.abs().max_element()).normalize()
}

#[cfg(test)]
pub(super) mod tests {
    use glam::{DMat3, DMat4, DVec4};

    use super::*;

    pub(in crate::effects) const SIZE: [usize; 2] = [40, 30];

    /// Source 1000 mm above the foot of its perpendicular, which is at pixel (12, 5) of pixels of 4 mm × 6 mm.
    pub(in crate::effects) fn upright() -> DetectorPose {
        DetectorPose {
            source: DVec3::new(48.0, 30.0, 1000.0),
            first_pixel: DVec3::ZERO,
            column_step: 4.0 * DVec3::X,
            row_step: 6.0 * DVec3::Y,
        }
    }

    fn off(a: &Sights, b: &Sights) -> f64 {
        let corners = [(0.0, 0.0), (39.0, 0.0), (-0.5, 29.5), (39.0, 29.0), (17.25, 3.5)];
        let off = corners.map(|(i, j)| (a.at(i, j).direction() - b.at(i, j).direction()).length());
        off.into_iter().fold(0.0, f64::max)
    }

    #[test]
    fn an_upright_detector_is_seen_as_pythagoras_says() {
        let sights = Sights::new(&View::Pose(upright()), SIZE);
        assert_eq!(sights.at(12.0, 5.0), Sight { column: 0.0, row: 0.0, normal: 1.0 });
        let length = (200.0_f64 * 200.0 + 300.0 * 300.0 + 1e6).sqrt();
        let expected = DVec3::new(200.0, -300.0, 1000.0) / length;
        assert!((sights.at(62.0, -45.0).direction() - expected).length() < 1e-15);
        let [i, j] = sights.pixel(3.0 * expected);
        assert!((i - 62.0).abs() < 1e-12 && (j + 45.0).abs() < 1e-12, "{i}, {j}");
    }

    #[test]
    fn a_pose_and_its_projection_give_the_same_sights() {
        for distance in [300.0, 1000.0, 1e5] {
            for (angle, skew, mirror) in
                [(0.0, 0.0, 1.0), (17.0, 0.3, 1.0), (100.0, -0.8, -1.0), (226.0, 0.1, -1.0)]
            {
                let arm = DetectorPose::c_arm(DVec3::ZERO, angle, distance, distance + 500.0, 1.5, SIZE);
                let row_step = mirror * DVec3::new(0.1, skew, 2.0);
                let pose = DetectorPose { row_step, first_pixel: arm.first_pixel + 40.0 * DVec3::Z, ..arm };
                let mut projection = Projection::from_pose(&pose, SIZE).expect("valid");
                let direct = Sights::new(&View::Pose(pose), SIZE);
                // Homogeneous: the size of all rows together does not matter.
                for factor in [1.0, 1e-90, 1e90] {
                    let scaled = Projection { matrix: factor * projection.matrix, ..projection };
                    let error = off(&direct, &Sights::new(&View::Projection(scaled), SIZE));
                    assert!(error < 1e-12, "{error:e} at {distance} mm, {angle}°, {factor}");
                }
                projection.matrix *= DMat4::from_translation(DVec3::new(5.0, -7.0, 9.0));
                let error = off(&direct, &Sights::new(&View::Projection(projection), SIZE));
                assert!(error < 1e-12, "a shift of the world turns nothing: {error:e}");
            }
        }
    }

    #[test]
    fn turning_everything_changes_no_sight() {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let (pose, shift) = (upright(), DVec3::new(-300.0, 20.0, 1e4));
        let turned = DetectorPose {
            source: turn * pose.source + shift,
            first_pixel: turn * pose.first_pixel + shift,
            column_step: turn * pose.column_step,
            row_step: turn * pose.row_step,
        };
        let [a, b] = [pose, turned].map(|pose| Sights::new(&View::Pose(pose), SIZE));
        assert!(off(&a, &b) < 1e-14, "{:e}", off(&a, &b));
    }

    #[test]
    fn parallel_rays_run_along_the_normal() {
        let matrix = DMat4::from_diagonal(DVec4::new(0.02, 0.03, 0.005, 1.0)) * DMat4::from_rotation_y(0.3);
        let sights = Sights::new(&View::Projection(Projection { matrix, source: DVec3::NAN }), SIZE);
        assert_eq!(sights.at(3.0, 29.0), Sight { column: 0.0, row: 0.0, normal: 1.0 });
        assert!(sights.pixel(DVec3::new(0.0, 1.0, 1.0)).iter().all(|p| !p.is_finite()));
    }
}
