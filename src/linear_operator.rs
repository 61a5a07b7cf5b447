//! Linear maps between volumes and images.

use crate::error::Result;

/// A map A from a volume to images, and its adjoint Aᵀ, which is its transpose: ⟨A x, b⟩ = ⟨x, Aᵀ b⟩ up to rounding. Both are
/// the same to the last bit for any number of threads.
pub trait LinearOperator<T> {
    /// Number of voxels.
    fn domain(&self) -> usize;

    /// Number of pixels of all images.
    fn range(&self) -> usize;

    /// A x.
    ///
    /// # Errors
    /// `InvalidArgument` for another number of values than `domain()`, or values that are not finite; `OutOfMemory`.
    fn forward(&self, volume: &[T]) -> Result<Vec<T>>;

    /// Aᵀ b.
    ///
    /// # Errors
    /// As `forward`, of `range()` values.
    fn adjoint(&self, images: &[T]) -> Result<Vec<T>>;
}
