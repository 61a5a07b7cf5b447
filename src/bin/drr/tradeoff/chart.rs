//! Error against time.

use anyhow::Result;
use plotters::element::{Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor, WHITE};

use super::axes::{Axes, Frame};
use super::decades::{Decades, Unit, number};
use super::drawing::{Area, Drawing, Surface, TEXT, text_style};
use super::glyphs::text_size;
use super::labels::{Obstacles, Place, Rect, Request, Segment, place};
use super::legend::{Legend, Symbol};
use super::marker::{
    BLUE, GREEN, INK, Marker, PALE_INK, PURPLE, RADIUS, Shape, VERMILION, arrow, line, ring,
};

const FRONT: RGBColor = RGBColor(150, 150, 150);
const LIMIT: RGBColor = VERMILION;
/// Height of a name, without the space between lines, pixels.
const NAME_HEIGHT: f64 = 14.0;

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

    fn marker(self, hollow: bool) -> Marker {
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
        let axes = self.axes(&points);
        let frame = axes.draw(area)?;
        let plot = Plot { points, frame: &frame, errors: axes.y.0, times: axes.x.0 };
        let limit = self.limit_hu.as_ref().filter(|(limit, _)| plot.errors.shows(*limit));
        let reserved = match limit {
            Some((limit, name)) => vec![plot.draw_limit(area, *limit, name)?],
            None => vec![],
        };
        plot.draw(area, reserved)
    }
}

impl Chart {
    fn axes(&self, points: &[&Point]) -> Axes<'_> {
        let limit = self.limit_hu.iter().map(|(limit, _)| *limit);
        let errors = points.iter().flat_map(|p| [p.error_hu, p.error_range[1].max(p.error_hu)]);
        let times = points.iter().flat_map(|p| [p.seconds, p.seconds_range[0], p.seconds_range[1]]);
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
            x: (Decades::around(times, Unit::Seconds), "time"),
            y: (Decades::around(errors.chain(limit), Unit::Number), "error, HU (RMSE)"),
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

fn has_bar([least, most]: [f64; 2]) -> bool {
    least < most
}

/// What is inside the axes.
struct Plot<'a> {
    points: Vec<&'a Point>,
    frame: &'a Frame,
    errors: Decades,
    times: Decades,
}

impl Plot<'_> {
    fn draw<B: Surface>(&self, area: &Area<B>, reserved: Vec<Rect>) -> Result<()> {
        let front = self.front();
        line(area, &front, FRONT.stroke_width(2))?;
        let bars = self.bars();
        for (point, [from, to]) in &bars {
            line(area, &[*from, *to], point.group.marker(false).colour.stroke_width(1))?;
        }
        let lines = front.windows(2).map(|w| [w[0], w[1]]).chain(bars.iter().map(|(_, bar)| *bar));
        let lines = lines.map(|ends| ends.map(spot)).collect();
        self.draw_names(area, reserved, lines)?;
        // The chosen mark and those of the front lie on top.
        let mut order = self.points.clone();
        order.sort_by_key(|point| (point.chosen, point.on_front));
        for point in order {
            self.draw_mark(area, point)?;
        }
        Ok(())
    }

    fn at(&self, point: &Point) -> (i32, i32) {
        self.frame.pixel([point.seconds, point.error_hu])
    }

    /// The allowed error as a line, and where its name is.
    fn draw_limit<B: Surface>(&self, area: &Area<B>, limit: f64, name: &str) -> Result<Rect> {
        let columns = &self.frame.columns;
        let (_, row) = self.frame.pixel([self.times.least, limit]);
        line(area, &[(columns.start, row), (columns.end, row)], LIMIT.stroke_width(1))?;
        let [width, height] = text_size(name, TEXT, false);
        let right = columns.end - 8;
        // Above the line, where there is room.
        let middle = if row - height > self.frame.rows.start { row - 10 } else { row + 10 };
        let style = text_style(TEXT, false, LIMIT).pos(Pos::new(HPos::Right, VPos::Center));
        area.draw(&Text::new(name.to_owned(), (right, middle), style))?;
        let half = f64::from(height) / 2.0;
        let [least, most] = [[right - width, middle], [right, middle]].map(|spot| spot.map(f64::from));
        Ok(Rect { least: [least[0], least[1] - half], most: [most[0], most[1] + half] })
    }

    /// The least error that can be had in a time: a stair from the top edge to the right one.
    fn front(&self) -> Vec<(i32, i32)> {
        let mut front: Vec<&&Point> = self.points.iter().filter(|point| point.on_front).collect();
        front.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let (Some(first), Some(last)) = (front.first(), front.last()) else { return vec![] };
        let mut stair = vec![(self.at(first).0, self.frame.rows.start)];
        for point in &front {
            let (column, row) = self.at(point);
            let level = stair.last().map_or(row, |(_, row)| *row);
            if stair.len() > 1 {
                stair.push((column, level));
            }
            stair.push((column, row));
        }
        stair.push((self.frame.columns.end, self.at(last).1));
        stair
    }

    /// Error bars with their ends.
    fn bars(&self) -> Vec<(&Point, [(i32, i32); 2])> {
        let mut bars = Vec::new();
        for point in &self.points {
            let (column, row) = self.at(point);
            if has_bar(point.seconds_range) {
                let [from, to] = point.seconds_range.map(|s| self.frame.pixel([s, point.error_hu]).0);
                bars.push((*point, [(from, row), (to, row)]));
                bars.extend([from, to].map(|end| (*point, [(end, row - 3), (end, row + 3)])));
            }
            if has_bar(point.error_range) {
                let [from, to] = point.error_range.map(|e| self.frame.pixel([point.seconds, e]).1);
                bars.push((*point, [(column, from), (column, to)]));
                bars.extend([from, to].map(|end| (*point, [(column - 3, end), (column + 3, end)])));
            }
        }
        bars
    }

    /// What stands at the mark.
    fn name(&self, point: &Point) -> String {
        let mut name = point.name.clone();
        if point.error_hu < self.errors.least {
            name += &format!(" (< {} HU)", number(self.errors.least));
        }
        if point.seconds < self.times.least {
            name += &format!(" (< {})", self.times.text(self.times.least));
        }
        if point.chosen {
            name += " (chosen)";
        }
        name
    }

    fn draw_names<B: Surface>(
        &self,
        area: &Area<B>,
        mut boxes: Vec<Rect>,
        lines: Vec<Segment>,
    ) -> Result<()> {
        let mut named = self.points.clone();
        named.sort_by_key(|point| (!point.chosen, !point.on_front));
        let radius = |point: &Point| f64::from(RADIUS + if point.chosen { 5 } else { 2 });
        boxes.extend(self.points.iter().map(|point| Rect::around(spot(self.at(point)), radius(point))));
        let requests: Vec<Request> = named
            .iter()
            .map(|point| {
                let width = text_size(&self.name(point), TEXT, point.chosen)[0];
                let size = [f64::from(width), NAME_HEIGHT];
                Request { at: spot(self.at(point)), radius: radius(point), size }
            })
            .collect();
        let (columns, rows) = (&self.frame.columns, &self.frame.rows);
        let corner = |column: i32, row: i32| [f64::from(column), f64::from(row)];
        let bounds = Rect {
            least: corner(columns.start + 4, rows.start + 2),
            most: corner(columns.end - 4, rows.end - 2),
        };
        let places = place(&requests, &Obstacles { bounds, boxes, lines });
        for place in &places {
            if let Some(leader) = place.leader {
                line(area, &leader.map(pixel), PALE_INK.mix(0.6).stroke_width(1))?;
            }
        }
        named.iter().zip(&places).try_for_each(|(point, place)| self.draw_name(area, point, place))
    }

    fn draw_name<B: Surface>(&self, area: &Area<B>, point: &Point, place: &Place) -> Result<()> {
        let Rect { least, most } = place.area;
        area.draw(&Rectangle::new([pixel(least), pixel(most)], WHITE.mix(0.8).filled()))?;
        let (column, side) = match place.side {
            -1 => (least[0], HPos::Left),
            0 => ((least[0] + most[0]) / 2.0, HPos::Center),
            _ => (most[0], HPos::Right),
        };
        let middle = pixel([column, (least[1] + most[1]) / 2.0]);
        let style = text_style(TEXT, point.chosen, INK).pos(Pos::new(side, VPos::Center));
        Ok(area.draw(&Text::new(self.name(point), middle, style))?)
    }

    fn draw_mark<B: Surface>(&self, area: &Area<B>, point: &Point) -> Result<()> {
        let at = self.at(point);
        if point.error_hu < self.errors.least {
            arrow(area, at, (0, 1))?;
        }
        if point.seconds < self.times.least {
            arrow(area, at, (-1, 0))?;
        }
        if point.chosen {
            ring(area, at)?;
        }
        point.group.marker(point.of_another_model).draw(area, at)
    }
}

fn spot((x, y): (i32, i32)) -> [f64; 2] {
    [f64::from(x), f64::from(y)]
}

fn pixel([x, y]: [f64; 2]) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}
