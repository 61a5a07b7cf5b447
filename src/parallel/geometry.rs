//! Volume, detector and steps of a parallel beam.

use glam::{DMat4, DVec3, DVec4};

use crate::error::{Error, Result};
use crate::geometry::{Grid, Projection, check_coordinates};
use crate::parallel::ViewParameters;
use crate::scene::MAX_DETECTOR;

/// Most steps of a ray.
pub const MAX_STEPS: usize = 1 << 20;

/// Smallest and largest distance of two voxels, pixels or steps, mm; the smallest is a grid's.
const MIN_PITCH: f64 = 1e-9;
const MAX_PITCH: f64 = 1e6;

/// Volume, detector and steps. Lengths in mm.
///
/// Voxel (i, j, k) is stored at `(k*ny + j)*nx + i` and has its centre at `centre + ((i, j, k) − (n − 1)/2)·spacing`. Pixel
/// (u, v) of an image is stored at `v*nu + u` and sees x = `detector_centre[0] + (u − (nu − 1)/2)·du`, z likewise from v.
/// Step k is at y = `centre.y + (k − (steps − 1)/2)·step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParallelGeometry {
    /// nx, ny, nz.
    pub dimensions: [usize; 3],
    /// Distances of voxel centres.
    pub spacing: DVec3,
    /// The volume's centre, before it moves.
    pub centre: DVec3,
    /// nu, nv: columns and rows.
    pub detector: [usize; 2],
    /// du, dv: distances of pixel centres.
    pub pixel: [f64; 2],
    /// x and z of the detector's centre.
    pub detector_centre: [f64; 2],
    /// Δs, from one sample to the next.
    pub step: f64,
    /// Samples of a ray.
    pub steps: usize,
}

impl ParallelGeometry {
    /// Volume and detector centred on the origin; steps of one voxel's height along y, over the whole volume, as the document
    /// has them.
    pub fn new(dimensions: [usize; 3], spacing: DVec3, detector: [usize; 2], pixel: [f64; 2]) -> Self {
        let centre = DVec3::ZERO;
        let (step, steps) = (spacing.y, dimensions[1]);
        Self { dimensions, spacing, centre, detector, pixel, detector_centre: [0.0; 2], step, steps }
    }

    /// Steps of this size over the volume's extent along y: ⌈ny·vy/step⌉ of them.
    #[must_use]
    pub fn with_step(self, step: f64) -> Self {
        let steps = (self.dimensions[1] as f64 * self.spacing.y / step).ceil();
        Self { step, steps: steps as usize, ..self }
    }

    /// # Errors
    /// `InvalidArgument` with the field that is not valid.
    pub fn validate(&self) -> Result<()> {
        self.grid()?;
        for (axis, n) in ["columns", "rows"].into_iter().zip(self.detector) {
            if n == 0 || n > MAX_DETECTOR {
                return Err(Error::invalid(
                    format!("detector {axis}"),
                    n,
                    format!("1 … {MAX_DETECTOR} pixels"),
                ));
            }
        }
        let [du, dv] = self.pixel;
        for (name, length) in [("pixel[0]", du), ("pixel[1]", dv), ("step", self.step)] {
            if !(MIN_PITCH..=MAX_PITCH).contains(&length) {
                return Err(Error::invalid(name, length, format!("{MIN_PITCH:e} … {MAX_PITCH:e} mm")));
            }
        }
        let [x, z] = self.detector_centre;
        check_coordinates("detector_centre", DVec3::new(x, 0.0, z))?;
        if self.steps == 0 || self.steps > MAX_STEPS {
            return Err(Error::invalid("steps", self.steps, format!("1 … {MAX_STEPS}")));
        }
        Ok(())
    }

    /// The voxel grid, before it moves.
    ///
    /// # Errors
    /// As [`Grid::new`]; spacings must be from 1e-9 to 1e6 mm.
    pub fn grid(&self) -> Result<Grid> {
        for (axis, &spacing) in self.spacing.to_array().iter().enumerate() {
            if !(MIN_PITCH..=MAX_PITCH).contains(&spacing) {
                let valid = format!("{MIN_PITCH:e} … {MAX_PITCH:e} mm");
                return Err(Error::invalid(format!("spacing[{axis}]"), spacing, valid));
            }
        }
        check_coordinates("centre", self.centre)?;
        let last = DVec3::from_array(self.dimensions.map(|n| n as f64 - 1.0));
        Grid::axis_aligned(self.dimensions, self.spacing, self.centre - 0.5 * last * self.spacing)
    }

    /// Number of pixels of an image.
    pub fn pixels(&self) -> usize {
        self.detector[0] * self.detector[1]
    }

    /// World position of pixel (u, v) at y = 0.
    pub fn pixel_position(&self, u: f64, v: f64) -> DVec3 {
        let at = |axis: usize, index: f64| {
            self.detector_centre[axis] + (index - 0.5 * (self.detector[axis] as f64 - 1.0)) * self.pixel[axis]
        };
        DVec3::new(at(0, u), 0.0, at(1, v))
    }

    /// y of step k, fractional steps too.
    pub fn step_position(&self, k: f64) -> f64 {
        self.centre.y + (k - 0.5 * (self.steps as f64 - 1.0)) * self.step
    }

    /// The same rays as a parallel projection of the volume that stays, for other algorithms: full lines.
    pub fn projection(&self, parameters: &ViewParameters) -> Projection {
        let motion = parameters.motion();
        let forward = motion.rotation();
        // World x and z of an object's point, then columns and rows: −1 … 1 over the detector, y downwards.
        let row = |axis: usize, at: usize, sign: f64| {
            let extent = 0.5 * self.detector[at] as f64 * self.pixel[at];
            let linear = sign / extent * forward.row(axis);
            linear.extend(sign / extent * (motion.translation[axis] - self.detector_centre[at]))
        };
        let (x, y) = (row(0, 0, 1.0), row(2, 1, -1.0));
        let depth = forward.row(1).extend(0.0);
        let matrix = DMat4::from_cols(x, y, depth, DVec4::W).transpose();
        Projection { matrix, source: DVec3::ZERO }
    }
}
