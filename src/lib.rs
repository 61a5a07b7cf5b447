//! X-ray projector.

pub mod error;
pub mod geometry;
pub mod physics;
pub mod raycast;

pub use error::{Error, Result};
