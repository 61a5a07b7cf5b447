//! One picture as SVG and as PNG.

use std::path::Path;

use anyhow::Result;
use drr::formats::{ColourPicture, write_text};
use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::style::{Color as _, FontFamily, FontStyle, IntoFont, RGBColor, TextStyle};
use plotters_backend::DrawingBackend;

use super::canvas::Canvas;

/// Width and height, pixels.
pub(super) const SIZE: (u32, u32) = (900, 600);
/// Heights of lines of text, pixels: those that the letters of PNG have.
pub(super) const TEXT: f64 = 16.0;
pub(super) const TITLE: f64 = 20.0;
/// Letters in SVG that are about as wide as those in PNG, or narrower.
const FAMILY: FontFamily<'_> = FontFamily::Name("Arial, Helvetica, sans-serif");

pub(crate) type Area<B> = DrawingArea<B, Shift>;

/// What a picture can be drawn on.
pub(crate) trait Surface: DrawingBackend<ErrorType: 'static> {}

impl<B: DrawingBackend<ErrorType: 'static>> Surface for B {}

/// A picture of [`SIZE`].
pub(crate) trait Drawing {
    fn draw<B: Surface>(&self, area: &Area<B>) -> Result<()>;

    /// Writes the picture as SVG.
    fn write_svg(&self, path: &Path) -> Result<()> {
        Ok(write_text(path, &self.svg()?)?)
    }

    /// Writes the picture as PNG.
    fn write_png(&self, path: &Path) -> Result<()> {
        Ok(self.picture()?.write_png(path)?)
    }

    /// The picture as the text of an SVG.
    fn svg(&self) -> Result<String> {
        let mut text = String::new();
        self.finish(SVGBackend::with_string(&mut text, SIZE))?;
        Ok(text)
    }

    /// The picture as pixels.
    fn picture(&self) -> Result<ColourPicture> {
        let mut picture = ColourPicture::filled(SIZE.0 as usize, SIZE.1 as usize, [255; 3]);
        self.finish(Canvas::new(&mut picture))?;
        Ok(picture)
    }

    fn finish<B: Surface>(&self, surface: B) -> Result<()> {
        let area = surface.into_drawing_area();
        area.fill(&plotters::style::WHITE)?;
        self.draw(&area)?;
        Ok(area.present()?)
    }
}

/// A style of text.
pub(super) fn text_style(height: f64, bold: bool, colour: RGBColor) -> TextStyle<'static> {
    let style = if bold { FontStyle::Bold } else { FontStyle::Normal };
    TextStyle { color: colour.to_backend_color(), ..(FAMILY, height, style).into_font().into() }
}
