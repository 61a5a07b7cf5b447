//! Reading the slices of a volume one after the other from a stream of bytes.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::formats::file_error;

/// The slices of a volume as raw bytes; holds one slice at a time.
pub(super) struct SliceStream {
    path: PathBuf,
    stream: Box<dyn Read>,
    slice: Vec<u8>,
    index: usize,
    count: usize,
}

impl SliceStream {
    /// `count` slices of `bytes` bytes each from a stream that stands at the first voxel. The caller has made sure
    /// that the file can hold them.
    pub(super) fn new(path: &Path, stream: Box<dyn Read>, bytes: usize, count: usize) -> Result<Self> {
        let slice = zeroed("a slice of the file", bytes)?;
        Ok(Self { path: path.to_owned(), stream, slice, index: 0, count })
    }

    /// The next slice and its index; `None` after the last one, when the checksum of a compressed file has been
    /// verified too.
    pub(super) fn next_slice(&mut self) -> Result<Option<(usize, &[u8])>> {
        let Self { path, stream, slice, index, count } = self;
        if index == count {
            // The checksum of gzip comes after the data and is checked when the end is read.
            std::io::copy(stream, &mut std::io::sink()).map_err(|e| file_error(path, e))?;
            return Ok(None);
        }
        stream.read_exact(slice).map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof => file_error(path, format!("ends within slice {index} of {count}")),
            _ => file_error(path, format!("slice {index} of {count}: {e}")),
        })?;
        *index += 1;
        Ok(Some((*index - 1, slice)))
    }
}

/// A vector of `count` zeros, or `OutOfMemory`.
pub(super) fn zeroed<T: Copy + Default>(what: &str, count: usize) -> Result<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_err(|_| Error::OutOfMemory {
        what: what.to_owned(),
        bytes: count.saturating_mul(size_of::<T>()),
    })?;
    values.resize(count, T::default());
    Ok(values)
}
