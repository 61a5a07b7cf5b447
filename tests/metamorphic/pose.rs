//! Random grids and poses: generic, so that no ray lies in a face of a voxel.

use drr::geometry::DetectorPose;
use glam::{DAffine3, DMat3, DVec3, EulerRot};
use proptest::prelude::*;

pub(crate) fn in_cube(half: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-half..half).prop_map(DVec3::from_array)
}

/// Index→world maps: spacings of 0.1 to 10 mm, mirrored or not, along the world's axes, or sheared and turned.
pub(crate) fn index_to_world() -> impl Strategy<Value = DAffine3> {
    let spacing = in_cube(1.0).prop_map(|exponent| exponent.map(|e| 10_f64.powf(e)));
    let signs = prop::array::uniform3(any::<bool>())
        .prop_map(|negative| DVec3::from_array(negative.map(|n| if n { -1.0 } else { 1.0 })));
    let shear = prop::option::of((in_cube(0.4), in_cube(3.0)));
    (spacing, signs, shear, in_cube(500.0)).prop_map(|(spacing, signs, shear, translation)| {
        let scale = DMat3::from_diagonal(spacing * signs);
        let matrix3 = shear.map_or(scale, |(shear, turn)| {
            let sheared =
                DMat3::from_cols(DVec3::X, DVec3::new(shear.x, 1.0, 0.0), DVec3::new(shear.y, shear.z, 1.0));
            DMat3::from_euler(EulerRot::XYZ, turn.x, turn.y, turn.z) * sheared * scale
        });
        DAffine3 { matrix3, translation }
    })
}

/// Where a source and a detector are, relative to a volume.
#[derive(Debug, Clone)]
pub(crate) struct Aim {
    /// What the detector's middle looks at: a point of the box, −½ … ½ of its sides from the centre.
    target: DVec3,
    /// Of the central ray: cosine of the angle with z, and azimuth.
    direction: [f64; 2],
    /// Source and detector to the target, in half diagonals.
    distance: [f64; 2],
    /// Width of the detector at the target, in half diagonals.
    field: f64,
    /// Height of a pixel for a width of 1, and how far columns lean.
    pixel: [f64; 2],
}

pub(crate) fn aim() -> impl Strategy<Value = Aim> {
    // Sources inside, outside and far; detectors inside and behind.
    let source = prop_oneof![0.1..0.9, 1.5..8.0, 1.5..8.0, Just(1e5)];
    let detector = prop_oneof![0.1..0.9, 1.2..6.0, 1.2..6.0];
    (
        in_cube(0.45),
        [-0.99..0.99, 0.0..std::f64::consts::TAU],
        (source, detector).prop_map(|(source, detector)| [source, detector]),
        0.2..2.0,
        [0.4..2.5, -0.5..0.5],
    )
        .prop_map(|(target, direction, distance, field, pixel)| Aim {
            target,
            direction,
            distance,
            field,
            pixel,
        })
}

impl Aim {
    pub(crate) fn at(
        &self,
        index_to_world: DAffine3,
        dimensions: [usize; 3],
        [width, height]: [usize; 2],
    ) -> DetectorPose {
        let sides = DVec3::from_array(dimensions.map(|n| n as f64));
        let target = index_to_world.transform_point3((0.5 + self.target) * sides - 0.5);
        let half_diagonal = 0.5 * (index_to_world.matrix3 * sides).length();
        let [z, azimuth] = self.direction;
        let (sin, cos) = azimuth.sin_cos();
        let across = (1.0 - z * z).sqrt();
        let direction = DVec3::new(across * cos, across * sin, z);
        let [source, detector] = self.distance.map(|distance| distance * half_diagonal);
        let (u, v) = direction.any_orthonormal_pair();
        let pitch = self.field * half_diagonal * (source + detector) / source / width as f64;
        let column_step = pitch * u;
        let row_step = pitch * self.pixel[0] * (v + self.pixel[1] * u);
        let middle = target + detector * direction;
        let half = |n: usize| 0.5 * (n as f64 - 1.0);
        DetectorPose {
            source: target - source * direction,
            first_pixel: middle - half(width) * column_step - half(height) * row_step,
            column_step,
            row_step,
        }
    }
}
