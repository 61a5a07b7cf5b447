//! Reading the slices of a volume one after the other from a stream of bytes.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::allocation::grow;
use crate::error::Result;
use crate::formats::file_error;

/// What a slice is given before more of it has come: a small file that claims much is found out cheaply.
const FIRST_BYTES: usize = 1 << 24;
/// How much may follow the last voxel. Reading on to the end of a compressed file verifies its checksum, but a small
/// file can expand without end.
const LARGEST_REST: u64 = 1 << 20;

/// The slices of a volume as raw bytes; holds one slice at a time.
pub(super) struct SliceStream {
    path: PathBuf,
    stream: Box<dyn Read>,
    slice: Vec<u8>,
    bytes: usize,
    index: usize,
    count: usize,
}

impl SliceStream {
    /// `count` slices of `bytes` bytes each from a stream that stands at the first voxel. The caller has made sure
    /// that the file can hold them.
    pub(super) fn new(path: &Path, stream: Box<dyn Read>, bytes: usize, count: usize) -> Self {
        Self { path: path.to_owned(), stream, slice: Vec::new(), bytes, index: 0, count }
    }

    /// The next slice and its index; `None` after the last one, when the checksum of a compressed file has been
    /// verified too.
    pub(super) fn next_slice(&mut self) -> Result<Option<(usize, &[u8])>> {
        let Self { path, stream, slice, bytes, index, count } = self;
        if index == count {
            let rest = std::io::copy(&mut stream.take(LARGEST_REST + 1), &mut std::io::sink());
            return match rest.map_err(|e| file_error(path, e))? {
                ..=LARGEST_REST => Ok(None),
                _ => Err(file_error(
                    path,
                    format!("goes on after its last voxel; valid: at most {LARGEST_REST} bytes more"),
                )),
            };
        }
        let mut filled = 0;
        while filled < *bytes {
            // All of it from the second slice on.
            let room = (2 * filled).max(FIRST_BYTES).min(*bytes);
            grow(slice, room, 0, "a slice of the file")?;
            stream.read_exact(&mut slice[filled..]).map_err(|e| match e.kind() {
                ErrorKind::UnexpectedEof => file_error(path, format!("ends within slice {index} of {count}")),
                _ => file_error(path, format!("slice {index} of {count}: {e}")),
            })?;
            filled = slice.len();
        }
        *index += 1;
        Ok(Some((*index - 1, slice)))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn stream(bytes: Vec<u8>, slice: usize, count: usize) -> SliceStream {
        SliceStream::new(Path::new("volume"), Box::new(Cursor::new(bytes)), slice, count)
    }

    #[test]
    fn slices_larger_than_the_first_part_are_whole() {
        let bytes: Vec<u8> = (0..2 * (5 * FIRST_BYTES / 2)).map(|i| (i % 251) as u8).collect();
        let mut slices = stream(bytes.clone(), bytes.len() / 2, 2);
        for (k, expected) in bytes.chunks(bytes.len() / 2).enumerate() {
            assert!(
                slices.next_slice().unwrap().is_some_and(|(index, slice)| index == k && slice == expected)
            );
        }
        assert_eq!(slices.next_slice().unwrap(), None);
    }

    #[test]
    fn memory_is_taken_as_bytes_come() {
        let mut slices = stream(vec![0; 3 * FIRST_BYTES], 1 << 46, 1);
        let message = slices.next_slice().unwrap_err().to_string();
        assert!(message.contains("ends within slice 0 of 1"), "{message}");
        assert!(slices.slice.capacity() <= 4 * FIRST_BYTES, "{}", slices.slice.capacity());
    }

    #[test]
    fn what_follows_the_last_voxel_is_limited() {
        let rest = |rest: u64| {
            let mut slices = stream(vec![0; 4 + rest as usize], 4, 1);
            slices.next_slice().unwrap();
            slices.next_slice().map(|slice| slice.is_none())
        };
        assert_eq!(rest(LARGEST_REST), Ok(true));
        assert!(rest(LARGEST_REST + 1).unwrap_err().to_string().contains("after its last voxel"));
    }
}
