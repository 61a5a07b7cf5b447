//! Writing PNG: gray and colour.

use std::path::Path;

use png::{BitDepth, ColorType, Encoder};

use crate::error::{Error, Result};
use crate::formats::file_error;
use crate::formats::replacement::Replacement;

/// Writes width × height values of 16 bits, pixel (i, j) at `j*width + i`, row 0 at the top, 0 black.
pub fn write_png_gray16(path: &Path, width: usize, height: usize, pixels: &[u16]) -> Result<()> {
    let bytes: Vec<u8> = pixels.iter().flat_map(|v| v.to_be_bytes()).collect();
    write(path, [width, height], &bytes, Samples { colour: ColorType::Grayscale, depth: BitDepth::Sixteen })
}

/// Writes width × height values of 8 bits, pixel (i, j) at `j*width + i`, row 0 at the top, 0 black.
pub fn write_png_gray8(path: &Path, width: usize, height: usize, pixels: &[u8]) -> Result<()> {
    write(path, [width, height], pixels, Samples { colour: ColorType::Grayscale, depth: BitDepth::Eight })
}

/// Writes width × height pixels of red, green and blue in 8 bits each (sRGB), pixel (i, j) at `3(j*width + i)`, row 0 at
/// the top.
pub fn write_png_rgb8(path: &Path, width: usize, height: usize, pixels: &[u8]) -> Result<()> {
    write(path, [width, height], pixels, Samples { colour: ColorType::Rgb, depth: BitDepth::Eight })
}

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

fn write(path: &Path, [width, height]: [usize; 2], bytes: &[u8], samples: Samples) -> Result<()> {
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
    let mut file = Replacement::create(path)?;
    let mut encoder = Encoder::new(&mut file, columns, rows);
    encoder.set_color(samples.colour);
    encoder.set_depth(samples.depth);
    let mut writer = encoder.write_header().map_err(|e| file_error(path, e))?;
    writer.write_image_data(bytes).and_then(|()| writer.finish()).map_err(|e| file_error(path, e))?;
    file.commit()
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::BufReader;

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
        write_png_gray16(&path, 3, 2, &[0, 1, 256, 0x1234, 65534, 65535]).unwrap();
        let bytes = vec![0, 0, 0, 1, 1, 0, 0x12, 0x34, 0xff, 0xfe, 0xff, 0xff];
        assert_eq!(read(&path, ColorType::Grayscale), (3, 2, BitDepth::Sixteen, bytes));
        write_png_gray8(&path, 1, 3, &[7, 0, 255]).unwrap();
        assert_eq!(read(&path, ColorType::Grayscale), (1, 3, BitDepth::Eight, vec![7, 0, 255]));
    }

    #[test]
    fn colours_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let pixels = vec![255, 0, 0, 1, 2, 3];
        write_png_rgb8(&path, 2, 1, &pixels).unwrap();
        assert_eq!(read(&path, ColorType::Rgb), (2, 1, BitDepth::Eight, pixels));
    }

    #[test]
    fn wrong_sizes_are_refused_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        assert!(write_png_gray8(&path, 2, 2, &[0; 3]).unwrap_err().to_string().contains("2 x 2"));
        assert!(write_png_gray8(&path, 0, 2, &[]).is_err());
        assert!(write_png_gray16(&path, usize::MAX, 2, &[]).is_err());
        let message = write_png_rgb8(&path, 2, 2, &[0; 4]).unwrap_err().to_string();
        assert!(message.contains("3 x 2 x 2"), "{message}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
