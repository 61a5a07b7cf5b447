//! NIfTI-1 (`.nii`, `.nii.gz`): HU and labels, slice by slice.

mod affine;
mod header;
#[cfg(test)]
mod test_file;
mod writer;

use std::io::{ErrorKind, Read as _};
use std::path::Path;

use header::HEADER_BYTES;

use crate::error::Result;
use crate::formats::stored::{Source, StoredVolume};
use crate::formats::{file_error, has_ending};

#[cfg(test)]
pub(super) use test_file::TestFile;
pub use writer::{NiftiVoxel, NiftiWriter};

/// Whether the file's name is that of a NIfTI file.
pub fn is_nifti(path: &Path) -> bool {
    has_ending(path, &[".nii", ".nii.gz"])
}

/// Opens a file.
pub(super) fn open(path: &Path) -> Result<StoredVolume> {
    read(path, Source::File)
}

/// Opens the bytes of a file; `name` stands for its path in messages.
pub(super) fn from_bytes(name: &str, bytes: &'static [u8]) -> Result<StoredVolume> {
    read(Path::new(name), Source::Memory(bytes))
}

fn read(path: &Path, source: Source) -> Result<StoredVolume> {
    let fail = |reason: String| file_error(path, reason);
    let coding = source.coding(path).map_err(|e| fail(e.to_string()))?;
    let mut stream = source.expanded(path, 0, coding).map_err(|e| fail(e.to_string()))?;
    let mut bytes = [0; HEADER_BYTES];
    stream.read_exact(&mut bytes).map_err(|e| match e.kind() {
        ErrorKind::UnexpectedEof => fail(format!("is not NIfTI-1: less than {HEADER_BYTES} bytes")),
        _ => fail(e.to_string()),
    })?;
    StoredVolume::new(path, source, 0, coding, header::parse(&bytes).map_err(fail)?)
}
