//! Slices of a volume through its centre, as a picture.

use anyhow::Result;
use drr::formats::{ColourPicture, Rgb, error_colour};
use drr::geometry::{AnatomicalDirection, Grid, PatientOrientation};
use glam::DVec3;

use crate::charts::{mark_sides, nearest};

/// Between slices, pixels.
const GAP: usize = 6;
const BACKGROUND: Rgb = [255, 255, 255];

/// Axial, coronal and sagittal slices under each other, the head up, of a grid whose axes are about those of the world.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slices {
    grid: Grid,
    /// Size of a square pixel, mm.
    pixel_mm: f64,
    width: usize,
}

/// What a slice shows: the axes of its columns and rows, and whether rows go down.
const PLANES: [(usize, usize, bool); 3] = [(0, 1, true), (0, 2, false), (1, 2, false)];

impl Slices {
    /// The widest slice has so many columns.
    pub(crate) fn new(grid: &Grid, width: usize) -> Self {
        let size = size_mm(grid);
        Self { grid: *grid, pixel_mm: size.x.max(size.y) / width as f64, width }
    }

    /// Values from black to white.
    pub(crate) fn grey(&self, values: &[f32], [black, white]: [f64; 2]) -> Result<ColourPicture> {
        self.shaded(values, |value| {
            let fraction = ((f64::from(value) - black) / (white - black)).clamp(0.0, 1.0);
            [(255.0 * fraction).round() as u8; 3]
        })
    }

    /// Errors, blue where too low, red where too high.
    pub(crate) fn error(&self, values: &[f32], range: f64) -> Result<ColourPicture> {
        self.shaded(values, |value| error_colour(f64::from(value) / range))
    }

    fn shaded(&self, values: &[f32], shade: impl Fn(f32) -> Rgb) -> Result<ColourPicture> {
        let size = size_mm(&self.grid);
        let pixels = |axis: usize| ((size[axis] / self.pixel_mm).round() as usize).max(1);
        let heights = PLANES.map(|(_, row, _)| pixels(row));
        let height = heights.iter().sum::<usize>() + 2 * GAP;
        let mut picture = ColourPicture::filled(self.width, height, BACKGROUND);
        let mut top = 0;
        for ((across, down, downwards), height) in PLANES.into_iter().zip(heights) {
            let width = pixels(across).min(self.width);
            let left = (self.width - width) / 2;
            for (y, line) in picture.pixels.chunks_exact_mut(self.width).skip(top).take(height).enumerate() {
                let y = if downwards { y } else { height - 1 - y };
                for (x, pixel) in line[left..left + width].iter_mut().enumerate() {
                    let mut index = self.grid.dimensions().map(|n| n / 2);
                    index[across] = nearest(x, width, self.grid.dimensions()[across]);
                    index[down] = nearest(y, height, self.grid.dimensions()[down]);
                    *pixel = shade(values[self.flat(index)]);
                }
            }
            mark_sides(
                &mut picture,
                [left, top],
                [width, height],
                self.orientation([across, down], downwards),
            )?;
            top += height + GAP;
        }
        Ok(picture)
    }

    /// Where the sides of a slice lie in the patient.
    fn orientation(&self, [across, down]: [usize; 2], downwards: bool) -> PatientOrientation {
        let matrix = self.grid.index_to_world().matrix3;
        let along = |axis: usize| AnatomicalDirection::of(matrix.col(axis) * matrix.col(axis)[axis].signum());
        let shown = PatientOrientation { row: along(across), column: along(down) };
        if downwards { shown } else { shown.upside_down() }
    }

    /// Where the voxel is; axes that run against the world's are turned round.
    fn flat(&self, index: [usize; 3]) -> usize {
        let ([n0, n1, _], matrix) = (self.grid.dimensions(), self.grid.index_to_world().matrix3);
        let [i, j, k] = std::array::from_fn(|axis| {
            let last = self.grid.dimensions()[axis] - 1;
            if matrix.col(axis)[axis] < 0.0 { last - index[axis] } else { index[axis] }
        });
        (k * n1 + j) * n0 + i
    }
}

fn size_mm(grid: &Grid) -> DVec3 {
    grid.spacing() * DVec3::from_array(grid.dimensions().map(|n| n as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_show_the_middle_with_the_head_up() {
        let grid = Grid::centred([4, 2, 6], DVec3::new(1.0, 2.0, 0.5)).unwrap();
        // Bright where z is large and x is large.
        let at = |n: usize| if n / 8 >= 3 && n % 4 >= 2 { 1.0 } else { 0.0 };
        let values: Vec<f32> = (0..48).map(at).collect();
        let picture = Slices::new(&grid, 40).grey(&values, [0.0, 1.0]).unwrap();
        assert_eq!((picture.width, picture.height), (40, 40 + 30 + 30 + 2 * GAP));
        let coronal = 40 + GAP;
        let bright = |x, y| picture.pixel(x, coronal + y) == [255; 3];
        assert!(bright(30, 5) && !bright(10, 5) && !bright(30, 25) && !bright(10, 25));
        // The sagittal one is at x = n/2, where all of the upper half is bright.
        let sagittal = coronal + 30 + GAP;
        assert!((0..40).all(|x| picture.pixel(x, sagittal) == [255; 3]));
    }

    #[test]
    fn a_mirrored_grid_shows_the_same() {
        let grid = Grid::centred([4, 4, 4], DVec3::ONE).unwrap();
        let mirrored = Grid::centred([4, 4, 4], DVec3::new(1.0, 1.0, -1.0)).unwrap();
        let values: Vec<f32> = (0..64).map(|n| n as f32).collect();
        let turned: Vec<f32> = (0..64).map(|n| ((3 - n / 16) * 16 + n % 16) as f32).collect();
        let shown = |grid, values: &[f32]| Slices::new(grid, 16).grey(values, [0.0, 64.0]).unwrap();
        let (own, other) = (shown(&grid, &values), shown(&mirrored, &turned));
        // Slices through the middle are the next one where the order is turned round.
        assert_eq!(own.pixels[40 * 16..], other.pixels[40 * 16..]);
    }

    #[test]
    fn slices_say_which_side_is_which_however_the_grid_runs() {
        for spacing in [DVec3::ONE, DVec3::new(-1.0, 1.0, -1.0)] {
            let slices = Slices::new(&Grid::centred([4, 4, 4], spacing).unwrap(), 16);
            let own = PLANES.map(|(a, b, downwards)| slices.orientation([a, b], downwards).to_string());
            assert_eq!(own, [r"L\P", r"L\F", r"P\F"]);
        }
    }
}
