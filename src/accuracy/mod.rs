//! How wrong images are: rays of the very scene, cast again in float64 and integrated exactly.

mod certificate;
mod estimate;
mod measurement;
mod sample;

pub use certificate::Certificate;
pub use estimate::{CONFIDENCE, Estimate};
pub use measurement::{FLOOR, Measurement, Truth};
pub use sample::Sample;
