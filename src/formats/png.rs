//! Writing gray PNG.

use std::path::Path;

use png::{BitDepth, ColorType, Encoder};

use crate::error::{Error, Result};
use crate::formats::file_error;
use crate::formats::replacement::Replacement;

/// Writes width × height values of 16 bits, pixel (i, j) at `j*width + i`, row 0 at the top, 0 black.
pub fn write_png_gray16(path: &Path, width: usize, height: usize, pixels: &[u16]) -> Result<()> {
    let bytes: Vec<u8> = pixels.iter().flat_map(|v| v.to_be_bytes()).collect();
    write(path, [width, height], pixels.len(), &bytes, BitDepth::Sixteen)
}

/// Writes width × height values of 8 bits, pixel (i, j) at `j*width + i`, row 0 at the top, 0 black.
pub fn write_png_gray8(path: &Path, width: usize, height: usize, pixels: &[u8]) -> Result<()> {
    write(path, [width, height], pixels.len(), pixels, BitDepth::Eight)
}

fn write(
    path: &Path,
    [width, height]: [usize; 2],
    count: usize,
    bytes: &[u8],
    depth: BitDepth,
) -> Result<()> {
    let side = |name: &str, n: usize| {
        u32::try_from(n).map_err(|_| Error::invalid(name, n, format!("1 … {}", i32::MAX)))
    };
    let (columns, rows) = (side("width", width)?, side("height", height)?);
    if width.checked_mul(height) != Some(count) {
        return Err(Error::invalid("pixels.len()", count, format!("{width} x {height}")));
    }
    let mut file = Replacement::create(path)?;
    let mut encoder = Encoder::new(&mut file, columns, rows);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().map_err(|e| file_error(path, e))?;
    writer.write_image_data(bytes).and_then(|()| writer.finish()).map_err(|e| file_error(path, e))?;
    file.commit()
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::BufReader;

    use super::*;

    fn read(path: &Path) -> (u32, u32, BitDepth, Vec<u8>) {
        let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(info.color_type, ColorType::Grayscale);
        (info.width, info.height, info.bit_depth, bytes)
    }

    #[test]
    fn pixels_come_back_in_both_depths() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        write_png_gray16(&path, 3, 2, &[0, 1, 256, 0x1234, 65534, 65535]).unwrap();
        let bytes = vec![0, 0, 0, 1, 1, 0, 0x12, 0x34, 0xff, 0xfe, 0xff, 0xff];
        assert_eq!(read(&path), (3, 2, BitDepth::Sixteen, bytes));
        write_png_gray8(&path, 1, 3, &[7, 0, 255]).unwrap();
        assert_eq!(read(&path), (1, 3, BitDepth::Eight, vec![7, 0, 255]));
    }

    #[test]
    fn wrong_sizes_are_refused_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        assert!(write_png_gray8(&path, 2, 2, &[0; 3]).unwrap_err().to_string().contains("2 x 2"));
        assert!(write_png_gray8(&path, 0, 2, &[]).is_err());
        assert!(write_png_gray16(&path, usize::MAX, 2, &[]).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
