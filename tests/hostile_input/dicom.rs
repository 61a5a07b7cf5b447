//! The reader of DICOM, with all decoders: any bytes are a whole CT of finite HU, or an error.

use crate::{ct, file};

/// Whether the file was accepted, as an object with several frames.
pub(crate) fn check(bytes: &[u8]) -> bool {
    ct::voxels(&file::with_content("ct.dcm", bytes)).is_some()
}
