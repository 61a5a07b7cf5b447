//! Images of fewer, larger pixels.

use crate::allocation::collected;
use crate::error::Result;
use crate::real::Real;

/// How many pixels of an image become one, along columns and rows. Columns and rows that fill no block, the last ones, are left
/// out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PixelBlocks {
    size: [usize; 2],
    block: [usize; 2],
}

impl PixelBlocks {
    /// Of an image of `size` = width × height; `block` is at least 1.
    pub(crate) fn new(size: [usize; 2], block: [usize; 2]) -> Self {
        Self { size, block }
    }

    /// Width and height of the means.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.size[0] / self.block[0], self.size[1] / self.block[1]]
    }

    /// An image's means, row by row.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn means<T: Real>(&self, image: &[T]) -> Result<Vec<T>> {
        let part = 1.0 / (self.block[0] * self.block[1]) as f64;
        let mean = |pixel: usize| T::of(part * self.pixels(pixel).map(|n| image[n].into()).sum::<f64>());
        collected((0..self.count()).map(mean), "the means of pixels")
    }

    /// Which means count: those of which every pixel does.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn mask(&self, mask: &[bool]) -> Result<Vec<bool>> {
        let all = |pixel: usize| self.pixels(pixel).all(|n| mask[n]);
        collected((0..self.count()).map(all), "the mask")
    }

    fn count(&self) -> usize {
        self.size().iter().product()
    }

    /// The pixels that become one.
    fn pixels(&self, pixel: usize) -> impl Iterator<Item = usize> + use<> {
        let ([width, _], [columns, rows]) = (self.size, self.block);
        let across = width / columns;
        let (i, j) = (pixel % across * columns, pixel / across * rows);
        (j..j + rows).flat_map(move |j| (i..i + columns).map(move |i| j * width + i))
    }
}
