//! X-ray projector: digitally reconstructed radiographs from CT.

pub mod capi;
pub mod engine;
pub mod error;
#[cfg(feature = "formats")]
pub mod formats;
pub mod geometry;
pub mod phantom;
pub mod physics;
pub mod plan;
mod projector;
pub mod raycast;
mod scene;
pub mod shared;
pub mod volume;

pub use error::{Error, Result};
pub use projector::{Context, MAX_THREADS, Projector, ViewRequest};
pub use scene::{Algorithm, MAX_DETECTOR, MAX_SUPERSAMPLING, STEP_RANGE, Scene};

/// The library's version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
