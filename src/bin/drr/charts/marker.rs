//! Marks of points: colour and shape.

use anyhow::Result;
use plotters::element::{Circle, PathElement, Polygon};
use plotters::style::{Color, RGBColor, ShapeStyle, WHITE};

use super::drawing::{Area, Surface};

/// Half the width of a mark, pixels.
pub(super) const RADIUS: i32 = 6;

/// From a mark's middle to the tip of its arrow, pixels.
pub(super) const ARROW: i32 = RADIUS + 14;

/// Length of a dash, and of the gap after it, pixels.
const DASH: f64 = 7.0;

/// Colours that the colour-blind can tell apart, too (Okabe and Ito).
pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(super) const VERMILION: RGBColor = RGBColor(213, 94, 0);
pub(super) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(super) const PURPLE: RGBColor = RGBColor(204, 121, 167);
pub(super) const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub(super) const SKY: RGBColor = RGBColor(86, 180, 233);

/// For what is not a point.
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const PALE_INK: RGBColor = RGBColor(110, 110, 110);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Disc,
    Square,
    Triangle,
    Diamond,
}

/// How a point is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Marker {
    pub(super) colour: RGBColor,
    pub(super) shape: Shape,
    pub(super) hollow: bool,
}

impl Marker {
    pub(super) fn draw<B: Surface>(self, area: &Area<B>, at: (i32, i32)) -> Result<()> {
        // A white rim keeps marks apart that lie on each other.
        self.fill(area, at, RADIUS + 1, WHITE)?;
        self.fill(area, at, RADIUS, self.colour)?;
        if self.hollow {
            self.fill(area, at, RADIUS - 2, WHITE)?;
        }
        Ok(())
    }

    fn fill<B: Surface>(self, area: &Area<B>, (x, y): (i32, i32), r: i32, colour: RGBColor) -> Result<()> {
        let style = colour.filled();
        let polygon = |corners: &[(i32, i32)]| {
            let corners: Vec<_> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
            area.draw(&Polygon::new(corners, style))
        };
        match self.shape {
            Shape::Disc => area.draw(&Circle::new((x, y), r, style))?,
            Shape::Square => {
                let r = r - 1;
                polygon(&[(-r, -r), (r, -r), (r, r), (-r, r)])?;
            }
            Shape::Triangle => polygon(&[(0, -r - 1), (r + 1, r - 1), (-r - 1, r - 1)])?,
            Shape::Diamond => polygon(&[(0, -r - 1), (r + 1, 0), (0, r + 1), (-r - 1, 0)])?,
        }
        Ok(())
    }
}

/// The ring around the chosen point.
pub(super) fn ring<B: Surface>(area: &Area<B>, at: (i32, i32)) -> Result<()> {
    Ok(area.draw(&Circle::new(at, RADIUS + 4, INK.stroke_width(2)))?)
}

/// An arrow: the value lies beyond the edge on this side.
pub(super) fn arrow<B: Surface>(area: &Area<B>, from: (i32, i32), (dx, dy): (i32, i32)) -> Result<()> {
    let along = |n: i32, side: i32| (from.0 + n * dx + side * dy, from.1 + n * dy + side * dx);
    area.draw(&PathElement::new(vec![along(RADIUS, 0), along(RADIUS + 8, 0)], INK.stroke_width(2)))?;
    let head = vec![along(ARROW, 0), along(RADIUS + 7, 4), along(RADIUS + 7, -4)];
    Ok(area.draw(&Polygon::new(head, INK.filled()))?)
}

/// A line through spots; a line of one spot is none.
pub(super) fn line<B: Surface>(area: &Area<B>, spots: &[(i32, i32)], style: ShapeStyle) -> Result<()> {
    let mut path = spots.to_vec();
    path.dedup();
    if path.len() > 1 {
        area.draw(&PathElement::new(path, style))?;
    }
    Ok(())
}

/// A dashed line.
pub(super) fn dashes<B: Surface>(
    area: &Area<B>,
    [from, to]: [(i32, i32); 2],
    style: ShapeStyle,
) -> Result<()> {
    let along = [f64::from(to.0 - from.0), f64::from(to.1 - from.1)];
    // One dash more than there are gaps.
    let parts = 2 * (along[0].hypot(along[1]) / (2.0 * DASH)) as u32 + 1;
    let spot = |part: u32| {
        let [dx, dy] = along.map(|length| (length * f64::from(part) / f64::from(parts)).round() as i32);
        (from.0 + dx, from.1 + dy)
    };
    (0..parts).step_by(2).try_for_each(|part| line(area, &[spot(part), spot(part + 1)], style))
}
