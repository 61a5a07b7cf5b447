//! A volume and its views in several sizes of voxels and pixels, from coarse to fine.

use std::sync::Arc;

use glam::DVec3;

use crate::allocation::reserved;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::DetectorPose;
use crate::levenberg_marquardt::{MAX_LEVELS, check_levels};
use crate::pixel_blocks::PixelBlocks;
use crate::pose_gradient::{PoseProjector, Signal};
use crate::real::Real;
use crate::scene::Scene;
use crate::volume::Volume;

/// Projectors of one volume, each with voxels and pixels twice as large as the next one's, as means of blocks: what is far off
/// is found on the coarse ones, where the loss has one valley.
pub struct Registrar<T> {
    /// The coarsest first.
    levels: Vec<Level<T>>,
}

struct Level<T> {
    projector: PoseProjector<T>,
    /// Pixels of the finest level that become one, along each side.
    block: usize,
}

/// A measured image, pixel (i, j) at `j*width + i`.
#[derive(Debug, Clone, Copy)]
pub struct RegistrationView<'a, T> {
    /// Source and detector.
    pub pose: DetectorPose,
    /// The image; pixels that do not count may be NaN.
    pub measured: &'a [T],
    /// Which pixels count; `None`: all.
    pub mask: Option<&'a [bool]>,
}

/// All views on one level.
pub(super) struct LevelViews<'a, T> {
    pub projector: &'a PoseProjector<T>,
    pub signal: Signal,
    pub views: Vec<LevelView<T>>,
}

/// A view on one level.
pub(super) struct LevelView<T> {
    pub pose: DetectorPose,
    pub measured: Vec<T>,
    pub mask: Option<Vec<bool>>,
}

impl<T: Real> Registrar<T> {
    /// So many levels of a volume and a scene's detector, the finest included. Of columns and rows that fill no block, the last
    /// are left out.
    ///
    /// # Errors
    /// As [`PoseProjector::new`]; `InvalidArgument` for no level, more than [`MAX_LEVELS`], or a level without a
    /// pixel.
    pub fn new(context: &Context, volume: Arc<Volume>, scene: &Scene, levels: usize) -> Result<Self> {
        let [width, height] = scene.detector;
        // A level of one pixel says nothing, but it is one.
        let most = MAX_LEVELS.min(width.min(height).max(1).ilog2() as usize + 1);
        check_levels(levels, most, &format!(" for a detector of {width} × {height} pixels"))?;
        let pivot = volume.grid().centre();
        let mut made = reserved(levels, "the levels")?;
        let mut coarser = volume;
        for level in 0..levels {
            if level > 0 {
                coarser = Arc::new(context.install(|| coarser.coarser())?);
            }
            let block = 1 << level;
            let scene = Scene { detector: scene.detector.map(|side| side / block), ..scene.clone() };
            let projector = PoseProjector::new(context, coarser.clone(), &scene)?.with_pivot(pivot)?;
            made.push(Level { projector, block });
        }
        made.reverse();
        Ok(Self { levels: made })
    }

    /// The same registrar of an object that turns about another point, world mm; at first the grid's centre.
    ///
    /// # Errors
    /// As [`PoseProjector::with_pivot`].
    pub fn with_pivot(self, pivot: DVec3) -> Result<Self> {
        let mut levels = reserved(self.levels.len(), "the levels")?;
        for Level { projector, block } in self.levels {
            levels.push(Level { projector: projector.with_pivot(pivot)?, block });
        }
        Ok(Self { levels })
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// The finest level's projector, of the volume itself.
    ///
    /// # Panics
    /// Never: there is always one.
    pub fn finest(&self) -> &PoseProjector<T> {
        &self.levels[self.levels.len() - 1].projector
    }

    /// The views on each level, with its projector; levels on which no pixel of some view counts are left out.
    pub(super) fn views(
        &self,
        views: &[RegistrationView<'_, T>],
        signal: Signal,
    ) -> Result<Vec<LevelViews<'_, T>>> {
        if views.is_empty() {
            return Err(Error::invalid("views", "empty", "at least one view"));
        }
        for (v, view) in views.iter().enumerate() {
            let named = |error: Error| error.of(&format!("views[{v}]"));
            view.pose.validate().map_err(named)?;
            self.finest().check_measured(view.measured, view.mask).map_err(named)?;
        }
        let mut levels = reserved(self.levels.len(), "the levels")?;
        for Level { projector, block } in &self.levels {
            let mut on_level = reserved(views.len(), "the views")?;
            for view in views {
                on_level.push(view.coarser(self.finest().size(), *block)?);
            }
            let counts = |view: &LevelView<T>| view.mask.as_ref().is_none_or(|mask| mask.contains(&true));
            if on_level.iter().all(counts) {
                levels.push(LevelViews { projector, signal, views: on_level });
            }
        }
        Ok(levels)
    }
}

impl<T: Real> RegistrationView<'_, T> {
    /// Means of `block`×`block` pixels of an image of this size; they count where all of them do.
    fn coarser(&self, size: [usize; 2], block: usize) -> Result<LevelView<T>> {
        let pixels = PixelBlocks::new(size, [block; 2]);
        Ok(LevelView {
            pose: self.pose.of_blocks(block),
            measured: pixels.means(self.measured)?,
            mask: self.mask.map(|mask| pixels.mask(mask)).transpose()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_lie_in_the_middle_of_their_pixels() {
        let pose = DetectorPose::c_arm(DVec3::ZERO, 6.0, 500.0, 800.0, 2.0, [5, 4]);
        let image: Vec<f64> = (0..20).map(f64::from).collect();
        let mask: Vec<bool> = (0..20).map(|n| n != 6).collect();
        let view = RegistrationView { pose, measured: &image, mask: Some(&mask) };
        let coarse = view.coarser([5, 4], 2).expect("memory");
        assert_eq!(coarse.measured, [3.0, 5.0, 13.0, 15.0]);
        assert_eq!(coarse.mask.as_deref(), Some(&[false, true, true, true][..]));
        for (i, j) in [(0.0, 0.0), (1.0, 1.0)] {
            let middle = pose.pixel(2.0 * i + 0.5, 2.0 * j + 0.5);
            assert!((coarse.pose.pixel(i, j) - middle).length() < 1e-12);
        }
        assert_eq!(coarse.pose.source, pose.source);
    }
}
