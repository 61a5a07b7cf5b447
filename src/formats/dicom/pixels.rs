//! The pixels of one frame.

use std::io::Read;

use super::codecs::{jpeg, jpeg_2000, jpeg_ls, rle};
use super::fragments::PixelData;
use super::object::Object;
use super::stored::Stored;
use super::syntax::Codec;
use crate::error::Result;
use crate::formats::file_error;
use crate::formats::slices::SliceStream;

/// Pixels that are decoded whatever few bytes they come from: an image of nothing may be compressed to almost nothing.
const ALWAYS_DECODED: usize = 1 << 24;
/// Pixels to a byte of larger images, as for files that are deflated.
const LARGEST_COMPRESSION: usize = 1032;

/// What a codec delivers: a word per pixel, and the bits of each that mean something.
pub(super) struct Words {
    pub(super) words: Vec<u32>,
    pub(super) precision: u16,
}

impl Object {
    /// The words of a frame, and what their bits mean.
    pub(super) fn words(&self, frame: usize) -> Result<(Vec<u32>, Stored)> {
        let fail = |reason: String| file_error(&self.path, reason);
        let count = self.size[0] * self.size[1];
        match &self.pixels {
            PixelData::Native(start) => {
                let bytes = usize::from(self.stored.allocated) / 8;
                let position = start + (frame * count * bytes) as u64;
                let stream = self.container.stream(&self.path, position).map_err(|e| fail(e.to_string()))?;
                let mut slices = SliceStream::new(&self.path, stream, count * bytes, 1);
                let (_, frame) = slices.next_slice()?.ok_or_else(|| fail("has no pixels".to_owned()))?;
                Ok((self.native(frame)?, self.stored))
            }
            PixelData::Encapsulated(fragments) => {
                let bytes = self.fragment_bytes(&fragments[frame])?;
                if count > ALWAYS_DECODED.max(LARGEST_COMPRESSION.saturating_mul(bytes.len())) {
                    let [columns, rows] = self.size;
                    return Err(fail(format!("has {columns} x {rows} pixels in {} bytes", bytes.len())));
                }
                let decoded = match self.container.syntax.codec {
                    Codec::Rle => rle::decode(&bytes, count, self.stored.allocated),
                    Codec::Jpeg => jpeg::decode(&bytes, self.size),
                    Codec::JpegLs => jpeg_ls::decode(&bytes, self.size),
                    Codec::Jpeg2000 => jpeg_2000::decode(&bytes, self.size),
                    Codec::Native { .. } => Err("is not compressed".to_owned()),
                };
                let Words { words, precision } =
                    decoded.map_err(|reason| fail(format!("frame {frame}: {reason}")))?;
                // RLE stores pixels as they are, with what is above and below their bits.
                let native = self.container.syntax.codec == Codec::Rle;
                Ok((words, if native { self.stored } else { self.stored.decoded(precision) }))
            }
        }
    }

    fn native(&self, bytes: &[u8]) -> Result<Vec<u32>> {
        let big = self.container.syntax.codec == Codec::Native { big_endian: true };
        let mut words = crate::allocation::reserved(self.size[0] * self.size[1], "the pixels of a slice")?;
        macro_rules! words {
            ($number:ty) => {
                words.extend(bytes.as_chunks().0.iter().map(|&bytes| {
                    u32::from(if big {
                        <$number>::from_be_bytes(bytes)
                    } else {
                        <$number>::from_le_bytes(bytes)
                    })
                }))
            };
        }
        match self.stored.allocated {
            8 => words!(u8),
            16 => words!(u16),
            _ => words!(u32),
        }
        Ok(words)
    }

    fn fragment_bytes(&self, fragments: &[(u64, u32)]) -> Result<Vec<u8>> {
        let fail = |e: std::io::Error| file_error(&self.path, e);
        let mut bytes = vec![];
        for &(position, length) in fragments {
            let stream = self.container.stream(&self.path, position).map_err(fail)?;
            stream.take(length.into()).read_to_end(&mut bytes).map_err(fail)?;
        }
        if bytes.is_empty() { Err(file_error(&self.path, "has a frame without pixels")) } else { Ok(bytes) }
    }
}
