//! Drawing into a picture of pixels, without fonts of the system.

use std::convert::Infallible;

use drr::formats::{ColourPicture, Rgb};
use plotters::style::FontStyle;
use plotters::style::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use super::glyphs::{glyphs, text_size};
use super::shapes::{Coverage, Spot};

type Done = Result<(), DrawingErrorKind<Infallible>>;

/// A picture that is drawn on.
pub(super) struct Canvas<'a>(&'a mut ColourPicture);

impl<'a> Canvas<'a> {
    pub(super) fn new(picture: &'a mut ColourPicture) -> Self {
        Self(picture)
    }

    /// Lays a colour over a pixel; what lies outside is left out.
    fn blend(&mut self, [column, row]: [i32; 2], colour: BackendColor, cover: f64) {
        let ColourPicture { width, height, .. } = *self.0;
        let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row)) else { return };
        if column < width && row < height {
            let pixel = &mut self.0.pixels[row * width + column];
            *pixel = mixed(*pixel, colour, cover);
        }
    }

    fn paint(&mut self, shape: &Coverage, colour: BackendColor) {
        shape.pixels().for_each(|(pixel, cover)| self.blend(pixel, colour, cover));
    }
}

/// A colour laid over another one.
fn mixed(under: Rgb, over: BackendColor, cover: f64) -> Rgb {
    let weight = (over.alpha * cover).clamp(0.0, 1.0);
    let channel = |under: u8, over: u8| {
        (f64::from(under) + weight * (f64::from(over) - f64::from(under))).round() as u8
    };
    let (red, green, blue) = over.rgb;
    [channel(under[0], red), channel(under[1], green), channel(under[2], blue)]
}

fn spot((x, y): BackendCoord) -> Spot {
    [f64::from(x), f64::from(y)]
}

impl DrawingBackend for Canvas<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.0.width as u32, self.0.height as u32)
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Done {
        self.blend([x, y], colour, 1.0);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.draw_path([from, to], style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Done {
        let spots: Vec<Spot> = path.into_iter().map(spot).collect();
        let mut shape = Coverage::default();
        for ends in spots.windows(2) {
            shape.line([ends[0], ends[1]], f64::from(style.stroke_width()));
        }
        self.paint(&shape, style.color());
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done {
        if !fill {
            let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
            return self.draw_path(corners, style);
        }
        for row in top..bottom {
            (left..right).for_each(|column| self.blend([column, row], style.color(), 1.0));
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        centre: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Done {
        let mut shape = Coverage::default();
        let ring = (!fill).then_some(f64::from(style.stroke_width()));
        shape.circle(spot(centre), f64::from(radius), ring);
        self.paint(&shape, style.color());
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Done {
        let mut shape = Coverage::default();
        shape.polygon(&corners.into_iter().map(spot).collect::<Vec<_>>());
        self.paint(&shape, style.color());
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Done {
        let bold = matches!(style.style(), FontStyle::Bold);
        let [width, height] = text_size(text, style.size(), bold);
        let mut left = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => -width / 2,
            HPos::Right => -width,
        };
        let top = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -height / 2,
            VPos::Bottom => -height,
        };
        for glyph in glyphs(text, style.size(), bold) {
            for (row, line) in glyph.rows().enumerate() {
                for (column, ink) in line.iter().enumerate().filter(|(_, ink)| **ink != 0) {
                    let (dx, dy) = style.transform().transform(left + column as i32, top + row as i32);
                    self.blend([x + dx, y + dy], style.color(), f64::from(*ink) / 255.0);
                }
            }
            left += glyph.width() as i32;
        }
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let size = text_size(text, style.size(), matches!(style.style(), FontStyle::Bold));
        Ok((size[0] as u32, size[1] as u32))
    }
}

#[cfg(test)]
mod tests {
    use plotters::prelude::*;
    use plotters::style::text_anchor::Pos;

    use super::*;

    const WHITE_PIXEL: Rgb = [255; 3];

    fn drawn(draw: impl FnOnce(&mut Canvas<'_>) -> Done) -> ColourPicture {
        let mut picture = ColourPicture::filled(60, 40, WHITE_PIXEL);
        draw(&mut Canvas::new(&mut picture)).unwrap();
        picture
    }

    #[test]
    fn shapes_have_their_colour_and_smooth_edges() {
        let picture = drawn(|canvas| canvas.draw_circle((20, 20), 8, &RED.to_backend_color(), true));
        assert_eq!((picture.pixel(20, 20), picture.pixel(40, 20)), ([255, 0, 0], WHITE_PIXEL));
        assert!(picture.pixels.iter().any(|p| p[0] == 255 && (50..200).contains(&p[1])));
        let picture = drawn(|canvas| canvas.draw_line((5, 10), (50, 10), &BLACK.to_backend_color()));
        assert_eq!([9, 10, 11].map(|row| picture.pixel(30, row)), [WHITE_PIXEL, [0; 3], WHITE_PIXEL]);
    }

    #[test]
    fn colours_are_laid_over_each_other() {
        let half = BLACK.mix(0.5).to_backend_color();
        let picture = drawn(|canvas| {
            canvas.draw_pixel((1, 1), half)?;
            canvas.draw_path([(5, 20), (30, 20), (10, 20)], &half)
        });
        assert_eq!((picture.pixel(1, 1), picture.pixel(20, 20)), ([128; 3], [128; 3]));
    }

    #[test]
    fn texts_stand_where_they_are_anchored() {
        let ink = |pos: Pos, turn: FontTransform| {
            let style = ("any", 16).into_font().transform(turn).color(&BLACK).pos(pos);
            let picture = drawn(|canvas| canvas.draw_text("ab", &style, (30, 20)));
            let dark = |i: usize| picture.pixels[i][0] < 128;
            let spots = (0..picture.pixels.len()).filter(|i| dark(*i)).map(|i| [i % 60, i / 60]);
            spots.fold([60, 0, 40, 0], |[l, r, t, b], [x, y]| [l.min(x), r.max(x), t.min(y), b.max(y)])
        };
        let [left, right, top, bottom] = ink(Pos::new(HPos::Left, VPos::Top), FontTransform::None);
        assert!(left >= 30 && right < 46 && top >= 20 && bottom < 36);
        let [left, right, top, bottom] = ink(Pos::new(HPos::Right, VPos::Bottom), FontTransform::None);
        assert!(left >= 14 && right < 30 && top >= 4 && bottom < 20);
        let [left, right, top, bottom] = ink(Pos::new(HPos::Center, VPos::Center), FontTransform::Rotate270);
        assert!(left >= 20 && right < 40 && top >= 10 && bottom < 30);
    }

    #[test]
    fn what_lies_outside_is_left_out() {
        let style = ("any", 16).into_font().color(&BLACK);
        let picture = drawn(|canvas| {
            canvas.draw_circle((-50, -50), 8, &RED.to_backend_color(), true)?;
            canvas.draw_text("ab", &style, (200, -200))
        });
        assert!(picture.pixels.iter().all(|pixel| *pixel == WHITE_PIXEL));
    }
}
