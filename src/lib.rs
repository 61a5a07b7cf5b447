//! X-ray projector.

pub mod error;
pub mod geometry;
pub mod phantom;

pub use error::{Error, Result};
