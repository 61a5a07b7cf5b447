//! A NIfTI file or the bytes of one: the header, and the stored voxels slice by slice.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;

use super::header::{HEADER_BYTES, Header};
use crate::error::Result;
use crate::formats::file_error;
use crate::formats::slices::SliceStream;

/// The most that deflate can shrink: 258 bytes become 2 bits.
const LARGEST_COMPRESSION: u64 = 1032;
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Where the bytes come from.
#[derive(Debug, Clone, Copy)]
enum Source {
    File,
    Memory(&'static [u8]),
}

/// An opened volume.
#[derive(Debug)]
pub(super) struct Volume {
    path: PathBuf,
    source: Source,
    pub(super) header: Header,
}

impl Volume {
    pub(super) fn open(path: &Path) -> Result<Self> {
        Self::new(path.to_owned(), Source::File)
    }

    pub(super) fn from_bytes(name: &str, bytes: &'static [u8]) -> Result<Self> {
        Self::new(PathBuf::from(name), Source::Memory(bytes))
    }

    fn new(path: PathBuf, source: Source) -> Result<Self> {
        let fail = |reason: String| file_error(&path, reason);
        let (mut stream, capacity) = open(&path, source).map_err(|e| fail(e.to_string()))?;
        let mut bytes = [0; HEADER_BYTES];
        stream.read_exact(&mut bytes).map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof => fail(format!("is not NIfTI-1: less than {HEADER_BYTES} bytes")),
            _ => fail(e.to_string()),
        })?;
        let header = Header::parse(&bytes).map_err(fail)?;
        let claimed = header.file_bytes();
        if claimed > capacity {
            let [n0, n1, n2] = header.grid.dimensions();
            return Err(fail(format!(
                "truncated: the header's {n0} x {n1} x {n2} voxels of {} byte(s) end at byte {claimed}, but the file \
                 can hold at most {capacity}",
                header.storage.bytes()
            )));
        }
        Ok(Self { path, source, header })
    }

    /// The name for messages.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The stored voxels from the first slice on.
    pub(super) fn slices(&self) -> Result<SliceStream> {
        let fail = |e: io::Error| file_error(&self.path, e);
        let (mut stream, _) = open(&self.path, self.source).map_err(fail)?;
        io::copy(&mut stream.by_ref().take(self.header.offset), &mut io::sink()).map_err(fail)?;
        let count = self.header.grid.dimensions()[2];
        Ok(SliceStream::new(&self.path, stream, self.header.slice_bytes(), count))
    }

    /// Decodes and scales the voxels of a slice.
    pub(super) fn decode(&self, slice: &[u8], mut each: impl FnMut(f64)) {
        let Header { storage, big_endian, slope, intercept, .. } = self.header;
        storage.decode(big_endian, slice, |stored| each(slope * stored + intercept));
    }

    /// (i, j, k) of the voxel with that index in slice k.
    pub(super) fn position(&self, index: usize, k: usize) -> [usize; 3] {
        let n0 = self.header.grid.dimensions()[0];
        [index % n0, index / n0, k]
    }
}

/// The uncompressed bytes, and an upper bound of their number that doesn't rely on what the file says of itself.
fn open(path: &Path, source: Source) -> io::Result<(Box<dyn Read>, u64)> {
    match source {
        Source::File => {
            let file = File::open(path)?;
            let length = file.metadata()?.len();
            uncompressed(BufReader::with_capacity(1 << 18, file), length)
        }
        Source::Memory(bytes) => uncompressed(bytes, bytes.len() as u64),
    }
}

/// Looks at the content and not at the name: renamed files are common.
fn uncompressed(mut bytes: impl io::BufRead + 'static, length: u64) -> io::Result<(Box<dyn Read>, u64)> {
    if bytes.fill_buf()?.starts_with(&GZIP_MAGIC) {
        return Ok((Box::new(MultiGzDecoder::new(bytes)), length.saturating_mul(LARGEST_COMPRESSION)));
    }
    Ok((Box::new(bytes), length))
}
