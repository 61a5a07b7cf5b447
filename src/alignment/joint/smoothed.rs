//! Images without their finest details.

use crate::allocation::reserved;
use crate::effects::{DetectorBlur, Plane};
use crate::error::Result;
use crate::parallel::ParallelGeometry;
use crate::real::Real;

/// Images of all views, each blurred by a Gaussian.
///
/// # Errors
/// `OutOfMemory`.
pub(super) fn smoothed<T: Real>(images: &[T], geometry: &ParallelGeometry, sigma_mm: f64) -> Result<Vec<T>> {
    let mut all = reserved(images.len(), "the smoothed images")?;
    if sigma_mm == 0.0 {
        all.extend_from_slice(images);
        return Ok(all);
    }
    let blur = DetectorBlur::gaussians(&[(1.0, sigma_mm)])?;
    let nu = geometry.detector[0];
    for image in images.chunks_exact(geometry.pixels()) {
        let plane = Plane::of_rows(geometry.detector, |v, row| {
            let values = image[v * nu..][..nu].iter();
            row.iter_mut().zip(values).for_each(|(to, from)| *to = (*from).into());
            Ok(())
        })?;
        all.extend(blur.applied(&plane, geometry.pixel)?.values().iter().map(|value| T::of(*value)));
    }
    Ok(all)
}
