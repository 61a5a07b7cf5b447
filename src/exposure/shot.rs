//! One view of an exposure.

use glam::DVec3;
use rayon::prelude::*;

use crate::effects::{Beamline, FocalSpot, Plane};
use crate::engine::{Images, Passed};
use crate::error::{Error, Result};
use crate::exposure::{Sample, pose_of};
use crate::geometry::{DetectorPose, Grid, View};

/// What the rays of one view met.
pub(crate) struct Shot<T> {
    /// Which view it is: what decides its noise.
    pub(super) number: usize,
    /// Whose pixels are the rays.
    pub(super) view: View,
    /// Of the volume.
    pub(super) grid: Grid,
    /// Areal densities, and where there is bone its path; its views are the points of the focal spot.
    pub(super) images: Images<T>,
    /// The sums over energies, where the engine has taken them: then the images have only what else was needed.
    pub(super) passed: Option<Passed>,
    /// Each point's part of the photons.
    pub(super) parts: Vec<f64>,
}

impl<T: Sample> Shot<T> {
    /// Width and height, rays.
    pub(super) fn size(&self) -> [usize; 2] {
        self.images.size
    }

    /// Distance of neighbouring rays on the detector, mm along columns and rows.
    ///
    /// # Errors
    /// `InvalidArgument`, for `effect`, in a view given by a matrix.
    pub(super) fn pitch(&self, effect: &str) -> Result<[f64; 2]> {
        let pose = pose_of(&self.view, effect)?;
        Ok([pose.column_step, pose.row_step].map(DVec3::length))
    }

    /// Where source, volume and detector are.
    ///
    /// # Errors
    /// As [`Self::pitch`].
    pub(super) fn beamline(&self, effect: &str) -> Result<Beamline> {
        Ok(beamline(pose_of(&self.view, effect)?, &self.grid))
    }

    /// The areal density of a material, averaged over the focal spot.
    pub(super) fn areal_density(&self, material: usize) -> Result<Plane> {
        self.mean(|point| self.images.areal_density(point, material))
    }

    /// That of all materials together.
    pub(super) fn total_areal_density(&self) -> Result<Plane> {
        let mut total = Plane::filled(self.size(), 0.0)?;
        for material in 0..self.images.materials {
            total.add(&self.areal_density(material)?);
        }
        Ok(total)
    }

    /// The path through bone, averaged over the focal spot.
    pub(super) fn bone_path(&self) -> Result<Plane> {
        self.mean(|point| self.images.view(&self.images.bone_path, point))
    }

    fn mean<'a>(&self, plane: impl Fn(usize) -> &'a [T]) -> Result<Plane>
    where
        T: 'a,
    {
        let mut mean = Plane::filled(self.size(), 0.0)?;
        for (point, part) in self.parts.iter().enumerate() {
            let values = mean.values_mut().par_iter_mut().zip(plane(point));
            values.for_each(|(sum, &value)| *sum += part * value.into());
        }
        Ok(mean)
    }
}

/// Source, volume's centre and detector of a view on the detector's normal.
pub(crate) fn beamline(pose: &DetectorPose, grid: &Grid) -> Beamline {
    let normal = pose.column_step.cross(pose.row_step).normalize();
    let to_detector = normal.dot(pose.first_pixel - pose.source);
    Beamline {
        source_centre_mm: normal.dot(grid.centre() - pose.source) * to_detector.signum(),
        source_detector_mm: to_detector.abs(),
    }
}

/// The widest shadow's edge that a focal spot makes of a volume, pixels along columns and rows: that of the corner nearest to
/// the source.
pub(crate) fn penumbra(spot: &FocalSpot, view: &View, grid: &Grid) -> Result<[f64; 2]> {
    let pose = pose_of(view, "scene.effects.focal_spot")?;
    let normal = pose.column_step.cross(pose.row_step).normalize();
    let detector = normal.dot(pose.first_pixel - pose.source);
    let last = grid.dimensions().map(|n| n as f64 - 0.5);
    let corner = |n: usize| {
        let index = [0, 1, 2].map(|axis| if n >> axis & 1 == 0 { -0.5 } else { last[axis] });
        let world = grid.index_to_world().transform_point3(DVec3::from_array(index));
        normal.dot(world - pose.source) * detector.signum()
    };
    let nearest = (0..8).map(corner).fold(f64::INFINITY, f64::min);
    if !(nearest > 0.0) {
        let valid = "only with the whole volume in front of the source: beside it a penumbra has no end";
        return Err(Error::invalid("scene.effects.focal_spot", "asked for", valid));
    }
    let blur = spot.blur_mm(detector.abs(), nearest.min(detector.abs()));
    Ok([blur[0] / pose.column_step.length(), blur[1] / pose.row_step.length()])
}
