//! What was reconstructed, as a picture.

use std::path::Path;

use anyhow::Result;
use drr::formats::ColourPicture;
use drr::geometry::Grid;

use super::slices::Slices;
use crate::charts::{ContactSheet, Panel, colour_range, with_colour_bar};

/// Columns of a slice.
const WIDTH: usize = 288;
/// The window of greys ends where this part of the voxels with matter is brighter.
const BEYOND: f64 = 0.005;

/// A volume with its name.
pub(crate) struct Shown<'a> {
    pub(crate) name: String,
    pub(crate) caption: String,
    /// HU.
    pub(crate) values: &'a [f32],
}

/// Volumes beside each other, and errors of some of them against the truth.
pub(crate) struct Picture<'a> {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) grid: &'a Grid,
    pub(crate) volumes: Vec<Shown<'a>>,
    /// HU, with their names.
    pub(crate) errors: Vec<Shown<'a>>,
}

impl Picture<'_> {
    /// Writes it.
    pub(crate) fn write(&self, path: &Path) -> Result<()> {
        let slices = Slices::new(self.grid, WIDTH);
        // The first one's: the truth, where it is known.
        let window = window(self.volumes.first().map_or(&[], |shown| shown.values));
        let panel = |shown: &Shown<'_>, picture: ColourPicture| Panel {
            name: shown.name.clone(),
            caption: shown.caption.clone(),
            picture,
        };
        let mut panels = Vec::new();
        for shown in &self.volumes {
            panels.push(panel(shown, slices.grey(shown.values, window)?));
        }
        let all: Vec<f32> = self.errors.iter().flat_map(|shown| shown.values.iter().copied()).collect();
        let range = colour_range(&all).unwrap_or(1.0);
        for shown in &self.errors {
            panels.push(panel(shown, with_colour_bar(&slices.error(shown.values, range)?, range, "HU")?));
        }
        let sheet = ContactSheet {
            title: self.title.clone(),
            subtitle: format!("{} Greys from {:.0} to {:.0} HU.", self.subtitle, window[0], window[1]),
            panels,
        };
        Ok(sheet.picture()?.write_png(path)?)
    }
}

/// From vacuum to what few voxels are brighter than.
fn window(values: &[f32]) -> [f64; 2] {
    let mut dense: Vec<f32> = values.iter().copied().filter(|hu| *hu > -500.0).collect();
    let rank = ((1.0 - BEYOND) * dense.len().saturating_sub(1) as f64) as usize;
    let most = if dense.is_empty() { 0.0 } else { *dense.select_nth_unstable_by(rank, f32::total_cmp).1 };
    [-1000.0, f64::from(most).max(-900.0)]
}
