//! X-ray projector.

pub mod error;
pub mod geometry;
pub mod raycast;

pub use error::{Error, Result};
