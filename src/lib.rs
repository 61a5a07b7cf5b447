//! X-ray projector.

pub mod error;
pub mod geometry;
pub mod physics;

pub use error::{Error, Result};
