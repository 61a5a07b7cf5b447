//! A picture in colour.

use std::path::Path;

use crate::error::Result;
use crate::formats::png::write_png_rgb8;

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

    /// Writes the picture as PNG.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_png_rgb8(path, self.width, self.height, self.pixels.as_flattened())
    }
}
