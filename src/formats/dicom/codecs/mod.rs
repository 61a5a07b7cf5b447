//! Decoders of compressed frames: a word for each pixel of one grey image.

pub(super) mod jpeg;
pub(super) mod jpeg_2000;
pub(super) mod jpeg_ls;
pub(super) mod rle;

use crate::formats::Checked;

/// Whether a code stream is of the size that the attributes give, in columns and rows.
fn check_size(coded: [usize; 2], size: [usize; 2]) -> Checked<()> {
    if coded == size {
        return Ok(());
    }
    let [[a, b], [c, d]] = [coded, size];
    Err(format!("its code stream has {a} x {b} pixels, but Columns x Rows are {c} x {d}"))
}
