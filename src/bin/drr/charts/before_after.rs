//! What is left of given images before and after a fit.

use anyhow::Result;
use drr::formats::{ColourPicture, error_map, radiograph};
use drr::geometry::PatientOrientation;

use super::colour_bar::with_colour_bar;
use super::colour_range::colour_range;
use super::contact_sheet::{ContactSheet, Panel};
use super::nearest::nearest;
use super::sides::mark_sides;
use crate::rms::rmse;

/// Columns and rows of a panel, at most.
const PANEL: f64 = 240.0;

/// A given image with its projections.
pub(crate) struct Compared<'a> {
    pub(crate) caption: String,
    /// Line integrals, row by row, of `size` pixels.
    pub(crate) given: &'a [f32],
    /// Before and after.
    pub(crate) projected: [&'a [f32]; 2],
    /// Columns and rows.
    pub(crate) size: [usize; 2],
    /// Distances of columns and rows, mm.
    pub(crate) pixel: [f64; 2],
    /// Whether the head is at the last row.
    pub(crate) head_last: bool,
    /// Where the sides lie in the patient when the head is up.
    pub(crate) upright: PatientOrientation,
}

/// Three panels per image: as it is given, and given − projected before and after.
pub(crate) struct BeforeAfter<'a> {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    /// What the given images are.
    pub(crate) given: &'static str,
    pub(crate) views: Vec<Compared<'a>>,
}

impl BeforeAfter<'_> {
    /// All of it, with the colour bar of its differences, whose range is that of those before.
    pub(crate) fn picture(&self) -> Result<ColourPicture> {
        let before: Vec<f32> = self.views.iter().flat_map(|view| view.left(0)).collect();
        let range = colour_range(&before).unwrap_or(1.0);
        let mut panels = Vec::new();
        for (n, view) in self.views.iter().enumerate() {
            let ([width, height], image) = view.shown(view.given);
            let (name, caption) = (format!("view {n}, {}", self.given), view.caption.clone());
            let mut picture = radiograph(&[&image], width, height)?.to_colour();
            mark_sides(&mut picture, [0, 0], [width, height], view.upright)?;
            panels.push(Panel { name, caption, picture });
            for (k, name) in ["before", "after"].into_iter().enumerate() {
                let ([width, height], left) = view.shown(&view.left(k));
                let caption = format!("RMS {:.4}", rmse(view.given, view.projected[k]));
                let picture = error_map(&[&left], width, height, range)?;
                panels.push(Panel { name: name.into(), caption, picture });
            }
        }
        let sheet = ContactSheet { title: self.title.clone(), subtitle: self.subtitle.clone(), panels };
        with_colour_bar(&sheet.picture()?, range, "")
    }
}

impl Compared<'_> {
    /// Given − projected.
    fn left(&self, k: usize) -> Vec<f32> {
        self.given.iter().zip(self.projected[k]).map(|(given, projected)| given - projected).collect()
    }

    /// An image with the head up, square pixels, and no more of them than a panel has: the nearest of each; its size
    /// before.
    fn shown(&self, image: &[f32]) -> ([usize; 2], Vec<f32>) {
        let ([columns, rows], [du, dv]) = (self.size, self.pixel);
        let extent = [columns as f64 * du, rows as f64 * dv];
        let scale = PANEL / extent[0].max(extent[1]);
        let [width, height] = extent.map(|mm| ((mm * scale).round() as usize).max(1));
        let pixel = |n: usize| {
            let (column, row) = (n % width, n / width);
            let row = if self.head_last { height - 1 - row } else { row };
            image[nearest(row, height, rows) * columns + nearest(column, width, columns)]
        };
        ([width, height], (0..width * height).map(pixel).collect())
    }
}

#[cfg(test)]
mod tests {
    use drr::geometry::DetectorPose;
    use glam::DVec3;

    use super::*;

    #[test]
    fn pixels_are_square_and_the_head_is_up() {
        // Two columns, three rows; the last is the head's.
        let image = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let view = |head_last| Compared {
            caption: String::new(),
            given: &image,
            projected: [&[1.0; 6], &[0.0; 6]],
            size: [2, 3],
            pixel: [3.0, 1.0],
            head_last,
            upright: PatientOrientation::of(&DetectorPose::c_arm(DVec3::ZERO, 0.0, 1.0, 2.0, 1.0, [2, 3])),
        };
        let (size, shown) = view(true).shown(&image);
        assert_eq!(size, [240, 120]);
        assert_eq!([0, 239, 119 * 240, 120 * 240 - 1].map(|n| shown[n]), [4.0, 5.0, 0.0, 1.0]);
        assert_eq!(view(false).shown(&image).1[..2], [0.0; 2]);
        assert_eq!(view(true).left(0), [-1.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
    }
}
