//! Volumes that are one array in one file, whatever describes it.

mod ct;
mod labels;
mod open;
mod storage;
mod volume;

pub use ct::StoredCt;
pub use labels::StoredLabels;
pub(super) use open::is_stored;
pub(super) use storage::Storage;
pub(super) use volume::{Array, Coding, Source, StoredVolume};
