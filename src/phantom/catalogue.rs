//! The simple phantoms.

use glam::DVec3;

use super::{Part, Phantom, Shape};

const LUNG: u8 = 1;
const SOFT_TISSUE: u8 = 2;
const BONE: u8 = 3;

/// A thin rod of the phantom `rods`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rod {
    /// The middle of the axis, mm.
    pub point: DVec3,
    /// The direction of the axis, a unit vector.
    pub direction: DVec3,
    /// The radius, mm.
    pub radius: f64,
    /// From the middle to either end, mm.
    pub half_length: f64,
}

/// Axes of the rods of [`Phantom::rods`], in the order of its parts: five along z, one along x, three tilted. Their
/// shadows on a C-arm within ±6° do not meet.
pub fn rod_axes() -> Vec<Rod> {
    let rod = |x, y, z, direction, half_length| Rod {
        point: DVec3::new(x, y, z),
        direction,
        radius: 1.0,
        half_length,
    };
    vec![
        rod(-80.0, -60.0, 0.0, DVec3::Z, 50.0),
        rod(-40.0, 30.0, 0.0, DVec3::Z, 50.0),
        rod(0.0, 0.0, 0.0, DVec3::Z, 50.0),
        rod(40.0, -30.0, 0.0, DVec3::Z, 50.0),
        rod(80.0, 60.0, 0.0, DVec3::Z, 50.0),
        rod(0.0, 20.0, 100.0, DVec3::X, 70.0),
        rod(-70.0, 0.0, -110.0, DVec3::new(0.6, 0.0, 0.8), 25.0),
        rod(0.0, -40.0, -110.0, DVec3::new(0.0, 0.6, 0.8), 25.0),
        rod(70.0, 40.0, -110.0, DVec3::new(2.0, -1.0, 2.0) / 3.0, 25.0),
    ]
}

impl Phantom {
    /// Water (0 HU, soft tissue): a cylinder about the z axis with a radius of 100 mm, 280 mm long.
    pub fn water_cylinder() -> Self {
        let shape =
            Shape::Cylinder { centre: DVec3::ZERO, axis: DVec3::Z, radius: 100.0, half_length: 140.0 };
        Self::of_valid_parts("water_cylinder", vec![Part { shape, hu: 0, material: SOFT_TISSUE }])
    }

    /// Rods of bone (1000 HU) with a radius of 1 mm, whose axes are [`rod_axes`].
    pub fn rods() -> Self {
        let part = |rod: Rod| Part {
            shape: Shape::Cylinder {
                centre: rod.point,
                axis: rod.direction,
                radius: rod.radius,
                half_length: rod.half_length,
            },
            hu: 1000,
            material: BONE,
        };
        Self::of_valid_parts("rods", rod_axes().into_iter().map(part).collect())
    }

    /// Balls and ellipsoids of 2 to 40 mm: lung in bone in soft tissue, and separate ones.
    pub fn spheres() -> Self {
        let egg = |centre: [f64; 3], semi_axes: [f64; 3], hu, material| Part {
            shape: Shape::Ellipsoid { centre: centre.into(), semi_axes: semi_axes.into() },
            hu,
            material,
        };
        let ball = |centre, radius: f64, hu, material| egg(centre, [radius; 3], hu, material);
        let parts = vec![
            ball([0.0, 0.0, 0.0], 40.0, 40, SOFT_TISSUE),
            ball([5.0, -4.0, 3.0], 25.0, 700, BONE),
            ball([5.0, -4.0, 3.0], 15.0, -800, LUNG),
            ball([90.0, 20.0, 60.0], 20.0, 0, SOFT_TISSUE),
            ball([-90.0, -20.0, 60.0], 10.0, 1000, BONE),
            ball([80.0, -40.0, -70.0], 5.0, 1000, BONE),
            ball([-80.0, 40.0, -70.0], 2.0, 1000, BONE),
            egg([-20.0, 30.0, 110.0], [30.0, 12.0, 20.0], -700, LUNG),
            egg([10.0, 60.0, -110.0], [12.0, 25.0, 35.0], 60, SOFT_TISSUE),
        ];
        Self::of_valid_parts("spheres", parts)
    }

    /// Axis-aligned boxes: lung in bone in soft tissue, two that touch, a 1 mm plate, a bar. No face lies on a voxel
    /// face of the default grid at 0.5 mm.
    pub fn boxes() -> Self {
        let cuboid = |minimum: [f64; 3], maximum: [f64; 3], hu, material| Part {
            shape: Shape::Cuboid { minimum: minimum.into(), maximum: maximum.into() },
            hu,
            material,
        };
        let parts = vec![
            cuboid([-60.1, -50.2, -40.3], [60.2, 50.3, 40.1], 40, SOFT_TISSUE),
            cuboid([-30.3, -20.1, -25.2], [20.1, 25.2, 15.3], 700, BONE),
            cuboid([-10.2, -10.3, -15.1], [10.3, 10.1, 5.2], -800, LUNG),
            cuboid([80.1, -30.2, -40.1], [95.1, 30.1, 40.2], 0, SOFT_TISSUE),
            cuboid([95.1, -30.2, -40.1], [110.2, 30.1, 40.2], 1000, BONE),
            cuboid([-90.2, -60.1, 80.3], [90.1, 60.2, 81.3], 1000, BONE),
            cuboid([-2.1, -100.3, -90.2], [1.9, 100.2, -86.2], 300, BONE),
        ];
        Self::of_valid_parts("boxes", parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DetectorPose;

    /// Detector coordinates (mm from the centre, along columns and rows) of a world point.
    fn shadow(pose: &DetectorPose, point: DVec3) -> [f64; 2] {
        let normal = pose.column_step.cross(pose.row_step);
        let ray = point - pose.source;
        let scale = normal.dot(pose.first_pixel - pose.source) / normal.dot(ray);
        let on_detector = pose.source + scale * ray - pose.first_pixel;
        [on_detector.dot(pose.column_step.normalize()), on_detector.dot(pose.row_step.normalize())]
    }

    #[test]
    fn shadows_of_rods_keep_apart_in_both_views() {
        let grid = Phantom::rods().grid([72, 72, 66]).unwrap();
        let rods = rod_axes();
        for pose in DetectorPose::stereo_pair(&grid, 1000.0, 1500.0, 0.9, [720, 720]) {
            let points = |rod: &Rod| {
                let along = rod.half_length * rod.direction;
                let start = rod.point - along;
                (0..=50).map(|n| shadow(&pose, start + f64::from(n) / 25.0 * along)).collect::<Vec<_>>()
            };
            for (a, first) in rods.iter().enumerate() {
                for p in points(first) {
                    assert!(p.iter().all(|&mm| mm > 20.0 && mm < 628.0), "rod {a} is on the detector: {p:?}");
                    for q in rods[..a].iter().flat_map(points) {
                        assert!((p[0] - q[0]).hypot(p[1] - q[1]) > 15.0, "rod {a}: {p:?} {q:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn rays_through_an_axis_cross_the_rod_by_its_diameter() {
        let phantom = Phantom::rods();
        for (index, rod) in rod_axes().iter().enumerate() {
            let across = rod.direction.any_orthonormal_vector();
            for along in [-0.9, 0.0, 0.7] {
                let point = rod.point + along * rod.half_length * rod.direction;
                let length = phantom.lengths(point - 9.0 * across, point + 9.0 * across)[index];
                assert!((length - 2.0 * rod.radius).abs() < 1e-12, "rod {index}: {length}");
            }
        }
    }
}
