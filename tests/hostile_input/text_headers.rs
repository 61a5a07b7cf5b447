//! The readers of MetaImage and NRRD: any bytes are a whole CT of finite HU, or an error.

use crate::{ct, file};

/// Whether the file was accepted as either.
pub(crate) fn check(bytes: &[u8]) -> bool {
    ["ct.mha", "ct.nrrd"].iter().any(|name| ct::voxels(&file::with_content(name, bytes)).is_some())
}
