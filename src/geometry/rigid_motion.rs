//! Rigid motions of the object, and their derivatives.

use glam::{DMat3, DVec3};

use crate::error::{Error, Result};
use crate::geometry::{DetectorPose, check_coordinates};

/// Largest angle, radians: a few turns; float64 then still tells 1e-15 rad apart.
const MAX_ANGLE: f64 = 100.0;

/// Names of the angles, in their order.
const ANGLES: [&str; 3] = ["alpha", "beta", "phi"];

/// The motion `x ↦ R x + t` with `R = R_y(β) R_x(α) R_z(φ)`, of the object; the beam stays. Angles in radians, right-handed;
/// lengths in mm.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RigidMotion {
    /// α about x, β about y, φ about z.
    pub angles: [f64; 3],
    /// t.
    pub translation: DVec3,
}

impl RigidMotion {
    /// α, β, φ, then t.
    pub fn to_array(self) -> [f64; 6] {
        let ([alpha, beta, phi], [x, y, z]) = (self.angles, self.translation.to_array());
        [alpha, beta, phi, x, y, z]
    }

    /// Of α, β, φ and t.
    pub fn from_array([alpha, beta, phi, x, y, z]: [f64; 6]) -> Self {
        Self { angles: [alpha, beta, phi], translation: DVec3::new(x, y, z) }
    }

    /// Where the motion, about `pivot`, takes a point: `R (x − pivot) + pivot + t`.
    pub fn moved(&self, point: DVec3, pivot: DVec3) -> DVec3 {
        self.rotation() * (point - pivot) + pivot + self.translation
    }

    /// # Errors
    /// `InvalidArgument` for an angle that is not finite or beyond ±100 rad, and a translation that is not finite or beyond
    /// 1e10 mm.
    pub fn validate(&self) -> Result<()> {
        for (name, angle) in ANGLES.into_iter().zip(self.angles) {
            if !(angle.abs() <= MAX_ANGLE) {
                return Err(Error::invalid(name, angle, format!("−{MAX_ANGLE} … {MAX_ANGLE} rad")));
            }
        }
        check_coordinates("translation", self.translation)
    }

    /// R.
    pub fn rotation(&self) -> DMat3 {
        let [x, y, z] = self.factors();
        y * x * z
    }

    /// ∂R/∂α, ∂R/∂β, ∂R/∂φ.
    pub fn rotation_derivatives(&self) -> [DMat3; 3] {
        let [x, y, z] = self.factors();
        // d/da R(a) = generator · R(a) = R(a) · generator, about each axis.
        let [gx, gy, gz] = DVec3::AXES.map(cross_matrix);
        [y * gx * x * z, gy * y * x * z, y * x * gz * z]
    }

    /// The turns about x, y and z.
    fn factors(&self) -> [DMat3; 3] {
        let [alpha, beta, phi] = self.angles;
        [DMat3::from_rotation_x(alpha), DMat3::from_rotation_y(beta), DMat3::from_rotation_z(phi)]
    }

    /// Source and detector as they stand to the object after it moves, about `pivot`: `x ↦ R (x − pivot) + pivot + t`.
    /// Projecting the volume that stays with this pose is projecting the volume that moves with the old one.
    #[must_use]
    pub fn seen_from(&self, pose: &DetectorPose, pivot: DVec3) -> DetectorPose {
        let back = self.rotation().transpose();
        let point = |x: DVec3| back * (x - pivot - self.translation) + pivot;
        DetectorPose {
            source: point(pose.source),
            first_pixel: point(pose.first_pixel),
            column_step: back * pose.column_step,
            row_step: back * pose.row_step,
        }
    }
}

/// The matrix that takes x to axis × x.
fn cross_matrix(axis: DVec3) -> DMat3 {
    DMat3::from_cols(axis.cross(DVec3::X), axis.cross(DVec3::Y), axis.cross(DVec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOTION: RigidMotion =
        RigidMotion { angles: [0.3, -0.2, 1.1], translation: DVec3::new(4.0, -2.0, 7.0) };

    #[test]
    fn rotations_are_about_z_then_x_then_y() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let turned = RigidMotion { angles: [quarter, quarter, quarter], ..RigidMotion::default() }.rotation();
        // x → y (about z) → z (about x) → x (about y).
        assert!((turned * DVec3::X - DVec3::X).length() < 1e-15);
        assert!((MOTION.rotation().transpose() * MOTION.rotation()).abs_diff_eq(DMat3::IDENTITY, 1e-15));
    }

    #[test]
    fn derivatives_are_those_of_small_turns() {
        for (k, derivative) in MOTION.rotation_derivatives().into_iter().enumerate() {
            let turned = |by: f64| {
                let mut motion = MOTION;
                motion.angles[k] += by;
                motion.rotation()
            };
            let difference = (turned(1e-5) - turned(-1e-5)) * 0.5e5;
            assert!(derivative.abs_diff_eq(difference, 1e-10), "angle {k}");
        }
    }

    #[test]
    fn an_object_that_moves_sees_the_source_move_the_other_way() {
        let pose = DetectorPose::c_arm(DVec3::new(1.0, 2.0, 3.0), 20.0, 700.0, 1000.0, 1.0, [4, 4]);
        let pivot = DVec3::new(5.0, 6.0, 7.0);
        let seen = MOTION.seen_from(&pose, pivot);
        let moved = |x: DVec3| MOTION.moved(x, pivot);
        assert!((moved(seen.source) - pose.source).length() < 1e-12);
        assert!((moved(seen.pixel(2.0, 3.0)) - pose.pixel(2.0, 3.0)).length() < 1e-12);
    }

    #[test]
    fn parameters_keep_their_order() {
        assert_eq!(MOTION.to_array(), [0.3, -0.2, 1.1, 4.0, -2.0, 7.0]);
        assert_eq!(RigidMotion::from_array(MOTION.to_array()), MOTION);
    }

    #[test]
    fn what_is_not_finite_is_refused_by_name() {
        let error = RigidMotion { angles: [0.0, f64::NAN, 0.0], ..MOTION }.validate().expect_err("NaN");
        assert_eq!(error.to_string(), "beta is NaN; valid: −100 … 100 rad");
        let far = RigidMotion { translation: DVec3::new(0.0, f64::INFINITY, 0.0), ..MOTION };
        assert!(far.validate().expect_err("∞").to_string().starts_with("translation is [0e0, inf, 0e0]"));
    }
}
