//! Pictures of what accuracy costs in time.

mod axes;
mod canvas;
mod chart;
mod colour_bar;
mod curves;
mod decades;
mod drawing;
mod glyphs;
mod labels;
mod legend;
mod marker;
mod plot;
mod shapes;

#[cfg(test)]
mod tests;
