//! What a picture's pixels show of more, or fewer, values.

/// The value, of `values`, that the centre of a pixel, of `pixels`, lies on.
pub(crate) fn nearest(pixel: usize, pixels: usize, values: usize) -> usize {
    (2 * pixel + 1) * values / (2 * pixels)
}
