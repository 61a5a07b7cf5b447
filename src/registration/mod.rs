//! 2D/3D registration: where the object is, from cone-beam images of it and its volume.
//!
//! All views see one rigid motion of the object; its six parameters are those at which the projections, through spectrum and
//! detector, fit the measured images best in the least-squares sense. Views at a small angle, as the ±6° of a stereo pair,
//! tell the depth along their common direction by parallax alone: its standard deviation is about 1/tan 6° ≈ 10 times that
//! across. [`Registration::covariance`] says so for the case at hand.

mod capture_range;
mod levels;
#[cfg(test)]
mod phantom;
mod register;
mod target_error;

pub use capture_range::{CaptureOptions, CaptureRange, CaptureRow};
pub use levels::{Registrar, RegistrationView};
pub use register::{Registration, RegistrationOptions};
pub use target_error::TargetError;

pub use crate::levenberg_marquardt::MAX_LEVELS as MAX_REGISTRATION_LEVELS;
