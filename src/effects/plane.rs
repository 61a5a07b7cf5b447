//! One number per pixel.

use crate::allocation::filled;
use crate::error::Result;

/// One number per ray or pixel of one view: that of (i, j), i = column, is at `j*width + i`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plane {
    size: [usize; 2],
    values: Vec<f64>,
}

impl Plane {
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn filled(size: [usize; 2], value: f64) -> Result<Self> {
        Ok(Self { size, values: filled(size[0] * size[1], value, "an image")? })
    }

    /// Width and height, pixels.
    pub(crate) fn size(&self) -> [usize; 2] {
        self.size
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(crate) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }
}
