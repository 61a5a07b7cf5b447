//! Projects a volume that moves, with derivatives.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::allocation::{filled, reserved};
use crate::context::Context;
use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::geometry::{DetectorPose, RigidMotion, check_coordinates};
use crate::method::Algorithm;
use crate::normal_equations::NormalEquations;
use crate::plan::Plan;
use crate::pose_gradient::Signal;
use crate::pose_gradient::field::Field;
use crate::pose_gradient::moving_beam::MovingBeam;
use crate::pose_gradient::moving_ray::PARAMETERS;
use crate::pose_gradient::pixel::{PixelModel, PixelSignal};
use crate::real::Real;
use crate::scene::Scene;
use crate::values::{check_count, check_finite_where};
use crate::volume::Volume;

/// One volume before one detector: samples in float32, or in float64, its twin; sums and spectra are float64. Runs on the
/// context's CPU threads. Immutable: may be used from many threads at once.
pub struct PoseProjector<T> {
    context: Context,
    size: [usize; 2],
    pivot: DVec3,
    pixels: PixelModel<T>,
}

/// An image and its derivatives; pixel (i, j) is at `j*width + i`.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseJacobian<T> {
    /// The image.
    pub image: Vec<T>,
    /// ∂image/∂(α, β, φ, tx, ty, tz), per radian and per mm.
    pub derivatives: [Vec<T>; PARAMETERS],
}

impl<T: Real> PoseProjector<T> {
    /// A projector of `volume` on the scene's detector: its first layer's response, its spectrum, all energies of it, its
    /// materials, the algorithm of its method, its rays per pixel, whose intensities are averaged. Algorithm `exact` is slow;
    /// Siddon's derivative is exact for voxels of constant density but jumps from ray to ray, and is 0 along an axis.
    ///
    /// # Errors
    /// `InvalidArgument` for a scene that is not valid or does not fit the volume; `Unsupported` for effects, a second
    /// detector layer, a tolerance, distance-driven means, or a volume in a texture; `OutOfMemory`.
    pub fn new(context: &Context, volume: Arc<Volume>, scene: &Scene) -> Result<Self> {
        scene.validate()?;
        Plan::check_labels(scene.materials.names(), &volume)?;
        Backend::Cpu.check_reads(&volume)?;
        let lacks = |what: &str, instead: &str| {
            Err(Error::Unsupported(format!("derivatives by pose do not have {what}: {instead}")))
        };
        if scene.has_effects() {
            return lacks("effects or a second detector layer", "leave them out of the scene");
        }
        if scene.tolerance.is_some() {
            return lacks("a tolerance", "give the scene a method");
        }
        if scene.method.algorithm == Algorithm::DistanceDriven {
            return lacks("distance-driven means", "use joseph, march or exact");
        }
        let pivot = volume.grid().centre();
        let pixels = PixelModel {
            field: Field::new(volume)?,
            algorithm: scene.method.algorithm,
            spectral: scene.spectral_model()?,
            supersampling: scene.supersampling,
        };
        Ok(Self { context: context.clone(), size: scene.detector, pivot, pixels })
    }

    /// The same projector of an object that turns about another point, world mm; at first the grid's centre.
    ///
    /// # Errors
    /// `InvalidArgument` for a point that is not finite or beyond 1e10 mm.
    pub fn with_pivot(self, pivot: DVec3) -> Result<Self> {
        check_coordinates("pivot", pivot)?;
        Ok(Self { pivot, ..self })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The point that the object turns about, world mm.
    pub fn pivot(&self) -> DVec3 {
        self.pivot
    }

    /// The volume.
    pub fn volume(&self) -> &Arc<Volume> {
        self.pixels.field.volume()
    }

    /// The image of the object after `motion`.
    ///
    /// # Errors
    /// `InvalidArgument` for a view or a motion that is not valid; `OutOfMemory`.
    pub fn project(&self, view: &DetectorPose, motion: &RigidMotion, signal: Signal) -> Result<Vec<T>> {
        let beam = self.beam(view, motion)?;
        let mut image = filled(self.size[0] * self.size[1], T::default(), "the image")?;
        let row = |(j, row): (usize, &mut [T])| {
            for (i, value) in row.iter_mut().enumerate() {
                *value = T::of(self.pixels.signal(&beam, [i, j], signal).value);
            }
        };
        self.context.install(|| image.par_chunks_mut(self.size[0]).enumerate().for_each(row));
        Ok(image)
    }

    /// The image of the object after `motion`, and its derivatives with respect to the motion's six parameters.
    ///
    /// # Errors
    /// As [`PoseProjector::project`].
    pub fn jacobian(
        &self,
        view: &DetectorPose,
        motion: &RigidMotion,
        signal: Signal,
    ) -> Result<PoseJacobian<T>> {
        let beam = self.beam(view, motion)?;
        let [width, height] = self.size;
        let mut pixels = filled(width * height, PixelSignal::default(), "the Jacobian")?;
        let row = |(j, row): (usize, &mut [PixelSignal])| {
            for (i, pixel) in row.iter_mut().enumerate() {
                *pixel = self.pixels.signal(&beam, [i, j], signal);
            }
        };
        self.context.install(|| pixels.par_chunks_mut(width).enumerate().for_each(row));
        let mut image = reserved(pixels.len(), "the Jacobian")?;
        image.extend(pixels.iter().map(|pixel| T::of(pixel.value)));
        let mut derivatives = [const { Vec::new() }; PARAMETERS];
        for (k, plane) in derivatives.iter_mut().enumerate() {
            *plane = reserved(pixels.len(), "the Jacobian")?;
            plane.extend(pixels.iter().map(|pixel| T::of(pixel.derivatives[k])));
        }
        Ok(PoseJacobian { image, derivatives })
    }

    /// Half the sum of squares of image − `measured` over the pixels of `mask`, or all; its derivatives with respect to α, β,
    /// φ (radians) and t (mm); and `JᵀJ`: in one pass over the rays. The same bytes for any number of threads.
    ///
    /// # Errors
    /// As [`PoseProjector::project`]; also for an image or a mask of another size, a mask without a pixel, and measured values
    /// that count and are not finite.
    pub fn loss_value_and_grad(
        &self,
        view: &DetectorPose,
        motion: &RigidMotion,
        signal: Signal,
        measured: &[T],
        mask: Option<&[bool]>,
    ) -> Result<NormalEquations<PARAMETERS>> {
        self.check_measured(measured, mask)?;
        let beam = self.beam(view, motion)?;
        let [width, height] = self.size;
        let mut rows = filled(height, NormalEquations::default(), "the rows' sums")?;
        let row = |(j, equations): (usize, &mut NormalEquations<PARAMETERS>)| {
            for i in 0..width {
                let pixel = j * width + i;
                if mask.is_none_or(|mask| mask[pixel]) {
                    let PixelSignal { value, derivatives } = self.pixels.signal(&beam, [i, j], signal);
                    equations.add(value - measured[pixel].into(), &derivatives);
                }
            }
        };
        self.context.install(|| rows.par_iter_mut().enumerate().for_each(row));
        // In the order of rows, whatever thread made them.
        let mut sum = NormalEquations::default();
        for row in &rows {
            sum.merge(row);
        }
        Ok(sum)
    }

    fn beam(&self, view: &DetectorPose, motion: &RigidMotion) -> Result<MovingBeam> {
        MovingBeam::new(view, motion, self.pivot, self.volume().grid(), self.size)
    }

    /// # Errors
    /// As [`PoseProjector::loss_value_and_grad`], of what is measured.
    pub(crate) fn check_measured(&self, measured: &[T], mask: Option<&[bool]>) -> Result<()> {
        let pixels = self.size[0] * self.size[1];
        check_count("measured", measured.len(), pixels, "pixel")?;
        check_count("mask", mask.map_or(pixels, <[bool]>::len), pixels, "pixel")?;
        if mask.is_some_and(|mask| !mask.contains(&true)) {
            return Err(Error::invalid("mask", "empty", "at least one pixel that counts"));
        }
        check_finite_where("measured", measured, |pixel| mask.is_none_or(|mask| mask[pixel]))
    }
}

#[cfg(test)]
mod tests;
