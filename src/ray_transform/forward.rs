//! A x: every pixel sums over the voxels along its ray.

use rayon::prelude::*;

use crate::ray_transform::RayTransform;
use crate::ray_transform::slab::Slab;
use crate::real::Real;

impl<T: Real> RayTransform<T> {
    /// The images of a volume, into zeros.
    pub(super) fn project(&self, volume: &[T], images: &mut [T]) {
        let slabs = [0, 1, 2].map(|axis| Slab::whole(self.grid.dimensions(), axis));
        let width = self.size[0];
        images.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
            for (i, pixel) in pixels.iter_mut().enumerate() {
                if let Some(line) = self.line(row * width + i) {
                    *pixel = line.integral(self.algorithm, &slabs[line.ray.axis], volume);
                }
            }
        });
    }
}
