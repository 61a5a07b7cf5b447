//! Charts: error against time, curves, bars, growth of times, contact sheets, the colour bar of error maps, and the
//! letters of the patient's sides.

mod axes;
mod axis;
mod bars;
mod before_after;
mod canvas;
mod chart;
mod colour_bar;
mod colour_range;
mod contact_sheet;
mod counts;
mod curves;
mod decades;
mod drawing;
mod glyphs;
mod growth;
mod labels;
mod legend;
mod marker;
mod nearest;
mod plot;
mod shapes;
mod sides;
mod thinned;

pub(crate) use bars::{Bar, Bars};
pub(crate) use before_after::{BeforeAfter, Compared};
pub(crate) use chart::{Chart, Group, Point};
pub(crate) use colour_bar::with_colour_bar;
pub(crate) use colour_range::colour_range;
pub(crate) use contact_sheet::{ContactSheet, Panel};
pub(crate) use curves::{Curves, Scale, Series};
pub(crate) use drawing::Drawing;
pub(crate) use growth::{Growth, GrowthSheet};
pub(crate) use nearest::nearest;
pub(crate) use sides::{mark_sides, mark_views};
pub(crate) use thinned::thinned;

#[cfg(test)]
mod tests;
