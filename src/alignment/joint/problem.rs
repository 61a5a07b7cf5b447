//! Which views and volume are to be found.

use crate::error::{Error, Result};
use crate::parallel::{ParallelGeometry, ViewParameters, check_views};
use crate::real::Real;
use crate::values::{check_count, check_finite};

/// Views of a parallel beam that are not quite where they are thought to be, of an object that is not known.
#[derive(Clone, Copy)]
pub struct JointProblem<'a, T> {
    /// What the volume, the detector and the steps are.
    pub geometry: &'a ParallelGeometry,
    /// Line integrals, `(view*nv + v)*nu + u`.
    pub images: &'a [T],
    /// Where the views are thought to be.
    pub views: &'a [ViewParameters],
}

impl<T: Real> JointProblem<'_, T> {
    /// # Errors
    /// `InvalidArgument` for a geometry or views that are not valid, no views, another number of pixels than the views have,
    /// and values that are not finite.
    pub fn validate(&self) -> Result<()> {
        self.geometry.validate()?;
        if self.views.is_empty() {
            return Err(Error::invalid("views", "empty", "at least one view"));
        }
        check_views(self.views)?;
        let pixels = self.geometry.pixels() * self.views.len();
        check_count("images", self.images.len(), pixels, "pixel of each view")?;
        check_finite("images", self.images)
    }
}
