//! X-ray projector.

pub mod error;
pub mod geometry;

pub use error::{Error, Result};
