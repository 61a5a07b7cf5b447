//! A point source and a flat detector.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::geometry::{Grid, check_coordinates};

/// A point source and a flat detector, in world mm. Pixel (i, j), i = column, has its centre at
/// `first_pixel + i*column_step + j*row_step`. Rays are the *segments* from the source to the pixel centres: what
/// lies behind a pixel does not count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectorPose {
    /// The source.
    pub source: DVec3,
    /// Centre of pixel (0, 0).
    pub first_pixel: DVec3,
    /// From the centre of pixel (0, 0) to the centre of pixel (1, 0).
    pub column_step: DVec3,
    /// From the centre of pixel (0, 0) to the centre of pixel (0, 1).
    pub row_step: DVec3,
}

impl DetectorPose {
    /// Checks that all numbers are finite, the pixel steps are independent, and the source is off the detector plane.
    pub fn validate(&self) -> Result<()> {
        for (name, v) in [
            ("source", self.source),
            ("first_pixel", self.first_pixel),
            ("column_step", self.column_step),
            ("row_step", self.row_step),
        ] {
            check_coordinates(name, v)?;
        }
        let normal = self.column_step.cross(self.row_step);
        let area = self.column_step.length() * self.row_step.length();
        if !(normal.length() >= 1e-6 * area) || area == 0.0 {
            let steps = format!("{} and {}", self.column_step, self.row_step);
            return Err(Error::invalid("column_step and row_step", steps, "two independent vectors, mm"));
        }
        let offset = self.first_pixel - self.source;
        if !(normal.dot(offset).abs() >= 1e-9 * normal.length() * offset.length()) || offset.length() == 0.0 {
            return Err(Error::invalid("source", self.source, "a point off the detector's plane"));
        }
        Ok(())
    }

    /// The specification's C-arm about `centre`: at angle 0 the source is at −y, columns along +x, rows along +z;
    /// `angle_degrees` turns source and detector about the z axis. `sad_mm` is source to axis, `sdd_mm` source to
    /// detector, `pixel_mm` the pitch; the detector of `width × height` pixels is centred on the central ray.
    pub fn c_arm(
        centre: DVec3,
        angle_degrees: f64,
        sad_mm: f64,
        sdd_mm: f64,
        pixel_mm: f64,
        [width, height]: [usize; 2],
    ) -> Self {
        let (sin, cos) = angle_degrees.to_radians().sin_cos();
        let axis = DVec3::new(-sin, cos, 0.0);
        let column_step = pixel_mm * DVec3::new(cos, sin, 0.0);
        let row_step = pixel_mm * DVec3::Z;
        let half = |n: usize| (n as f64 - 1.0) / 2.0;
        let middle = centre + (sdd_mm - sad_mm) * axis;
        Self {
            source: centre - sad_mm * axis,
            first_pixel: middle - half(width) * column_step - half(height) * row_step,
            column_step,
            row_step,
        }
    }

    /// The stereo pair of the main job: `c_arm` at −6° and +6° about the grid's centre.
    pub fn stereo_pair(grid: &Grid, sad_mm: f64, sdd_mm: f64, pixel_mm: f64, size: [usize; 2]) -> [Self; 2] {
        [-6.0, 6.0].map(|angle| Self::c_arm(grid.centre(), angle, sad_mm, sdd_mm, pixel_mm, size))
    }

    /// Centre of pixel (column, row), which may be fractional, in world mm.
    pub fn pixel(&self, column: f64, row: f64) -> DVec3 {
        self.first_pixel + column * self.column_step + row * self.row_step
    }

    /// The detector whose pixels are `block`×`block` of this one's.
    #[must_use]
    pub(crate) fn of_blocks(&self, block: usize) -> Self {
        let middle = 0.5 * (block as f64 - 1.0);
        Self {
            source: self.source,
            first_pixel: self.pixel(middle, middle),
            column_step: block as f64 * self.column_step,
            row_step: block as f64 * self.row_step,
        }
    }
}
