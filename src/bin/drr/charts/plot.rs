//! What is inside the axes of a chart: points with names and bars, the front, the limit.

use anyhow::Result;
use plotters::element::{Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor, WHITE};

use super::axes::Frame;
use super::chart::{FRONT, Point, has_bar};
use super::decades::{Decades, number};
use super::drawing::{Area, Surface, TEXT, text_style};
use super::glyphs::text_size;
use super::labels::{Obstacles, Place, Rect, Request, Segment, place};
use super::marker::{INK, PALE_INK, RADIUS, VERMILION, line, ring};

pub(super) const LIMIT: RGBColor = VERMILION;
/// Height of a name, without the space between lines, pixels.
const NAME_HEIGHT: f64 = 14.0;

/// What is inside the axes.
pub(super) struct Plot<'a> {
    pub(super) points: Vec<&'a Point>,
    pub(super) frame: &'a Frame,
    pub(super) errors: Decades,
    pub(super) times: Decades,
}

impl Plot<'_> {
    pub(super) fn draw<B: Surface>(&self, area: &Area<B>, reserved: Vec<Rect>) -> Result<()> {
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
        self.frame.mark([point.seconds, point.error_hu])
    }

    /// The allowed error as a line, and where its name is.
    pub(super) fn draw_limit<B: Surface>(&self, area: &Area<B>, limit: f64, name: &str) -> Result<Rect> {
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

    /// What stands at the mark: with the value, where the mark cannot show it.
    fn name(&self, point: &Point) -> String {
        let mut name = point.name.clone();
        let [left, below] = self.frame.lacks([point.seconds, point.error_hu]);
        if below {
            name = format!("{name} ({} HU)", number(point.error_hu));
        }
        if left {
            name = format!("{name} ({})", self.times.text(point.seconds));
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
        let radius = |point: &Point| f64::from(RADIUS + if point.chosen { 6 } else { 3 });
        boxes.extend(self.points.iter().map(|point| Rect::around(spot(self.at(point)), radius(point))));
        let requests: Vec<Request> = named
            .iter()
            .map(|point| {
                let width = text_size(&self.name(point), TEXT, point.chosen)[0];
                // In SVG, bold letters of some fonts are wider than those of PNG.
                let size = [f64::from(width) * if point.chosen { 1.12 } else { 1.0 }, NAME_HEIGHT];
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
            0 => (f64::midpoint(least[0], most[0]), HPos::Center),
            _ => (most[0], HPos::Right),
        };
        let middle = pixel([column, f64::midpoint(least[1], most[1])]);
        let style = text_style(TEXT, point.chosen, INK).pos(Pos::new(side, VPos::Center));
        Ok(area.draw(&Text::new(self.name(point), middle, style))?)
    }

    fn draw_mark<B: Surface>(&self, area: &Area<B>, point: &Point) -> Result<()> {
        if point.chosen {
            ring(area, self.at(point))?;
        }
        let marker = point.group.marker(point.of_another_model);
        self.frame.draw_mark(area, [point.seconds, point.error_hu], marker)
    }
}

fn spot((x, y): (i32, i32)) -> [f64; 2] {
    [f64::from(x), f64::from(y)]
}

fn pixel([x, y]: [f64; 2]) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}
