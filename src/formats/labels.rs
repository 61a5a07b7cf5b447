//! A source of labels: which tissue or structure a voxel belongs to.

use std::path::Path;

use crate::error::Result;
use crate::formats::{RawLabels, StoredLabels, stored};
use crate::geometry::Grid;

/// Labels that can be read slice by slice, any number of times.
pub trait LabelReader: Send {
    /// Dimensions and place.
    fn grid(&self) -> &Grid;

    /// Hands every slice to `consume`, with its index k = 0, 1, …, n2−1: n0 × n1 labels, voxel (i, j) at `j*n0 + i`.
    ///
    /// # Errors
    /// `File` when the file is damaged or a value is not one of 0, 1, …, 255; whatever `consume` returns. What was
    /// consumed before an error must not be used.
    fn read(&mut self, consume: &mut dyn FnMut(usize, &[u8]) -> Result<()>) -> Result<()>;
}

/// Opens the labels of a CT: NIfTI, MetaImage or NRRD when the name says so, otherwise raw uint8, x fastest.
///
/// # Errors
/// `File` when dimensions, or the places that the file states, are not those of the CT's grid.
pub fn open_labels(path: &Path, ct: &Grid) -> Result<Box<dyn LabelReader>> {
    if stored::is_stored(path) {
        Ok(Box::new(StoredLabels::open(path, ct)?))
    } else {
        Ok(Box::new(RawLabels::open(path, ct)?))
    }
}
