//! Where a loss and its derivatives go.

use crate::capi::memory;
use crate::error::Result;
use crate::normal_equations::NormalEquations;

/// Places for a loss, its gradient and JᵀJ, which may be null.
#[derive(Clone, Copy)]
pub(super) struct LossPlaces {
    pub(super) loss: *mut f64,
    pub(super) gradient: *mut f64,
    pub(super) hessian: *mut f64,
}

impl LossPlaces {
    /// Checks the places for derivatives with respect to so many parameters.
    pub(super) fn check(&self, parameters: usize) -> Result<()> {
        memory::check("loss", self.loss, 1)?;
        memory::check("gradient", self.gradient, parameters)?;
        memory::check_optional("hessian", self.hessian, parameters * parameters)
    }

    /// Copies the sums to the caller.
    ///
    /// # Safety
    /// [`Self::check`] has seen the places for N parameters, which have room for that.
    pub(super) unsafe fn write<const N: usize>(&self, sums: &NormalEquations<N>) {
        // SAFETY: by the caller's promise.
        unsafe {
            memory::write_array(self.loss, &[sums.loss]);
            memory::write_array(self.gradient, &sums.gradient);
            memory::write_array(self.hessian, sums.hessian.as_flattened());
        }
    }
}
