//! Line integrals of a scalar volume in any view, and the adjoint that belongs to them: what iterative reconstruction needs.
//!
//! A [`RayTransform`] is the matrix A whose row for a pixel holds the weights with which voxels count along the ray to that
//! pixel, in mm: `forward` is A x, a set of images, and `adjoint` is Aᵀ b, the back-projection. The matrix is never stored.
//! Both go through the same weights, so that the adjoint is the transpose for every [`Algorithm`], not another
//! discretisation of it, and iterative methods that need the transpose converge as their theory says.

mod adjoint;
mod forward;
mod line;
mod slab;
mod weights;

use std::marker::PhantomData;

use rayon::prelude::*;

use crate::allocation::{filled, reserved};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::{Grid, View};
use crate::linear_operator::LinearOperator;
use crate::method::Algorithm;
use crate::ray_transform::line::Line;
use crate::raycast::{Beam, Footprint};
use crate::real::Real;
use crate::scene::MAX_DETECTOR;
use crate::values::{check_count, check_finite};

/// The linear map from a volume to its line integrals in several views: float32, or its twin in float64. Immutable: may be
/// used from many threads at once.
///
/// A volume has one value per voxel of the grid, x fastest, for instance attenuation in 1/mm; images have one value per
/// pixel, `(view*height + j)*width + i`, in mm times the volume's unit. The volume is the box [−½, n−½) of index space;
/// between voxel centres it is interpolated as the algorithm says, and in the outer half voxel the edge value holds. The
/// weights of a ray sum to its length inside the box. `adjoint` takes the memory of one volume beside its result.
///
/// ```
/// use drr::engine::Backend;
/// use drr::geometry::{DetectorPose, Grid, View};
/// use drr::{Algorithm, Context, LinearOperator, RayTransform};
///
/// // A cube of 40 mm, attenuation 0.02/mm, seen from two sides.
/// let grid = Grid::centred([20, 20, 20], glam::DVec3::splat(2.0))?;
/// let views = [0.0, 90.0].map(|angle| {
///     View::Pose(DetectorPose::c_arm(grid.centre(), angle, 1000.0, 1500.0, 2.0, [32, 32]))
/// });
/// let context = Context::new(Backend::Cpu, 0)?;
/// let transform = RayTransform::<f32>::new(&context, grid, &views, [32, 32], Algorithm::Joseph)?;
/// let images = transform.forward(&[0.02; 20 * 20 * 20])?;
/// assert!((images[16 * 32 + 16] - 0.8).abs() < 1e-3);
/// let back = transform.adjoint(&images)?;
/// assert_eq!(back.len(), 20 * 20 * 20);
/// # drr::Result::Ok(())
/// ```
#[derive(Clone)]
pub struct RayTransform<T> {
    context: Context,
    grid: Grid,
    size: [usize; 2],
    algorithm: Algorithm,
    beams: Vec<Beam>,
    /// Whether a view has rays that cross the volume with this driving axis.
    drives: Vec<[bool; 3]>,
    real: PhantomData<T>,
}

impl<T: Real> RayTransform<T> {
    /// The line integrals of volumes on `grid` in these views, on a detector of `size` = width × height pixels, one ray per
    /// pixel centre, or with [`Algorithm::DistanceDriven`] the pixel around it. Runs on the context's threads.
    ///
    /// # Errors
    /// `InvalidArgument` without views, for a view that is not valid (its argument begins with `views[k]`), a size of 0 or
    /// above [`MAX_DETECTOR`], and parameters of the algorithm that are out of range; `OutOfMemory`.
    pub fn new(
        context: &Context,
        grid: Grid,
        views: &[View],
        size: [usize; 2],
        algorithm: Algorithm,
    ) -> Result<Self> {
        algorithm.validate().map_err(|error| error.called("scene.step_voxels", "algorithm.step"))?;
        for (name, n) in ["size[0]", "size[1]"].into_iter().zip(size) {
            if n == 0 || n > MAX_DETECTOR {
                return Err(Error::invalid(name, n, format!("1 … {MAX_DETECTOR} pixels")));
            }
        }
        if views.is_empty() {
            return Err(Error::invalid("number of views", 0, "at least 1"));
        }
        let mut beams = reserved(views.len(), "the views")?;
        for (k, view) in views.iter().enumerate() {
            beams.push(Beam::new(view, &grid, size).map_err(|error| error.of(&format!("views[{k}]")))?);
        }
        let drives = filled(views.len(), [false; 3], "the views")?;
        let mut transform =
            Self { context: context.clone(), grid, size, algorithm, beams, drives, real: PhantomData };
        transform.drives = context.install(|| transform.driving_axes(transform.drives.clone()));
        Ok(transform)
    }

    /// The grid of the volumes.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Number of views.
    pub fn views(&self) -> usize {
        self.beams.len()
    }

    /// Pixels of an image, width × height.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// How the integral along a ray is taken.
    pub fn algorithm(&self) -> Algorithm {
        self.algorithm
    }

    /// The ray of a pixel inside the volume, pixels counted over all views; `None` when it misses.
    fn line(&self, pixel: usize) -> Option<Line> {
        let [width, height] = self.size;
        let (row, i) = (pixel / width, pixel % width);
        let (view, j) = (row / height, row % height);
        let (beam, column, row) = (&self.beams[view], i as f64, j as f64);
        let ray = beam.ray(column, row);
        // Only distance-driven weights look at it.
        let footprint = match self.algorithm {
            Algorithm::DistanceDriven => beam.footprint(column, row),
            _ => Footprint::POINT,
        };
        Line::new(ray, footprint, self.grid.dimensions())
    }

    fn driving_axes(&self, mut drives: Vec<[bool; 3]>) -> Vec<[bool; 3]> {
        let pixels = self.size[0] * self.size[1];
        drives.par_iter_mut().enumerate().for_each(|(view, drives)| {
            for line in (view * pixels..(view + 1) * pixels).filter_map(|pixel| self.line(pixel)) {
                drives[line.ray.axis] = true;
            }
        });
        drives
    }
}

impl<T: Real> LinearOperator<T> for RayTransform<T> {
    fn domain(&self) -> usize {
        self.grid.voxel_count()
    }

    fn range(&self) -> usize {
        self.beams.len() * self.size[0] * self.size[1]
    }

    fn forward(&self, volume: &[T]) -> Result<Vec<T>> {
        check_count("volume", volume.len(), self.domain(), "voxel")?;
        check_finite("volume", volume)?;
        let mut images = filled(self.range(), T::default(), "the images")?;
        self.context.install(|| self.project(volume, &mut images));
        Ok(images)
    }

    fn adjoint(&self, images: &[T]) -> Result<Vec<T>> {
        check_count("images", images.len(), self.range(), "pixel")?;
        check_finite("images", images)?;
        let mut volume = filled(self.domain(), T::default(), "the volume")?;
        self.context.install(|| self.back_project(images, &mut volume))?;
        Ok(volume)
    }
}

#[cfg(test)]
mod tests;
