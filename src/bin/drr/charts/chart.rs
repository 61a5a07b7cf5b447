//! Error against time.

use anyhow::Result;
use plotters::style::RGBColor;

use super::axes::Axes;
use super::axis::Axis;
use super::decades::{Decades, Unit};
use super::drawing::{Area, Drawing, Surface};
use super::legend::{Legend, Symbol};
use super::marker::{BLUE, GREEN, Marker, PURPLE, Shape, VERMILION};
use super::plot::Plot;

/// The line through the points of which none is both faster and more accurate.
pub(super) const FRONT: RGBColor = RGBColor(150, 150, 150);

/// Most decades on an axis: one error of rounding must not make all others look alike.
const MOST_DECADES: i32 = 5;

/// What colour and shape of a mark stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Group {
    Joseph,
    March,
    Siddon,
    Other,
}

/// One way to compute.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    pub(crate) name: String,
    pub(crate) group: Group,
    pub(crate) seconds: f64,
    /// Least and most of the repeated measurements.
    pub(crate) seconds_range: [f64; 2],
    pub(crate) error_hu: f64,
    /// What the error may be, given that it was measured on a sample of rays.
    pub(crate) error_range: [f64; 2],
    /// No other point is both faster and more accurate.
    pub(crate) on_front: bool,
    pub(crate) chosen: bool,
    /// Its distance is a difference of model and no error; drawn hollow.
    pub(crate) of_another_model: bool,
}

/// Error against time, both logarithmic.
#[derive(Debug, Clone)]
pub(crate) struct Chart {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) points: Vec<Point>,
    /// An error that is allowed, and what allows it.
    pub(crate) limit_hu: Option<(f64, String)>,
}

impl Group {
    const ALL: [Self; 4] = [Self::Joseph, Self::March, Self::Siddon, Self::Other];

    fn name(self) -> &'static str {
        match self {
            Self::Joseph => "Joseph",
            Self::March => "march",
            Self::Siddon => "Siddon",
            Self::Other => "other",
        }
    }

    pub(super) fn marker(self, hollow: bool) -> Marker {
        let (colour, shape) = match self {
            Self::Joseph => (BLUE, Shape::Disc),
            Self::March => (VERMILION, Shape::Square),
            Self::Siddon => (GREEN, Shape::Diamond),
            Self::Other => (PURPLE, Shape::Triangle),
        };
        Marker { colour, shape, hollow }
    }
}

impl Point {
    fn is_drawn(&self) -> bool {
        self.seconds.is_finite() && self.error_hu.is_finite()
    }
}

impl Drawing for Chart {
    fn draw<B: Surface>(&self, area: &Area<B>) -> Result<()> {
        let points: Vec<&Point> = self.points.iter().filter(|point| point.is_drawn()).collect();
        let frame = self.axes(&points).draw(area)?;
        let [times, errors] = self.decades(&points);
        let plot = Plot { points, frame: &frame, errors, times };
        let limit = self.limit_hu.as_ref().filter(|(limit, _)| plot.errors.shows(*limit));
        let reserved = match limit {
            Some((limit, name)) => vec![plot.draw_limit(area, *limit, name)?],
            None => vec![],
        };
        plot.draw(area, reserved)
    }
}

impl Chart {
    /// Of times, and of errors.
    fn decades(&self, points: &[&Point]) -> [Decades; 2] {
        let limit = self.limit_hu.iter().map(|(limit, _)| *limit);
        let errors = points.iter().flat_map(|p| [p.error_hu, p.error_range[1].max(p.error_hu)]);
        let times = points.iter().flat_map(|p| [p.seconds, p.seconds_range[0], p.seconds_range[1]]);
        [
            Decades::around(times, MOST_DECADES, Unit::Seconds),
            Decades::around(errors.chain(limit), MOST_DECADES, Unit::Number),
        ]
    }

    /// What is around the points.
    pub(super) fn axes(&self, points: &[&Point]) -> Axes<'_> {
        let [times, errors] = self.decades(points).map(Axis::Decades);
        let left_out: Vec<&str> =
            self.points.iter().filter(|p| !p.is_drawn()).map(|p| p.name.as_str()).collect();
        let note = if left_out.is_empty() {
            String::new()
        } else {
            format!("Without a finite time and error: {}", left_out.join(", "))
        };
        Axes {
            title: &self.title,
            subtitle: &self.subtitle,
            legend: legend(points),
            x: (times, "time"),
            y: (errors, "error, HU (RMSE)"),
            note,
        }
    }
}

/// What of it is in the chart.
fn legend(points: &[&Point]) -> Legend {
    let mut entries = Vec::new();
    for group in Group::ALL {
        let mut members = points.iter().filter(|point| point.group == group).peekable();
        if members.peek().is_some() {
            let hollow = members.all(|point| point.of_another_model);
            let name = if hollow { format!("{} (another model)", group.name()) } else { group.name().into() };
            entries.push((Symbol::Mark(group.marker(hollow)), name));
        }
    }
    if points.iter().any(|point| point.on_front) {
        entries.push((Symbol::Line(FRONT), "least error for the time".into()));
    }
    if points.iter().any(|point| point.chosen) {
        entries.push((Symbol::Ring, "chosen".into()));
    }
    if points.iter().any(|p| has_bar(p.seconds_range) || has_bar(p.error_range)) {
        entries.push((Symbol::Bars, "spread of times, sampling error".into()));
    }
    Legend(entries)
}

/// Whether there is a range to show.
pub(super) fn has_bar([least, most]: [f64; 2]) -> bool {
    least < most
}
