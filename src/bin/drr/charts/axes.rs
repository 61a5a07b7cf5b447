//! Title, legend and axes: what all charts have.

use std::ops::Range;

use anyhow::Result;
use plotters::chart::ChartBuilder;
use plotters::coord::ranged1d::Ranged as _;
use plotters::element::{Rectangle, Text};
use plotters::style::{Color, RGBColor};

use super::axis::Axis;
use super::drawing::{Area, Surface, TEXT, TITLE, text_style};
use super::glyphs::text_size;
use super::legend::Legend;
use super::marker::{ARROW, INK, Marker, PALE_INK, arrow};

pub(super) const MARGIN: i32 = 16;
/// Room for the texts of the axes: under the plot, and left of it.
const UNDER: i32 = 50;
const LEFT: i32 = 72;
/// The last text of the x axis is centred at the plot's right end.
const RIGHT: i32 = 34;
pub(super) const GRID: RGBColor = RGBColor(208, 208, 208);
const FINE_GRID: RGBColor = RGBColor(238, 238, 238);

/// Everything around the plot.
pub(super) struct Axes<'a> {
    pub(super) title: &'a str,
    pub(super) subtitle: &'a str,
    pub(super) legend: Legend,
    pub(super) x: (Axis, &'a str),
    pub(super) y: (Axis, &'a str),
    /// Under the axes, where there is something to add.
    pub(super) note: String,
}

/// Where values lie in the area that is drawn on.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    x: Axis,
    y: Axis,
    pub(super) columns: Range<i32>,
    pub(super) rows: Range<i32>,
}

impl Axes<'_> {
    /// Draws everything but what is in the plot.
    pub(super) fn draw<B: Surface>(&self, area: &Area<B>) -> Result<Frame> {
        let (width, height) = area.dim_in_pixel();
        let width = width as i32 - 2 * MARGIN;
        let mut y = MARGIN - 4;
        y = paragraph(area, self.title, y, TITLE, INK)?;
        y = paragraph(area, self.subtitle, y, TEXT, PALE_INK)? + 4;
        self.legend.draw(area, [MARGIN, y], width)?;
        y += self.legend.height(width) + 10;
        let note = wrapped(&self.note, width, TEXT, false).len() as i32 * TEXT as i32;
        let bottom = height as i32 - note - if note > 0 { 12 } else { 8 };
        paragraph(area, &self.note, bottom + 4, TEXT, PALE_INK)?;
        self.mesh(area, y..bottom)
    }

    fn mesh<B: Surface>(&self, area: &Area<B>, rows: Range<i32>) -> Result<Frame> {
        let mut builder = ChartBuilder::on(area);
        let height = area.dim_in_pixel().1 as i32;
        builder.margin_top(rows.start).margin_bottom(height - rows.end).margin_right(RIGHT);
        builder.margin_left(MARGIN / 2).x_label_area_size(UNDER).y_label_area_size(LEFT);
        let mut chart = builder.build_cartesian_2d(self.x.0, self.y.0)?;
        let style = || text_style(TEXT, false, INK);
        // The axis decides itself how many ticks it has.
        let mut mesh = chart.configure_mesh();
        mesh.bold_line_style(GRID).light_line_style(FINE_GRID).axis_style(PALE_INK);
        mesh.label_style(style()).axis_desc_style(style()).x_desc(self.x.1).y_desc(self.y.1);
        mesh.draw()?;
        let (columns, rows) = chart.plotting_area().get_pixel_range();
        // Of the whole picture, where the area may be a part of it.
        let (left, top) = area.get_base_pixel();
        let (columns, rows) = (columns.start - left..columns.end - left, rows.start - top..rows.end - top);
        let frame = Frame { x: self.x.0, y: self.y.0, columns, rows };
        let corners = [(frame.columns.start, frame.rows.start), (frame.columns.end, frame.rows.end)];
        area.draw(&Rectangle::new(corners, PALE_INK.stroke_width(1)))?;
        Ok(frame)
    }
}

impl Frame {
    /// The pixel of a value, at the edge for one beyond.
    pub(super) fn pixel(&self, [x, y]: [f64; 2]) -> (i32, i32) {
        let column = self.x.map(&x, (self.columns.start, self.columns.end));
        (column, self.y.map(&y, (self.rows.end, self.rows.start)))
    }

    /// The pixel of a mark: for one too small to be shown, so far from the edge that its arrow has room.
    pub(super) fn mark(&self, value: [f64; 2]) -> (i32, i32) {
        let ((column, row), [left, below]) = (self.pixel(value), self.lacks(value));
        let column = if left { self.columns.start + ARROW } else { column };
        (column, if below { self.rows.end - ARROW } else { row })
    }

    /// Whether the value is too small to be shown: left of the axes, under them.
    pub(super) fn lacks(&self, [x, y]: [f64; 2]) -> [bool; 2] {
        [x < self.x.least(), y < self.y.least()]
    }

    /// Draws the mark, and arrows from it to the edges beyond which its value lies.
    pub(super) fn draw_mark<B: Surface>(
        &self,
        area: &Area<B>,
        value: [f64; 2],
        marker: Marker,
    ) -> Result<()> {
        let (at, [left, below]) = (self.mark(value), self.lacks(value));
        if left {
            arrow(area, at, (-1, 0))?;
        }
        if below {
            arrow(area, at, (0, 1))?;
        }
        marker.draw(area, at)
    }
}

/// Draws a text in as many lines as it needs; the row under it.
pub(super) fn paragraph<B: Surface>(
    area: &Area<B>,
    text: &str,
    top: i32,
    height: f64,
    colour: RGBColor,
) -> Result<i32> {
    let bold = height == TITLE;
    let mut row = top;
    for line in wrapped(text, area.dim_in_pixel().0 as i32 - 2 * MARGIN, height, bold) {
        area.draw(&Text::new(line, (MARGIN, row), text_style(height, bold, colour)))?;
        row += height as i32 + if bold { 4 } else { 1 };
    }
    Ok(row)
}

/// The text's words in lines of at most this width, where its words allow it.
pub(super) fn wrapped(text: &str, width: i32, height: f64, bold: bool) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if text_size(&format!("{line} {word}"), height, bold)[0] <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_wrapped_and_no_word_is_lost() {
        let text = "a few words that are longer than a line of this picture may be";
        let lines = wrapped(text, 120, TEXT, false);
        assert!(lines.len() > 2 && lines.iter().all(|line| text_size(line, TEXT, false)[0] <= 120));
        assert_eq!(lines.join(" "), text);
        assert!(wrapped("", 120, TEXT, false).is_empty());
    }
}
