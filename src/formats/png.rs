//! PNG, gray and colour, and what it says about itself.

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;

use png::text_metadata::{ITXtChunk, TEXtChunk};
use png::{BitDepth, ColorType, Decoder, Encoder};

use crate::error::{Error, Result};
use crate::formats::file_error;
use crate::formats::replacement::Replacement;

/// Writes width × height values of 16 bits, pixel (i, j) at `j*width + i`, row 0 at the top, 0 black, and texts by their
/// keywords of 1 to 79 letters: as tEXt where Latin-1 has their characters, as iTXt otherwise.
pub fn write_png_gray16(
    path: &Path,
    width: usize,
    height: usize,
    pixels: &[u16],
    texts: &[(String, String)],
) -> Result<()> {
    let bytes: Vec<u8> = pixels.iter().flat_map(|v| v.to_be_bytes()).collect();
    let samples = Samples { colour: ColorType::Grayscale, depth: BitDepth::Sixteen };
    write(path, [width, height], &bytes, samples, texts)
}

/// The bytes of a file of width × height pixels of one value, or of red, green and blue, of 8 bits each.
pub(super) fn png_of_bytes(size: [usize; 2], pixels: &[u8], coloured: bool) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let failed = |reason: String| file_error(Path::new("a picture"), reason);
    encode(&mut bytes, size, pixels, if coloured { COLOUR } else { GREY }, &[], failed)?;
    Ok(bytes)
}

/// Reads the texts of a file by their keywords, without its pixels.
///
/// # Errors
/// `File` when it is no PNG file.
pub fn read_png_texts(path: &Path) -> Result<Vec<(String, String)>> {
    let file = File::open(path).map_err(|e| file_error(path, e))?;
    let reader = Decoder::new(BufReader::new(file)).read_info().map_err(|e| file_error(path, e))?;
    let info = reader.info();
    let latin1 = |chunk: &TEXtChunk| Ok((chunk.keyword.clone(), chunk.text.clone()));
    let utf8 = |chunk: &ITXtChunk| Ok((chunk.keyword.clone(), chunk.get_text()?));
    let texts = info.uncompressed_latin1_text.iter().map(latin1).chain(info.utf8_text.iter().map(utf8));
    texts.collect::<std::result::Result<_, png::DecodingError>>().map_err(|e| file_error(path, e))
}

const GREY: Samples = Samples { colour: ColorType::Grayscale, depth: BitDepth::Eight };
const COLOUR: Samples = Samples { colour: ColorType::Rgb, depth: BitDepth::Eight };

/// What a pixel consists of.
#[derive(Clone, Copy)]
struct Samples {
    colour: ColorType,
    depth: BitDepth,
}

impl Samples {
    fn count(self) -> usize {
        self.colour.samples()
    }

    fn bytes(self) -> usize {
        self.count() * if self.depth == BitDepth::Sixteen { 2 } else { 1 }
    }
}

fn write(
    path: &Path,
    size: [usize; 2],
    bytes: &[u8],
    samples: Samples,
    texts: &[(String, String)],
) -> Result<()> {
    check(size, bytes, samples)?;
    let mut file = Replacement::create(path)?;
    encode(&mut file, size, bytes, samples, texts, |reason| file_error(path, reason))?;
    file.commit()
}

/// Columns and rows of as many pixels as there are bytes for.
fn check([width, height]: [usize; 2], bytes: &[u8], samples: Samples) -> Result<[u32; 2]> {
    let side = |name: &str, n: usize| {
        u32::try_from(n).map_err(|_| Error::invalid(name, n, format!("1 … {}", i32::MAX)))
    };
    let (columns, rows) = (side("width", width)?, side("height", height)?);
    let right = width.checked_mul(height).and_then(|pixels| pixels.checked_mul(samples.bytes()));
    if right != Some(bytes.len()) {
        let expected = match samples.count() {
            1 => format!("{width} x {height}"),
            count => format!("{count} x {width} x {height}"),
        };
        let given = bytes.len() * samples.count() / samples.bytes();
        return Err(Error::invalid("pixels.len()", given, expected));
    }
    Ok([columns, rows])
}

fn encode(
    to: impl Write,
    size: [usize; 2],
    bytes: &[u8],
    samples: Samples,
    texts: &[(String, String)],
    failed: impl Fn(String) -> Error,
) -> Result<()> {
    let [columns, rows] = check(size, bytes, samples)?;
    let mut encoder = Encoder::new(to, columns, rows);
    encoder.set_color(samples.colour);
    encoder.set_depth(samples.depth);
    let encoded = texts.iter().try_for_each(|(keyword, text)| {
        let is_latin1 = text.chars().all(|c| u8::try_from(u32::from(c)).is_ok());
        let (keyword, text) = (keyword.clone(), text.clone());
        if is_latin1 { encoder.add_text_chunk(keyword, text) } else { encoder.add_itxt_chunk(keyword, text) }
    });
    let written = encoded.and_then(|()| {
        let mut writer = encoder.write_header()?;
        writer.write_image_data(bytes)?;
        writer.finish()
    });
    written.map_err(|error| failed(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(path: &Path, colour: ColorType) -> (u32, u32, BitDepth, Vec<u8>) {
        let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(info.color_type, colour);
        (info.width, info.height, info.bit_depth, bytes)
    }

    #[test]
    fn pixels_come_back_in_both_depths() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        write_png_gray16(&path, 3, 2, &[0, 1, 256, 0x1234, 65534, 65535], &[]).unwrap();
        let bytes = vec![0, 0, 0, 1, 1, 0, 0x12, 0x34, 0xff, 0xfe, 0xff, 0xff];
        assert_eq!(read(&path, ColorType::Grayscale), (3, 2, BitDepth::Sixteen, bytes));
        write(&path, [1, 3], &[7, 0, 255], GREY, &[]).unwrap();
        assert_eq!(read(&path, ColorType::Grayscale), (1, 3, BitDepth::Eight, vec![7, 0, 255]));
    }

    #[test]
    fn texts_come_back_and_readers_of_latin_1_find_theirs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let texts = [("a", "g/cm²"), ("b", "Łukasz \u{1d707}"), ("c", "")];
        let texts = texts.map(|(keyword, text)| (keyword.to_owned(), text.to_owned()));
        write_png_gray16(&path, 1, 1, &[7], &texts).unwrap();
        let mut read = read_png_texts(&path).unwrap();
        read.sort();
        assert_eq!(read, texts);
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.windows(11).any(|window| window == b"tEXta\0g/cm\xb2"));
        assert!(bytes.windows(5).any(|window| window == b"iTXtb"));
        assert!(write_png_gray16(&path, 1, 1, &[7], &[("x".repeat(80), String::new())]).is_err());
        std::fs::write(&path, "no").unwrap();
        assert!(read_png_texts(&path).unwrap_err().to_string().contains("picture.png"));
    }

    #[test]
    fn colours_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let pixels = vec![255, 0, 0, 1, 2, 3];
        write(&path, [2, 1], &pixels, COLOUR, &[]).unwrap();
        assert_eq!(read(&path, ColorType::Rgb), (2, 1, BitDepth::Eight, pixels));
    }

    #[test]
    fn wrong_sizes_are_refused_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        assert!(write(&path, [2, 2], &[0; 3], GREY, &[]).unwrap_err().to_string().contains("2 x 2"));
        assert!(write(&path, [0, 2], &[], GREY, &[]).is_err());
        assert!(write_png_gray16(&path, usize::MAX, 2, &[], &[]).is_err());
        let message = write(&path, [2, 2], &[0; 4], COLOUR, &[]).unwrap_err().to_string();
        assert!(message.contains("3 x 2 x 2"), "{message}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
