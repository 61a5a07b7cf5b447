//! Rays in a volume's index space, and where they enter and leave its box. Everything is float64.

mod beam;
mod lines;
pub(crate) mod ray;

pub use beam::Beam;
pub(crate) use lines::{Anchor, Even, Lines};
pub use ray::{Ray, Span};
