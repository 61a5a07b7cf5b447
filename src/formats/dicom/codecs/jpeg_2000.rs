//! JPEG 2000 (ISO/IEC 15444-1).

use hayro_jpeg2000::{DecodeSettings, DecoderContext, Image};

use super::check_size;
use crate::formats::Checked;
use crate::formats::dicom::pixels::Words;

/// The markers that a code stream starts with, SOC and SIZ. Some wrap it in a JP2 file, which the standard doesn't allow.
const START: [u8; 4] = [0xff, 0x4f, 0xff, 0x51];
/// Most tiles: their index has 16 bits.
const MOST_TILES: u64 = 65535;

/// What the SIZ marker segment says of an image of one component (table A.9).
struct Size {
    /// Columns and rows.
    sides: [usize; 2],
    signed: bool,
    precision: u16,
}

impl Size {
    fn parse(stream: &[u8]) -> Checked<Self> {
        let number =
            |at: usize| stream[at..].first_chunk().map(|&bytes| u64::from(u32::from_be_bytes(bytes)));
        let segment = stream.get(..45).ok_or("JPEG 2000: its header is truncated")?;
        let [
            Some(x1),
            Some(y1),
            Some(x0),
            Some(y0),
            Some(tile_x),
            Some(tile_y),
            Some(tile_x0),
            Some(tile_y0),
        ] = [8, 12, 16, 20, 24, 28, 32, 36].map(number)
        else {
            return Err("JPEG 2000: its header is truncated".to_owned());
        };
        let wrong = |what: &str| Err(format!("JPEG 2000: {what}"));
        if segment[40..42] != [0, 1] || segment[43..45] != [1, 1] {
            return wrong("not one grey component");
        }
        if x0 >= x1 || y0 >= y1 || tile_x == 0 || tile_y == 0 || tile_x0 > x0 || tile_y0 > y0 {
            return wrong("no pixels");
        }
        let tiles = (x1 - tile_x0).div_ceil(tile_x) * (y1 - tile_y0).div_ceil(tile_y);
        if tiles > MOST_TILES {
            return Err(format!("JPEG 2000: {tiles} tiles; valid: at most {MOST_TILES}"));
        }
        let precision = u16::from(segment[42] & 0x7f) + 1;
        if precision > 16 {
            return Err(format!("JPEG 2000: {precision} bits; valid: at most 16"));
        }
        let sides = [x1 - x0, y1 - y0].map(|n| n as usize);
        Ok(Self { sides, signed: segment[42] & 0x80 != 0, precision })
    }
}

/// Decodes a frame of one component.
pub(in crate::formats::dicom) fn decode(frame: &[u8], size: [usize; 2]) -> Checked<Words> {
    let start = frame.windows(START.len()).position(|bytes| bytes == START);
    let stream = &frame[start.ok_or("JPEG 2000: no code stream")?..];
    let header = Size::parse(stream)?;
    check_size(header.sides, size)?;
    let settings = DecodeSettings { strict: true, ..DecodeSettings::default() };
    let fail = |e: hayro_jpeg2000::DecodeError| format!("JPEG 2000: {e}");
    let image = Image::new(stream, &settings).map_err(fail)?;
    let mut context = DecoderContext::default();
    let decoded = image.decode(&mut context).map_err(fail)?;
    let [component] = decoded.components() else { return Err("JPEG 2000: not one component".to_owned()) };
    let samples = component.samples();
    check_size([samples.len() / size[1], size[1]], size)?;
    // The decoder takes every component for unsigned: it adds what makes those so (equation G-1).
    let added = if header.signed { 1 << (header.precision - 1) } else { 0 };
    let largest = ((1_u32 << header.precision) - 1) as f32;
    // Exact: float32 has 24 bits. Lossy streams overshoot.
    let word = |&sample: &f32| (sample.round().clamp(0.0, largest) as u32).wrapping_sub(added);
    Ok(Words { words: samples.iter().map(word).collect(), precision: header.precision })
}
