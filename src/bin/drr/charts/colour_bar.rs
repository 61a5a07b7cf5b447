//! What the colours of an error map mean.

use anyhow::Result;
use drr::formats::{ColourPicture, error_colour};
use plotters::drawing::IntoDrawingArea;
use plotters::element::{Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor};

use super::canvas::Canvas;
use super::decades::number;
use super::drawing::{Area, Surface, TEXT, text_style};
use super::glyphs::text_size;
use super::marker::{INK, PALE_INK, line};

/// Rows under the map; those above the bar, and those of the bar.
const ROWS: usize = 52;
const ABOVE: i32 = 10;
const THICKNESS: i32 = 16;
/// Fractions of the range that have texts.
const TICKS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
/// Most columns of the bar.
const WIDEST: i32 = 480;
const SPACE: i32 = 12;

/// The map on white with a bar of its colours from −range to +range under it, in a unit, which may be empty.
pub(crate) fn with_colour_bar(map: &ColourPicture, range: f64, unit: &str) -> Result<ColourPicture> {
    let ticks = TICKS.map(|fraction| (fraction, tick(fraction * range, unit)));
    let widest = ticks.iter().map(|(_, text)| text_size(text, TEXT, false)[0]).max().unwrap_or(0);
    // The texts stand beside each other, and half of the outer ones beyond the bar.
    let width = (map.width as i32).max(TICKS.len() as i32 * (widest + SPACE));
    let mut picture = on_white(map, width as usize);
    let length = (width - widest - SPACE).min(WIDEST);
    let bar = Bar { left: (width - length) / 2, top: map.height as i32 + ABOVE, length };
    bar.draw(&Canvas::new(&mut picture).into_drawing_area(), &ticks)?;
    Ok(picture)
}

/// The map in the middle of so many columns, with white rows under it.
fn on_white(map: &ColourPicture, width: usize) -> ColourPicture {
    let mut picture = ColourPicture::filled(width, map.height + ROWS, [255; 3]);
    let indent = (width - map.width) / 2;
    for (to, from) in picture.pixels.chunks_exact_mut(width).zip(map.pixels.chunks_exact(map.width)) {
        to[indent..indent + map.width].copy_from_slice(from);
    }
    picture
}

/// Where the bar lies, pixels.
struct Bar {
    left: i32,
    top: i32,
    length: i32,
}

impl Bar {
    fn draw<B: Surface>(&self, area: &Area<B>, ticks: &[(f64, String)]) -> Result<()> {
        let Self { left, top, length } = *self;
        let bottom = top + THICKNESS;
        for column in 0..length {
            let [red, green, blue] = error_colour(2.0 * f64::from(column) / f64::from(length - 1) - 1.0);
            let corners = [(left + column, top), (left + column + 1, bottom)];
            area.draw(&Rectangle::new(corners, RGBColor(red, green, blue).filled()))?;
        }
        let corners = [(left - 1, top - 1), (left + length, bottom)];
        area.draw(&Rectangle::new(corners, PALE_INK.stroke_width(1)))?;
        for (fraction, text) in ticks {
            let column = left + (f64::midpoint(*fraction, 1.0) * f64::from(length - 1)).round() as i32;
            line(area, &[(column, bottom), (column, bottom + 4)], PALE_INK.stroke_width(1))?;
            let style = text_style(TEXT, false, INK).pos(Pos::new(HPos::Center, VPos::Top));
            area.draw(&Text::new(text.clone(), (column, bottom + 5), style))?;
        }
        Ok(())
    }
}

fn tick(value: f64, unit: &str) -> String {
    let sign = if value > 0.0 { "+" } else { "" };
    let space = if value == 0.0 && !unit.is_empty() { " " } else { "" };
    let unit = if value == 0.0 { unit } else { "" };
    format!("{sign}{}{space}{unit}", number(value + 0.0)).replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use drr::formats::error_map;

    use super::*;

    #[test]
    fn the_map_stays_and_the_bar_runs_from_blue_to_red() {
        for width in [1, 40, 700] {
            let view = vec![2.0; width * 30];
            let map = error_map(&[&view], width, 30, 2.0).unwrap();
            let picture = with_colour_bar(&map, 2.0, "HU").unwrap();
            assert_eq!(picture.height, 30 + ROWS);
            let indent = (picture.width - width) / 2;
            assert_eq!(picture.pixel(indent, 0), error_colour(1.0));
            assert_eq!(picture.pixel(indent + width - 1, 29), error_colour(1.0));
            let bar: Vec<_> = (0..picture.width).map(|column| picture.pixel(column, 30 + 15)).collect();
            let place = |colour| bar.iter().position(|pixel| *pixel == colour).unwrap();
            assert!(place(error_colour(-1.0)) < place(error_colour(1.0)));
        }
    }

    #[test]
    fn ticks_have_signs() {
        assert_eq!([-2.0, 0.0, 0.5].map(|value| tick(value, "HU")), ["\u{2212}2", "0 HU", "+0.5"]);
        assert_eq!(tick(-0.0, "HU"), "0 HU");
        assert_eq!(tick(0.0, ""), "0");
    }
}
