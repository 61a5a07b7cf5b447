//! Rays, and where they enter and leave a volume's box and what is in it. Everything is float64.
//!
//! [`Beam`] and [`Ray`] are in a volume's index space, where voxels are read. [`WorldRay`], [`Camera`] and [`RaySample`] are
//! the world's and [`DatasetSpace`]'s. A [`RayCache`] keeps what the rays of a view or of a camera meet.

mod beam;
mod cache;
mod camera;
mod crossings;
mod dataset_space;
pub(crate) mod distance_driven;
mod footprint;
mod lines;
pub(crate) mod ray;
mod slices;
pub(crate) mod tighten;
mod view_spans;
mod world_ray;

pub use beam::Beam;
pub use cache::{Computed, RayCache};
pub use camera::Camera;
pub(crate) use crossings::crossings;
pub use dataset_space::{DatasetRay, DatasetSpace, RaySample};
pub(crate) use footprint::{Footprint, Footprints};
pub(crate) use lines::{Anchor, Even, Lines};
pub use ray::{Ray, Span};
pub(crate) use slices::slices;
pub use view_spans::{RaySpan, ViewSpans};
pub use world_ray::WorldRay;
