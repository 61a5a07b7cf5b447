//! X-ray projector.

pub mod error;
#[cfg(feature = "formats")]
pub mod formats;
pub mod geometry;

pub use error::{Error, Result};
