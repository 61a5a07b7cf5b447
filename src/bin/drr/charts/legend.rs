//! What marks and lines mean, in rows above the axes.

use anyhow::Result;
use plotters::element::Text;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor};

use super::drawing::{Area, Surface, TEXT, text_style};
use super::glyphs::text_size;
use super::marker::{INK, Marker, RADIUS, dashes, line, ring};

/// Height of a row, width of a symbol and space after a text, pixels.
pub(super) const ROW: i32 = 20;
const SYMBOL: i32 = 32;
const SPACE: i32 = 22;

#[derive(Debug, Clone, Copy)]
pub(super) enum Symbol {
    Mark(Marker),
    Line(RGBColor),
    MarkedLine(Marker),
    Dashes(RGBColor),
    Ring,
    /// A cross of error bars.
    Bars,
    /// One error bar.
    Spread,
}

/// Symbols and what they mean.
#[derive(Debug, Default)]
pub(super) struct Legend(pub(super) Vec<(Symbol, String)>);

impl Legend {
    /// Where each entry starts (left, row), in rows of this width.
    fn places(&self, width: i32) -> Vec<(i32, i32)> {
        let (mut left, mut row) = (0, 0);
        self.0
            .iter()
            .map(|(_, text)| {
                let needed = SYMBOL + text_size(text, TEXT, false)[0];
                if left > 0 && left + needed > width {
                    (left, row) = (0, row + 1);
                }
                let place = (left, row);
                left += needed + SPACE;
                place
            })
            .collect()
    }

    /// Height of all rows, pixels.
    pub(super) fn height(&self, width: i32) -> i32 {
        self.places(width).last().map_or(0, |(_, row)| (row + 1) * ROW)
    }

    pub(super) fn draw<B: Surface>(&self, area: &Area<B>, [x, y]: [i32; 2], width: i32) -> Result<()> {
        for ((symbol, text), (left, row)) in self.0.iter().zip(self.places(width)) {
            let (left, middle) = (x + left, y + row * ROW + ROW / 2);
            symbol.draw(area, (left + SYMBOL / 2 - 4, middle))?;
            let style = text_style(TEXT, false, INK).pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(text.clone(), (left + SYMBOL, middle), style))?;
        }
        Ok(())
    }
}

impl Symbol {
    fn draw<B: Surface>(self, area: &Area<B>, (x, y): (i32, i32)) -> Result<()> {
        let level = [(x - 12, y), (x + 12, y)];
        match self {
            Self::Mark(marker) => marker.draw(area, (x, y)),
            Self::Line(colour) => line(area, &level, colour.stroke_width(2)),
            Self::MarkedLine(marker) => {
                line(area, &level, marker.colour.stroke_width(2))?;
                marker.draw(area, (x, y))
            }
            Self::Dashes(colour) => dashes(area, level, colour.stroke_width(2)),
            Self::Ring => ring(area, (x, y)),
            Self::Spread => line(area, &level, INK.stroke_width(1)),
            Self::Bars => {
                line(area, &[(x - RADIUS - 2, y), (x + RADIUS + 2, y)], INK.stroke_width(1))?;
                line(area, &[(x, y - RADIUS - 2), (x, y + RADIUS + 2)], INK.stroke_width(1))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_stay_within_the_width() {
        let legend = Legend((0..20).map(|i| (Symbol::Ring, format!("entry {i}"))).collect());
        let places = legend.places(300);
        for ((left, _), (_, text)) in places.iter().zip(&legend.0) {
            assert!(left + SYMBOL + text_size(text, TEXT, false)[0] <= 300);
        }
        assert!(places.is_sorted_by_key(|(left, row)| (*row, *left)));
        assert_eq!(legend.height(300), (places[19].1 + 1) * ROW);
        assert_eq!(Legend::default().height(300), 0);
    }
}
