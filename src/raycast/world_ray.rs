//! A ray of the world, as a caller gives it.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::geometry::{MAX_COORDINATE, check_coordinates};

/// A half-line in the world: from `origin`, mm, along a direction of length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldRay {
    origin: DVec3,
    direction: DVec3,
}

impl WorldRay {
    /// From `origin`, mm, along `direction`, of any length.
    ///
    /// # Errors
    /// `InvalidArgument` for numbers that are not finite or beyond 1e10, and for a direction of 0: no other stands in for it.
    pub fn new(origin: DVec3, direction: DVec3) -> Result<Self> {
        check_coordinates("origin", origin)?;
        let direction = unit("direction", direction)?;
        Ok(Self { origin, direction })
    }

    /// Where it starts, mm.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Where it goes; its length is 1.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }
}

/// A vector along `vector`, of length 1. Scaled first, so that no square vanishes.
///
/// # Errors
/// `InvalidArgument` for one that has no direction.
pub(super) fn unit(argument: &str, vector: DVec3) -> Result<DVec3> {
    let largest = vector.abs().max_element();
    if !vector.is_finite() || largest == 0.0 || largest > MAX_COORDINATE {
        let value = format!("[{:e}, {:e}, {:e}]", vector.x, vector.y, vector.z);
        let valid = format!("−{MAX_COORDINATE:e} … {MAX_COORDINATE:e}, not all 0");
        return Err(Error::invalid(argument, value, valid));
    }
    // By a power of two, which is exact.
    let exponent = largest.log2().floor().max(-1000.0) as i32;
    Ok((vector * 2_f64.powi(-exponent)).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_of_any_length_become_one_of_length_1() {
        for length in [5e-324, 1e-300, 1e-160, 1.0, 1e10] {
            let ray = WorldRay::new(DVec3::ZERO, DVec3::new(length, 0.0, -length)).expect("a direction");
            let expected = DVec3::new(0.5_f64.sqrt(), 0.0, -0.5_f64.sqrt());
            assert!((ray.direction() - expected).length() < 1e-15, "{length}: {ray:?}");
        }
    }

    #[test]
    fn what_is_no_ray_is_refused_by_name() {
        let refused = |origin, direction| WorldRay::new(origin, direction).expect_err("no ray").to_string();
        for number in [f64::NAN, f64::INFINITY, 1e11] {
            let message = refused(DVec3::new(0.0, number, 0.0), DVec3::X);
            assert!(message.starts_with("origin is ") && message.ends_with("1e10 mm"), "{message}");
        }
        for direction in
            [DVec3::ZERO, -DVec3::ZERO, DVec3::new(1.0, f64::NAN, 0.0), DVec3::NEG_INFINITY, 1e11 * DVec3::X]
        {
            let message = refused(DVec3::ZERO, direction);
            assert!(message.starts_with("direction is [") && message.ends_with("not all 0"), "{message}");
        }
    }
}
