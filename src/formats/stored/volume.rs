//! An array of voxels in a file, or in the bytes of one, slice by slice.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use flate2::bufread::{MultiGzDecoder, ZlibDecoder};

use super::storage::Storage;
use crate::error::Result;
use crate::formats::file_error;
use crate::formats::slices::SliceStream;
use crate::geometry::Grid;

/// The most that deflate can shrink: 258 bytes become 2 bits.
const LARGEST_COMPRESSION: u64 = 1032;
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];
const BUFFER_BYTES: usize = 1 << 18;

/// Where the bytes come from.
#[derive(Debug, Clone, Copy)]
pub(in crate::formats) enum Source {
    File,
    Memory(&'static [u8]),
}

/// How an array's bytes are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) enum Coding {
    Plain,
    Gzip,
    Zlib,
}

/// What a header says about the voxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::formats) struct Array {
    pub(in crate::formats) grid: Grid,
    pub(in crate::formats) storage: Storage,
    pub(in crate::formats) big_endian: bool,
    /// Value = slope × stored number + intercept.
    pub(in crate::formats) slope: f64,
    pub(in crate::formats) intercept: f64,
    /// Bytes before the first voxel, after expanding.
    pub(in crate::formats) offset: u64,
}

impl Array {
    /// Bytes of one slice.
    pub(in crate::formats) fn slice_bytes(&self) -> usize {
        let [n0, n1, _] = self.grid.dimensions();
        n0 * n1 * self.storage.bytes()
    }

    /// Bytes of the array.
    pub(in crate::formats) fn bytes(&self) -> u64 {
        (self.slice_bytes() * self.grid.dimensions()[2]) as u64
    }
}

/// An opened array of voxels.
#[derive(Debug)]
pub(in crate::formats) struct StoredVolume {
    path: PathBuf,
    source: Source,
    /// Byte of the file at which what is perhaps compressed starts.
    start: u64,
    coding: Coding,
    pub(in crate::formats) array: Array,
}

impl StoredVolume {
    /// The array in what starts at byte `start` of a file.
    ///
    /// # Errors
    /// `File` where the file cannot hold so many voxels.
    pub(in crate::formats) fn new(
        path: &Path,
        source: Source,
        start: u64,
        coding: Coding,
        array: Array,
    ) -> Result<Self> {
        let length = source.length(path).map_err(|e| file_error(path, e))?;
        let rest = length.saturating_sub(start);
        let expanded = match coding {
            Coding::Plain => rest,
            Coding::Gzip | Coding::Zlib => rest.saturating_mul(LARGEST_COMPRESSION),
        };
        let (claimed, capacity) = (start + array.offset + array.bytes(), start.saturating_add(expanded));
        if claimed > capacity {
            let [n0, n1, n2] = array.grid.dimensions();
            let reason = format!(
                "truncated: the header's {n0} x {n1} x {n2} voxels of {} byte(s) end at byte {claimed}, but the file \
                 can hold at most {capacity}",
                array.storage.bytes()
            );
            return Err(file_error(path, reason));
        }
        Ok(Self { path: path.to_owned(), source, start, coding, array })
    }

    /// The name for messages.
    pub(in crate::formats) fn path(&self) -> &Path {
        &self.path
    }

    /// The stored voxels from the first slice on.
    pub(in crate::formats) fn slices(&self) -> Result<SliceStream> {
        let fail = |e: io::Error| file_error(&self.path, e);
        let mut stream = self.source.expanded(&self.path, self.start, self.coding).map_err(fail)?;
        io::copy(&mut stream.by_ref().take(self.array.offset), &mut io::sink()).map_err(fail)?;
        let count = self.array.grid.dimensions()[2];
        Ok(SliceStream::new(&self.path, stream, self.array.slice_bytes(), count))
    }

    /// Decodes and scales the voxels of a slice.
    pub(in crate::formats) fn decode(&self, slice: &[u8], mut each: impl FnMut(f64)) {
        let Array { storage, big_endian, slope, intercept, .. } = self.array;
        storage.decode(big_endian, slice, |stored| each(slope * stored + intercept));
    }

    /// (i, j, k) of the voxel with that index in slice k.
    pub(in crate::formats) fn position(&self, index: usize, k: usize) -> [usize; 3] {
        let n0 = self.array.grid.dimensions()[0];
        [index % n0, index / n0, k]
    }
}

impl Source {
    /// How the content is compressed as a whole. Looks at it and not at the name: renamed files are common.
    pub(in crate::formats) fn coding(self, path: &Path) -> io::Result<Coding> {
        let gzip = self.bytes(path, 0)?.fill_buf()?.starts_with(&GZIP_MAGIC);
        Ok(if gzip { Coding::Gzip } else { Coding::Plain })
    }

    /// The expanded bytes of what starts at a byte of the file.
    pub(in crate::formats) fn expanded(
        self,
        path: &Path,
        start: u64,
        coding: Coding,
    ) -> io::Result<Box<dyn Read>> {
        let bytes = self.bytes(path, start)?;
        Ok(match coding {
            Coding::Plain => Box::new(bytes),
            Coding::Gzip => Box::new(MultiGzDecoder::new(bytes)),
            Coding::Zlib => Box::new(ZlibDecoder::new(bytes)),
        })
    }

    fn length(self, path: &Path) -> io::Result<u64> {
        match self {
            Self::File => Ok(std::fs::metadata(path)?.len()),
            Self::Memory(bytes) => Ok(bytes.len() as u64),
        }
    }

    fn bytes(self, path: &Path, start: u64) -> io::Result<Box<dyn BufRead>> {
        match self {
            Self::File => {
                let mut file = File::open(path)?;
                file.seek(SeekFrom::Start(start))?;
                Ok(Box::new(BufReader::with_capacity(BUFFER_BYTES, file)))
            }
            Self::Memory(bytes) => Ok(Box::new(bytes.get(start as usize..).unwrap_or_default())),
        }
    }
}
