//! JPEG: lossless of 2 to 16 bits, and lossy of 8 bits.

use jpeg_decoder::{Decoder, PixelFormat};

use super::check_size;
use crate::formats::Checked;
use crate::formats::dicom::pixels::Words;

/// Decodes a frame of one component.
pub(in crate::formats::dicom) fn decode(frame: &[u8], size: [usize; 2]) -> Checked<Words> {
    let fail = |e: jpeg_decoder::Error| format!("JPEG: {e}");
    let mut decoder = Decoder::new(frame);
    decoder.read_info().map_err(fail)?;
    let info = decoder.info().ok_or("JPEG: no image")?;
    check_size([info.width, info.height].map(usize::from), size)?;
    let bits = match info.pixel_format {
        PixelFormat::L8 => 8,
        PixelFormat::L16 => 16,
        other => return Err(format!("JPEG: pixels are {other:?}; valid: one grey component")),
    };
    let bytes = decoder.decode().map_err(fail)?;
    // The decoder writes words in this machine's order.
    let words = match bits {
        8 => bytes.into_iter().map(u32::from).collect(),
        _ => bytes.as_chunks().0.iter().map(|&bytes| u32::from(u16::from_ne_bytes(bytes))).collect(),
    };
    Ok(Words { words, precision: bits })
}
