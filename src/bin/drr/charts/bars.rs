//! Bars from 1: how many times as long something takes.

use std::ops::Range;

use anyhow::Result;
use plotters::element::{Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor};

use super::axes::{GRID, MARGIN, paragraph};
use super::drawing::{Area, Drawing, SIZE, Surface, TEXT, TITLE, text_style};
use super::glyphs::text_size;
use super::legend::{Legend, Symbol};
use super::marker::{BLUE, GREEN, INK, Marker, PALE_INK, Shape, VERMILION, line};

/// Numbers of a decade that have grid lines.
const STEPS: [f64; 3] = [1.0, 2.0, 5.0];
/// Under the plot, for ticks and the axis' name; right of it, for a number beside the longest bar.
const UNDER: i32 = 50;
const RIGHT: i32 = 74;
/// Between texts and what they are beside.
const GAP: i32 = 8;
/// Thickest bar, and its part of a row.
const THICKEST: f64 = 16.0;
const PART: f64 = 0.72;
/// Largest number of which the part beyond 1 is told in percent.
const IN_PERCENT: f64 = 2.0;

/// A ratio.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bar {
    pub(crate) value: f64,
    /// The least and the most of repeated measurements.
    pub(crate) range: [f64; 2],
    /// Of another kind than the others.
    pub(crate) pale: bool,
}

/// Ratios by name, on a logarithmic axis.
#[derive(Debug, Clone)]
pub(crate) struct Bars {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) x_label: String,
    /// What each bar of a row is of.
    pub(crate) series: Vec<String>,
    /// A row has one bar of each series, where there is one.
    pub(crate) rows: Vec<(String, Vec<Option<Bar>>)>,
    /// What pale bars are.
    pub(crate) pale: String,
}

/// Where ratios and rows lie.
struct Plot {
    columns: Range<i32>,
    rows: Range<i32>,
    least: f64,
    most: f64,
}

impl Drawing for Bars {
    fn draw<B: Surface>(&self, area: &Area<B>) -> Result<()> {
        let width = SIZE.0 as i32 - 2 * MARGIN;
        let mut y = paragraph(area, &self.title, MARGIN - 4, TITLE, INK)?;
        y = paragraph(area, &self.subtitle, y, TEXT, PALE_INK)? + 4;
        let legend = self.legend();
        legend.draw(area, [MARGIN, y], width)?;
        y += legend.height(width) + 10;
        let plot = self.plot(y);
        plot.mesh(area, &self.x_label)?;
        let pitch = f64::from(plot.rows.end - plot.rows.start) / self.rows.len().max(1) as f64;
        for (n, (name, bars)) in self.rows.iter().enumerate() {
            let middle = f64::from(plot.rows.start) + (n as f64 + 0.5) * pitch;
            let style = text_style(TEXT, false, INK).pos(Pos::new(HPos::Right, VPos::Center));
            area.draw(&Text::new(name.clone(), (plot.columns.start - GAP, middle as i32), style))?;
            let thickness = (PART * pitch).min(THICKEST * bars.len() as f64) / bars.len().max(1) as f64;
            let (mut texts, mut end) = (Vec::new(), plot.column(1.0));
            for (s, bar) in bars.iter().enumerate() {
                let top = middle + (s as f64 - 0.5 * bars.len() as f64) * thickness;
                if let Some(bar) = bar.filter(|bar| bar.value.is_finite()) {
                    end = end.max(plot.draw_bar(area, bar, colour(s), [top, top + thickness])?);
                    texts.push(text(bar));
                }
            }
            let style = text_style(TEXT, false, INK).pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(texts.join(" | "), (end + GAP, middle as i32), style))?;
        }
        plot.draw_one(area)
    }
}

impl Bars {
    fn legend(&self) -> Legend {
        let square = |colour| Symbol::Mark(Marker { colour, shape: Shape::Square, hollow: false });
        let series = self.series.iter().enumerate();
        let mut entries: Vec<_> = series.map(|(s, name)| (square(colour(s)), name.clone())).collect();
        if self.bars().any(|bar| bar.pale) {
            entries.push((square(paler(colour(0))), self.pale.clone()));
        }
        if self.bars().any(|bar| bar.range[0] < bar.range[1]) {
            entries.push((Symbol::Spread, "spread".into()));
        }
        Legend(entries)
    }

    fn bars(&self) -> impl Iterator<Item = Bar> {
        self.rows.iter().flat_map(|(_, bars)| bars.iter().copied().flatten())
    }

    fn plot(&self, top: i32) -> Plot {
        let names = self.rows.iter().map(|(name, _)| text_size(name, TEXT, false)[0]);
        let left = MARGIN + names.max().unwrap_or(0) + GAP;
        let values = self.bars().flat_map(|bar| [bar.value, bar.range[0], bar.range[1]]);
        let values = values.filter(|value| value.is_normal() && *value > 0.0);
        let [least, most] = values.fold([1.0, 2.0], |[a, b], v| [f64::min(a, v), f64::max(b, v)]);
        Plot {
            columns: left..SIZE.0 as i32 - RIGHT * self.series.len().clamp(1, 3) as i32,
            rows: top..SIZE.1 as i32 - UNDER,
            least: if least < 0.97 { least.max(1e-3) / 1.05 } else { 0.97 },
            most: most.min(1e6),
        }
    }
}

impl Plot {
    fn column(&self, value: f64) -> i32 {
        let fraction = (value.clamp(self.least, self.most) / self.least).ln() / (self.most / self.least).ln();
        self.columns.start + (fraction * f64::from(self.columns.end - self.columns.start)).round() as i32
    }

    fn mesh<B: Surface>(&self, area: &Area<B>, label: &str) -> Result<()> {
        let decades = self.least.log10().floor() as i32..=self.most.log10().ceil() as i32;
        let ticks = decades.flat_map(|decade| STEPS.map(|step| step * 10_f64.powi(decade)));
        let style = || text_style(TEXT, false, INK).pos(Pos::new(HPos::Center, VPos::Top));
        for tick in ticks.filter(|tick| (self.least..=self.most).contains(tick)) {
            let column = self.column(tick);
            line(area, &[(column, self.rows.start), (column, self.rows.end + 4)], GRID.stroke_width(1))?;
            let text = format!("{}\u{d7}", super::decades::number(tick));
            area.draw(&Text::new(text, (column, self.rows.end + 6), style()))?;
        }
        let middle = i32::midpoint(self.columns.start, self.columns.end);
        area.draw(&Text::new(label.to_owned(), (middle, self.rows.end + 28), style()))?;
        Ok(())
    }

    /// The line where bars begin.
    fn draw_one<B: Surface>(&self, area: &Area<B>) -> Result<()> {
        let column = self.column(1.0);
        line(area, &[(column, self.rows.start), (column, self.rows.end)], INK.stroke_width(2))
    }

    /// Draws a bar and its spread; the column where both end.
    fn draw_bar<B: Surface>(
        &self,
        area: &Area<B>,
        bar: Bar,
        colour: RGBColor,
        [top, bottom]: [f64; 2],
    ) -> Result<i32> {
        let colour = if bar.pale { paler(colour) } else { colour };
        let (one, end) = (self.column(1.0), self.column(bar.value));
        let (from, to) = (one.min(end), one.max(end).max(one.min(end) + 1));
        let rows = [top, bottom].map(|row| row.round() as i32);
        area.draw(&Rectangle::new([(from, rows[0]), (to, rows[1])], colour.filled()))?;
        let [least, most] = bar.range.map(|value| self.column(value));
        let middle = i32::midpoint(rows[0], rows[1]);
        if most > least {
            line(area, &[(least, middle), (most, middle)], INK.stroke_width(1))?;
        }
        Ok(to.max(most))
    }
}

/// The number beside a bar.
fn text(bar: Bar) -> String {
    if bar.pale || bar.value >= IN_PERCENT {
        let digits = usize::from(bar.value < 10.0);
        let digits = if bar.value < 1.0 { 2 } else { digits };
        return format!("{:.digits$}\u{d7}", bar.value);
    }
    let percent = (100.0 * (bar.value - 1.0)).round();
    let sign = if percent < 0.0 { "\u{2212}" } else { "+" };
    format!("{sign}{} %", percent.abs())
}

fn colour(series: usize) -> RGBColor {
    [BLUE, VERMILION, GREEN][series % 3]
}

/// Half way to white.
fn paler(RGBColor(red, green, blue): RGBColor) -> RGBColor {
    let half = |channel: u8| u8::midpoint(channel, 255);
    RGBColor(half(red), half(green), half(blue))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(value: f64) -> Bar {
        Bar { value, range: [0.95 * value, 1.1 * value], pale: false }
    }

    fn bars() -> Bars {
        let row = |name: &str, values: [f64; 2]| (name.to_owned(), values.map(|v| Some(bar(v))).into());
        Bars {
            title: "title".into(),
            subtitle: "subtitle".into(),
            x_label: "ratio".into(),
            series: vec!["one".into(), "two".into()],
            rows: vec![
                row("cheap", [1.02, 1.1]),
                row("dear", [12.0, 3.0]),
                ("quick".into(), vec![Some(Bar { pale: true, ..bar(0.25) }), None]),
            ],
            pale: "instead".into(),
        }
    }

    /// Columns of the picture that have a colour.
    fn columns(picture: &drr::formats::ColourPicture, RGBColor(r, g, b): RGBColor) -> Vec<usize> {
        let has = |x: usize| (120..540).filter(|&y| picture.pixel(x, y) == [r, g, b]).count() > 5;
        (0..picture.width).filter(|&x| has(x)).collect()
    }

    #[test]
    fn bars_begin_at_one_and_end_at_their_values() {
        let bars = bars();
        let picture = bars.picture().unwrap();
        let plot = bars.plot(100);
        let blue = columns(&picture, BLUE);
        assert!((*blue.last().unwrap() as i32 - plot.column(12.0)).abs() <= 2);
        assert!((blue[0] as i32 - plot.column(1.0)).abs() <= 2);
        let pale = columns(&picture, paler(BLUE));
        assert!((pale[0] as i32 - plot.column(0.25)).abs() <= 2);
        assert!((*pale.last().unwrap() as i32 - plot.column(1.0)).abs() <= 2);
    }

    #[test]
    fn texts_say_what_is_added() {
        let texts = [1.0, 1.023, 0.9, 2.04, 12.3].map(|v| text(bar(v)));
        assert_eq!(texts, ["+0 %", "+2 %", "\u{2212}10 %", "2.0\u{d7}", "12\u{d7}"]);
        assert_eq!(text(Bar { pale: true, ..bar(0.25) }), "0.25\u{d7}");
        let svg = bars().svg().unwrap();
        for word in ["cheap", "dear", "one", "two", "instead", "+10 %", "5\u{d7}"] {
            assert!(svg.contains(word), "{word}");
        }
    }

    #[test]
    fn no_rows_and_no_numbers_are_a_chart_too() {
        let none = Bars { rows: vec![], ..bars() };
        none.picture().unwrap();
        let lost = Bars { rows: vec![("lost".into(), vec![Some(bar(f64::NAN)), Some(bar(0.0))])], ..bars() };
        assert!(!lost.svg().unwrap().contains("NaN"));
    }
}
