//! A volume in several sizes of voxels, from coarse to fine.

use crate::alignment::BlockMeans;
use crate::allocation::reserved;
use crate::context::Context;
use crate::error::Result;
use crate::levenberg_marquardt::{MAX_LEVELS, check_levels};
use crate::parallel::{ParallelGeometry, ParallelProjector, Quadrature, RaySelection};
use crate::real::Real;

/// Projectors of one volume, each with voxels and pixels twice as large as the next one's, as means of blocks: what is far
/// off is found on the coarse ones, where the loss has one valley. An axis that is one voxel or pixel long stays.
pub struct Pyramid<T> {
    /// The coarsest first. The finest has no blocks.
    levels: Vec<Level<T>>,
}

struct Level<T> {
    projector: ParallelProjector<T>,
    /// Of the finest level.
    means: Option<BlockMeans>,
}

/// A measured image on one level.
pub(super) struct Measured<'a, T> {
    pub projector: &'a ParallelProjector<T>,
    image: Option<Vec<T>>,
    mask: Option<Vec<bool>>,
    fine: (&'a [T], Option<&'a [bool]>),
}

impl<T: Real> Pyramid<T> {
    /// So many levels of a volume, the finest included.
    ///
    /// # Errors
    /// As [`ParallelProjector::new`]; `InvalidArgument` for no level and for more than [`MAX_LEVELS`].
    pub fn new(
        context: &Context,
        geometry: ParallelGeometry,
        quadrature: Quadrature,
        volume: &[T],
        levels: usize,
    ) -> Result<Self> {
        check_levels(levels, MAX_LEVELS, "")?;
        let mut made = reserved(levels, "the levels")?;
        for level in (1..levels).rev() {
            let block = |n: usize| (1 << level).min(n);
            let means =
                BlockMeans::new(geometry, geometry.dimensions.map(block), geometry.detector.map(block))?;
            let coarse = context.install(|| means.volume(volume))?;
            let projector = ParallelProjector::new(context, *means.geometry(), quadrature, &coarse)?;
            made.push(Level { projector, means: Some(means) });
        }
        let projector = ParallelProjector::new(context, geometry, quadrature, volume)?;
        made.push(Level { projector, means: None });
        Ok(Self { levels: made })
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// The finest level's projector, of the volume itself.
    ///
    /// # Panics
    /// Never: there is always one.
    pub fn finest(&self) -> &ParallelProjector<T> {
        &self.levels[self.levels.len() - 1].projector
    }

    /// A measured image, and which of its pixels count, on each level; levels on which none does are left out.
    pub(super) fn measured<'a>(
        &'a self,
        image: &'a [T],
        mask: Option<&'a [bool]>,
    ) -> Result<Vec<Measured<'a, T>>> {
        let rays = RaySelection { mask, ..RaySelection::default() };
        rays.validate(self.finest().geometry())?;
        self.finest().check_measured(image, rays)?;
        let mut measured = reserved(self.levels.len(), "the levels")?;
        for Level { projector, means } in &self.levels {
            let coarse_mask = match (means, mask) {
                (Some(means), Some(mask)) => Some(means.mask(mask)?),
                _ => None,
            };
            if coarse_mask.as_ref().is_some_and(|mask| !mask.contains(&true)) {
                continue;
            }
            let coarse = means.as_ref().map(|means| means.image(image)).transpose()?;
            measured.push(Measured { projector, image: coarse, mask: coarse_mask, fine: (image, mask) });
        }
        Ok(measured)
    }
}

impl<T> Measured<'_, T> {
    /// The image.
    pub(super) fn image(&self) -> &[T] {
        self.image.as_deref().unwrap_or(self.fine.0)
    }

    /// Which pixels count.
    pub(super) fn rays(&self) -> RaySelection<'_> {
        let fine = if self.image.is_none() { self.fine.1 } else { None };
        RaySelection { mask: self.mask.as_deref().or(fine), lengths: None }
    }

    /// Whether a pixel counts.
    pub(super) fn counts(&self, pixel: usize) -> bool {
        self.rays().mask.is_none_or(|mask| mask[pixel])
    }
}
