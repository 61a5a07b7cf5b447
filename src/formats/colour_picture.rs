//! A picture in colour.

use std::io::Write as _;
use std::path::Path;

use crate::error::Result;
use crate::formats::file_error;
use crate::formats::png::png_of_bytes;
use crate::formats::replacement::Replacement;

/// Red, green and blue as in sRGB.
pub type Rgb = [u8; 3];

/// A picture in colour.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColourPicture {
    /// Columns of pixels.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// Pixel (i, j) at `j*width + i`, row 0 at the top.
    pub pixels: Vec<Rgb>,
}

impl ColourPicture {
    /// A picture of one colour.
    pub fn filled(width: usize, height: usize, colour: Rgb) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// The colour of the pixel in this column and row.
    ///
    /// # Panics
    ///
    /// Outside the picture.
    pub fn pixel(&self, column: usize, row: usize) -> Rgb {
        assert!(column < self.width, "column {column} of {}", self.width);
        self.pixels[row * self.width + column]
    }

    /// Writes the picture as PNG, one that is grey throughout with one value per pixel.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        let mut file = Replacement::create(path)?;
        file.write_all(&self.png()?).map_err(|e| file_error(path, e))?;
        file.commit()
    }

    /// The bytes of such a file.
    pub fn png(&self) -> Result<Vec<u8>> {
        let size = [self.width, self.height];
        match self.greys() {
            Some(greys) => png_of_bytes(size, &greys, false),
            None => png_of_bytes(size, self.pixels.as_flattened(), true),
        }
    }

    /// The pixels' greys; `None` where there is a colour.
    fn greys(&self) -> Option<Vec<u8>> {
        let grey = |&[red, green, blue]: &Rgb| (red == green && green == blue).then_some(red);
        self.pixels.iter().map(grey).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_written_in_as_many_colours_as_they_have() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let mut picture = ColourPicture { width: 2, height: 1, pixels: vec![[7; 3], [200; 3]] };
        for (colour, expected) in [([200; 3], vec![7, 200]), ([200, 200, 201], vec![7, 7, 7, 200, 200, 201])]
        {
            picture.pixels[1] = colour;
            picture.write_png(&path).unwrap();
            let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
            let mut reader = png::Decoder::new(file).read_info().unwrap();
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut bytes).unwrap();
            assert_eq!(bytes, expected);
            assert_eq!(picture.png().unwrap(), std::fs::read(&path).unwrap());
        }
    }
}
