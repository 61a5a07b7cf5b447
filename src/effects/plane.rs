//! One number per pixel.

use rayon::prelude::*;

use crate::allocation::{collected, filled};
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

    /// Each row (its number, and where its values go) made by itself, in parallel.
    ///
    /// # Errors
    /// `OutOfMemory`, and those of `make`.
    pub(crate) fn of_rows(
        size: [usize; 2],
        make: impl Fn(usize, &mut [f64]) -> Result<()> + Sync,
    ) -> Result<Self> {
        let mut plane = Self::filled(size, 0.0)?;
        let rows = plane.values.par_chunks_mut(size[0].max(1)).enumerate();
        rows.try_for_each(|(j, row)| make(j, row))?;
        Ok(plane)
    }

    /// Another with the same values.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn copied(&self) -> Result<Self> {
        Ok(Self { size: self.size, values: collected(self.values.iter().copied(), "an image")? })
    }

    /// Adds another plane of the same size.
    pub(crate) fn add(&mut self, other: &Self) {
        self.values.par_iter_mut().zip(&other.values).for_each(|(sum, value)| *sum += value);
    }

    /// Width and height, pixels.
    pub(crate) fn size(&self) -> [usize; 2] {
        self.size
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// The values of row `j`.
    pub(crate) fn row(&self, j: usize) -> &[f64] {
        &self.values[j * self.size[0]..][..self.size[0]]
    }

    pub(crate) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// The value at each (column, row), for tests.
    #[cfg(test)]
    pub(crate) fn of_points(size: [usize; 2], value: impl Fn(usize, usize) -> f64) -> Self {
        let values = (0..size[1]).flat_map(|j| (0..size[0]).map(move |i| (i, j)));
        Self { size, values: values.map(|(i, j)| value(i, j)).collect() }
    }
}
