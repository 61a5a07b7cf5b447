//! Rays in a volume's index space, and where they enter and leave its box. Everything is float64.

mod beam;
mod crossings;
pub(crate) mod distance_driven;
mod footprint;
mod lines;
pub(crate) mod ray;
mod slices;

pub use beam::Beam;
pub(crate) use crossings::crossings;
pub(crate) use footprint::{Footprint, Footprints};
pub(crate) use lines::{Anchor, Even, Lines};
pub use ray::{Ray, Span};
pub(crate) use slices::slices;
