//! Charts: error against time, curves, bars, contact sheets, and the colour bar of error maps.

mod axes;
mod bars;
mod canvas;
mod chart;
mod colour_bar;
mod contact_sheet;
mod curves;
mod decades;
mod drawing;
mod glyphs;
mod labels;
mod legend;
mod marker;
mod plot;
mod shapes;

pub(crate) use bars::{Bar, Bars};
pub(crate) use chart::{Chart, Group, Point};
pub(crate) use colour_bar::with_colour_bar;
pub(crate) use contact_sheet::{ContactSheet, Panel};
pub(crate) use curves::{Curves, Series};
pub(crate) use drawing::Drawing;

#[cfg(test)]
mod tests;
