//! The transpose of the projection: each ray gives its pixel's value back to the voxels that its image is a sum of. Whatever
//! engine projects, the CPU takes it.

use std::any::Any;

use glam::DVec3;
use rayon::prelude::*;

use crate::allocation::{filled, reserved};
use crate::error::Result;
use crate::parallel::cpu::field::padded;
use crate::parallel::cpu::slab::{Slab, copy};
use crate::parallel::cpu::{exact, fast, steps};
use crate::parallel::engine::ViewRays;
use crate::parallel::{ParallelGeometry, Quadrature};
use crate::real::Real;

/// Slabs that are held at once, at least: memory that is used again is in the cache.
const HELD: usize = 4;

/// The sum over views, voxels with x fastest.
///
/// # Errors
/// `OutOfMemory`.
pub(in crate::parallel) fn adjoint<T: Real>(
    geometry: &ParallelGeometry,
    quadrature: Quadrature,
    views: &[ViewRays<'_>],
    images: &[T],
) -> Result<Vec<T>> {
    let sides = padded(geometry.dimensions);
    let count = Slab::<T>::count(sides);
    let held = count.min(HELD.max(2 * rayon::current_num_threads()));
    let mut slabs = reserved(held, "layers of the volume")?;
    for _ in 0..held {
        slabs.push(Slab::new(sides)?);
    }
    let mut voxels = filled(geometry.dimensions.iter().product(), T::default(), "the volume")?;
    let pixels = geometry.pixels();
    for first in (0..count).step_by(held) {
        let slabs = &mut slabs[..held.min(count - first)];
        slabs.par_iter_mut().enumerate().for_each(|(n, slab)| {
            slab.restart(first + n);
            for (view, image) in views.iter().zip(images.chunks(pixels)) {
                scatter(geometry, quadrature, view, image, slab);
            }
        });
        copy(slabs, &mut voxels);
    }
    Ok(voxels)
}

/// The rays of one view, into one slab.
fn scatter<T: Real>(
    geometry: &ParallelGeometry,
    quadrature: Quadrature,
    view: &ViewRays<'_>,
    image: &[T],
    slab: &mut Slab<T>,
) {
    let frame = view.frame;
    let [nu, nv] = geometry.detector;
    let value = |pixel: usize| Into::<f64>::into(image[pixel]);
    if quadrature == Quadrature::Steps
        && fast::has_runs(view)
        && let Some(slab) = (slab as &mut dyn Any).downcast_mut::<Slab<f32>>()
    {
        return fast::scatter(slab, geometry, view, &|pixel| value(pixel) as f32);
    }
    let limits = slab.limits();
    for u in 0..nu {
        let ends: [DVec3; 2] = [frame.at(u, 0), frame.at(u, nv - 1)];
        if steps::steps_inside(limits, geometry, frame, ends).is_empty() {
            continue;
        }
        for v in 0..nv {
            let pixel = v * nu + u;
            if !view.rays.counts(pixel) {
                continue;
            }
            let (value, length) = (value(pixel), view.rays.length(pixel));
            let add = |_: f64, point: DVec3, weight: f64| slab.add(point.to_array(), T::of(weight * value));
            match quadrature {
                Quadrature::Steps => steps::visit(limits, geometry, frame, [u, v], length, add),
                Quadrature::Exact => exact::visit(limits, geometry, frame, [u, v], length, add),
            }
        }
    }
}
