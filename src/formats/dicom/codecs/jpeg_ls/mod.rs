//! JPEG-LS, lossless and near-lossless (ISO/IEC 14495-1, which is ITU-T T.87), of one component. Names are the standard's.
//!
//! The only decoders that others keep are in C++ or come with a DICOM library of their own.

mod bits;
mod context;
mod header;
mod scan;

use super::check_size;
use crate::formats::Checked;
use crate::formats::dicom::pixels::Words;

/// Decodes a frame of one component.
pub(in crate::formats::dicom) fn decode(frame: &[u8], size: [usize; 2]) -> Checked<Words> {
    let fail = |reason: String| format!("JPEG-LS: {reason}");
    let (header, scan) = header::Header::parse(frame).map_err(fail)?;
    check_size(header.size, size)?;
    let words = scan::decode(&header, scan).map_err(fail)?;
    Ok(Words { words, precision: header.precision })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of annex H.3: 4 x 4 pixels of 8 bits, without loss.
    const EXAMPLE: [u8; 46] = [
        0xff, 0xd8, 0xff, 0xf7, 0x00, 0x0b, 0x08, 0x00, 0x04, 0x00, 0x04, 0x01, 0x01, 0x11, 0x00, 0xff, 0xda,
        0x00, 0x08, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0xc0, 0x00, 0x00, 0x6c, 0x80, 0x20, 0x8e, 0x01, 0xc0,
        0x00, 0x00, 0x57, 0x40, 0x00, 0x00, 0x6e, 0xe6, 0x00, 0x00, 0x01, 0xbc,
    ];

    #[test]
    fn the_example_of_the_standard() {
        let mut frame = EXAMPLE.to_vec();
        frame.extend([0x18, 0x00, 0x00, 0x05, 0xd8, 0x00, 0x00, 0x91, 0x60, 0xff, 0xd9]);
        let words = decode(&frame, [4, 4]).unwrap().words;
        assert_eq!(words, [0, 0, 90, 74, 68, 50, 43, 205, 64, 145, 145, 145, 100, 145, 145, 145]);
    }

    #[test]
    fn what_is_truncated_or_damaged_is_refused() {
        for length in 0..EXAMPLE.len() {
            assert!(decode(&EXAMPLE[..length], [4, 4]).is_err(), "{length}");
        }
        assert!(decode(&EXAMPLE, [4, 5]).err().unwrap().contains("4 x 4 pixels"));
    }
}
