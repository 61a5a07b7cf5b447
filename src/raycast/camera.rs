//! A camera, and the rays through its picture.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::geometry::check_coordinates;
use crate::raycast::WorldRay;
use crate::raycast::world_ray::unit;

/// Least sine of the angle between `up` and `forward`: below it the rounding of the two decides where the picture's sides
/// are.
const MIN_SINE: f64 = 1e-6;
/// Largest width of the picture over its height, and height over width.
const MAX_ASPECT: f64 = 1e6;

/// A pinhole camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it is, world mm.
    pub position: DVec3,
    /// Where it looks; of any length.
    pub forward: DVec3,
    /// What is up in the picture; of any length, and not along `forward`.
    pub up: DVec3,
    /// From the picture's lower edge to its upper one, degrees, between 0 and 180.
    pub vertical_field_of_view_degrees: f64,
    /// The picture's width over its height.
    pub aspect: f64,
}

impl Camera {
    /// Number of rays of [`Camera::rays`].
    pub const RAYS: usize = 5;

    /// A camera that looks at `target`.
    pub fn towards(
        position: DVec3,
        target: DVec3,
        up: DVec3,
        vertical_field_of_view_degrees: f64,
        aspect: f64,
    ) -> Self {
        Self { position, forward: target - position, up, vertical_field_of_view_degrees, aspect }
    }

    /// The rays through the picture's centre and its corners: top left, top right, bottom left, bottom right.
    ///
    /// # Errors
    /// `InvalidArgument` for numbers that are not finite or beyond 1e10, for vectors of 0 or along each other, and for an angle
    /// or an aspect out of its range.
    pub fn rays(&self) -> Result<[WorldRay; Self::RAYS]> {
        self.checked_rays().map_err(|error| error.of("camera"))
    }

    fn checked_rays(&self) -> Result<[WorldRay; Self::RAYS]> {
        check_coordinates("position", self.position)?;
        let (forward, up) = (unit("forward", self.forward)?, unit("up", self.up)?);
        let right = forward.cross(up);
        if right.length() < MIN_SINE {
            let value = format!("{} with forward {}", self.up, self.forward);
            let valid = format!("not along forward: sine of the angle ≥ {MIN_SINE:e}");
            return Err(Error::invalid("up", value, valid));
        }
        let angle = self.vertical_field_of_view_degrees;
        if !(angle > 0.0 && angle < 180.0) {
            let valid = "above 0, below 180 degrees";
            return Err(Error::invalid("vertical_field_of_view_degrees", angle, valid));
        }
        if !(1.0 / MAX_ASPECT..=MAX_ASPECT).contains(&self.aspect) {
            return Err(Error::invalid("aspect", self.aspect, format!("1e-6 … {MAX_ASPECT:e}")));
        }
        let half_height = (0.5 * angle.to_radians()).tan();
        let right = right.normalize();
        let [right, up] = [half_height * self.aspect * right, half_height * right.cross(forward).normalize()];
        // Of length 1 before it is a ray's: a picture of nearly 180° has corners far away.
        let ray = |x: f64, y: f64| WorldRay::new(self.position, (forward + x * right + y * up).normalize());
        Ok([ray(0.0, 0.0)?, ray(-1.0, 1.0)?, ray(1.0, 1.0)?, ray(-1.0, -1.0)?, ray(1.0, -1.0)?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks along +y at 90°, twice as wide as high; up is only roughly so.
    fn camera() -> Camera {
        let (position, target) = (DVec3::new(1.0, -10.0, 2.0), DVec3::new(1.0, 5.0, 2.0));
        Camera::towards(position, target, DVec3::new(0.0, 0.3, 7.0), 90.0, 2.0)
    }

    #[test]
    fn rays_run_through_the_centre_and_the_corners_in_order() {
        let rays = camera().rays().expect("valid");
        for (ray, [x, z]) in rays.iter().zip([[0.0, 0.0], [-2.0, 1.0], [2.0, 1.0], [-2.0, -1.0], [2.0, -1.0]])
        {
            assert_eq!(ray.origin(), camera().position);
            let expected = DVec3::new(x, 1.0, z).normalize();
            assert!((ray.direction() - expected).length() < 1e-15, "{ray:?}");
        }
    }

    #[test]
    fn pictures_of_any_angle_have_corners() {
        for angle in [5e-324, 1e-10, 179.999_999_999] {
            for aspect in [1e-6, 1e6] {
                let camera = Camera { vertical_field_of_view_degrees: angle, aspect, ..camera() };
                let rays = camera.rays().expect("valid");
                assert!(rays.iter().all(|ray| (ray.direction().length() - 1.0).abs() < 1e-15));
            }
        }
    }

    #[test]
    fn a_camera_without_a_picture_is_refused_by_name() {
        let good = camera();
        for (argument, bad) in [
            ("position", Camera { position: DVec3::NAN, ..good }),
            ("forward", Camera { forward: DVec3::ZERO, ..good }),
            ("up", Camera { up: DVec3::ZERO, ..good }),
            ("up", Camera { up: -1e-3 * good.forward, ..good }),
            ("up", Camera { up: good.forward + 1e-6 * DVec3::X, ..good }),
            ("vertical_field_of_view_degrees", Camera { vertical_field_of_view_degrees: 0.0, ..good }),
            ("vertical_field_of_view_degrees", Camera { vertical_field_of_view_degrees: 180.0, ..good }),
            ("vertical_field_of_view_degrees", Camera { vertical_field_of_view_degrees: f64::NAN, ..good }),
            ("aspect", Camera { aspect: 0.0, ..good }),
            ("aspect", Camera { aspect: -1.0, ..good }),
            ("aspect", Camera { aspect: f64::INFINITY, ..good }),
        ] {
            let message = bad.rays().expect_err("no picture").to_string();
            assert!(message.starts_with(&format!("camera.{argument} is ")), "{message}");
        }
    }
}
