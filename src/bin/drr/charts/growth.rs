//! How times grow: small charts in one picture, each against another count.

use anyhow::Result;
use plotters::style::Color;

use super::axes::{Axes, Frame, MARGIN, paragraph};
use super::axis::Axis;
use super::decades::{Decades, Unit};
use super::drawing::{Area, Drawing, SIZE, Surface, TEXT, TITLE};
use super::legend::{Legend, Symbol};
use super::marker::{BLUE, INK, Marker, PALE_INK, Shape, dashes, line};

/// Most decades on an axis.
const MOST_DECADES: i32 = 7;
const MEASURED: Marker = Marker { colour: BLUE, shape: Shape::Disc, hollow: false };

/// Times of some counts.
#[derive(Debug, Clone)]
pub(crate) struct Growth {
    /// What stays the same.
    pub(crate) held: String,
    /// What is counted.
    pub(crate) x_label: String,
    /// The counts, growing, and of each the least, the median and the most of the times, s.
    pub(crate) points: Vec<(f64, [f64; 3])>,
    /// With which power of the count the work grows.
    pub(crate) power: f64,
}

/// Two rows of two.
#[derive(Debug, Clone)]
pub(crate) struct GrowthSheet {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) panels: [Growth; 4],
}

impl Drawing for GrowthSheet {
    fn draw<B: Surface>(&self, area: &Area<B>) -> Result<()> {
        let width = SIZE.0 as i32 - 2 * MARGIN;
        let mut y = paragraph(area, &self.title, MARGIN - 4, TITLE, INK)?;
        y = paragraph(area, &self.subtitle, y, TEXT, PALE_INK)? + 4;
        let legend = Legend(vec![
            (Symbol::MarkedLine(MEASURED), "median".into()),
            (Symbol::Spread, "spread".into()),
            (Symbol::Dashes(PALE_INK), "in proportion to the work, through the point of most work".into()),
        ]);
        legend.draw(area, [MARGIN, y], width)?;
        let (_, rest) = area.split_vertically(y + legend.height(width));
        let parts = rest.split_evenly((2, 2));
        self.panels.iter().zip(&parts).try_for_each(|(panel, part)| panel.draw(part))
    }
}

impl Growth {
    fn draw<B: Surface>(&self, area: &Area<B>) -> Result<()> {
        let ideal: Vec<[f64; 2]> =
            self.points.iter().map(|(count, _)| [*count, self.ideal(*count)]).collect();
        let counts = Decades::around(self.points.iter().map(|(count, _)| *count), MOST_DECADES, Unit::Number);
        let seconds = self.points.iter().flat_map(|(_, times)| times).copied();
        let seconds = seconds.chain(ideal.iter().map(|point| point[1]));
        let seconds = Decades::around(seconds, MOST_DECADES, Unit::Seconds);
        let axes = Axes {
            title: "",
            subtitle: &self.held,
            legend: Legend::default(),
            x: (Axis::Decades(counts), &self.x_label),
            y: (Axis::Decades(seconds), "time"),
            note: String::new(),
        };
        let frame = axes.draw(area)?;
        // A power of the count is straight here.
        if let (Some(first), Some(last)) = (ideal.first(), ideal.last()) {
            dashes(area, [*first, *last].map(|point| frame.pixel(point)), PALE_INK.stroke_width(2))?;
        }
        self.draw_points(area, &frame)
    }

    fn draw_points<B: Surface>(&self, area: &Area<B>, frame: &Frame) -> Result<()> {
        let at = |count: f64, seconds: f64| frame.pixel([count, seconds]);
        let medians: Vec<_> = self.points.iter().map(|(count, [_, median, _])| at(*count, *median)).collect();
        line(area, &medians, BLUE.stroke_width(2))?;
        for (count, [least, median, most]) in &self.points {
            frame.draw_mark(area, [*count, *median], MEASURED)?;
            line(area, &[at(*count, *least), at(*count, *most)], INK.stroke_width(1))?;
        }
        Ok(())
    }

    /// The time in proportion to the work, from that of the most work, which other things disturb least.
    pub(crate) fn ideal(&self, count: f64) -> f64 {
        let most = if self.power < 0.0 { self.points.first() } else { self.points.last() };
        most.map_or(f64::NAN, |(most, [_, median, _])| median * (count / most).powf(self.power))
    }
}
