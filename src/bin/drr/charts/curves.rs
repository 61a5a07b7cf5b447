//! Named curves.

use anyhow::Result;
use plotters::style::Color;

use super::axes::{Axes, Frame};
use super::axis::Axis;
use super::counts::Counts;
use super::decades::{Decades, Unit};
use super::drawing::{Area, Drawing, Surface};
use super::legend::{Legend, Symbol};
use super::marker::{BLUE, GREEN, Marker, ORANGE, PURPLE, SKY, Shape, VERMILION, line};

/// Most decades on an axis: from single precision's errors to those of sums in double precision.
const MOST_DECADES: i32 = 14;

/// A curve.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(crate) name: String,
    /// [x, y], in the order in which the curve goes through them.
    pub(crate) points: Vec<[f64; 2]>,
}

/// How an axis goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    /// Equal factors are equal distances.
    Decades,
    /// Equal differences are equal distances, from 0.
    Counts,
}

impl Scale {
    fn axis(self, values: impl IntoIterator<Item = f64>) -> Axis {
        match self {
            Self::Decades => Axis::Decades(Decades::around(values, MOST_DECADES, Unit::Number)),
            Self::Counts => Axis::Counts(Counts::up_to(values)),
        }
    }
}

/// Curves on common axes, of which y is logarithmic.
#[derive(Debug, Clone)]
pub(crate) struct Curves {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) x_scale: Scale,
    pub(crate) x_label: String,
    pub(crate) y_label: String,
    pub(crate) series: Vec<Series>,
}

impl Drawing for Curves {
    fn draw<B: Surface>(&self, area: &Area<B>) -> Result<()> {
        let values =
            |axis: usize| self.series.iter().flat_map(move |s| s.points.iter().map(move |p| p[axis]));
        let (x, y) = (self.x_scale.axis(values(0)), Scale::Decades.axis(values(1)));
        let entries = self.series.iter().enumerate();
        let legend = entries.map(|(i, s)| (Symbol::MarkedLine(marker(i)), s.name.clone())).collect();
        let axes = Axes {
            title: &self.title,
            subtitle: &self.subtitle,
            legend: Legend(legend),
            x: (x, &self.x_label),
            y: (y, &self.y_label),
            note: String::new(),
        };
        let frame = axes.draw(area)?;
        for (i, series) in self.series.iter().enumerate() {
            series.draw(area, &frame, marker(i))?;
        }
        Ok(())
    }
}

impl Series {
    /// The curve has a gap where a point has no place, and an arrow where one lies below the axis.
    fn draw<B: Surface>(&self, area: &Area<B>, frame: &Frame, marker: Marker) -> Result<()> {
        let style = marker.colour.stroke_width(2);
        for part in self.points.split(|point| !point.iter().all(|v| v.is_finite())) {
            line(area, &part.iter().map(|point| frame.mark(*point)).collect::<Vec<_>>(), style)?;
        }
        for point in self.points.iter().filter(|point| point.iter().all(|v| v.is_finite())) {
            frame.draw_mark(area, *point, marker)?;
        }
        Ok(())
    }
}

/// The mark of the i-th curve: colours and shapes change together, so that either tells curves apart.
fn marker(i: usize) -> Marker {
    let colours = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY];
    let shapes = [Shape::Disc, Shape::Square, Shape::Diamond, Shape::Triangle];
    Marker { colour: colours[i % colours.len()], shape: shapes[i % shapes.len()], hollow: false }
}
