//! The sum over equal steps of a float32 field, vectorised.
//!
//! Voxels lie with z fastest and detector rows run along z, whatever φ, as long as the object is tilted little. Neighbouring
//! rows then find their cells side by side at each step, but where they leave a line of cells: runs ([`runs`]). Else each
//! ray takes several steps at once, and fetches corners one by one ([`steps`]).

mod block;
mod lanes;
mod runs;
mod scatter;
mod steps;
mod table;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::parallel::ParallelGeometry;
use crate::parallel::cpu::field::Field;
use crate::parallel::cpu::ray_sum::RaySum;
use crate::parallel::cpu::slab::Slab;
use crate::parallel::engine::ViewRays;

/// Vectors of rows that are taken together: as many as registers hold.
const VECTORS: usize = 2;

/// Parts into which lines of cells may divide eight rows, on average, for runs to be faster.
const MOST_PARTS: f64 = 4.0;

/// A column of a view.
#[derive(Clone, Copy)]
pub(super) struct Column<'a> {
    pub field: &'a Field<f32>,
    pub geometry: &'a ParallelGeometry,
    pub view: &'a ViewRays<'a>,
    pub u: usize,
}

/// Integrates the rays of a column that count, into `sums`, which are 0; those of others may be anything. Without
/// DERIVATIVES only values.
pub(super) fn integrate<const DERIVATIVES: bool>(column: Column<'_>, sums: &mut [RaySum]) {
    Arch::new().dispatch(Integrate::<DERIVATIVES> { column, sums });
}

/// Adds the transpose of [`integrate`] to a slab, of a view that has runs: `image` is its image.
pub(super) fn scatter(
    slab: &mut Slab<f32>,
    geometry: &ParallelGeometry,
    view: &ViewRays<'_>,
    image: &dyn Fn(usize) -> f32,
) {
    Arch::new().dispatch(Scatter { slab, geometry, view, image });
}

/// Whether rows lie side by side long enough, and all of their rays count as a whole.
pub(super) fn has_runs(view: &ViewRays<'_>) -> bool {
    let parts = 1.0 + 8.0 * drift(view).abs().element_sum();
    view.rays.lengths.is_none() && parts <= MOST_PARTS
}

/// How neighbouring rows move apart, beside their whole voxel along z.
fn drift(view: &ViewRays<'_>) -> DVec3 {
    view.frame.row - DVec3::Z
}

struct Integrate<'a, const DERIVATIVES: bool> {
    column: Column<'a>,
    sums: &'a mut [RaySum],
}

impl<const DERIVATIVES: bool> WithSimd for Integrate<'_, DERIVATIVES> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if has_runs(self.column.view) {
            runs::integrate::<S, DERIVATIVES>(simd, self.column, self.sums);
        } else {
            steps::integrate::<S, DERIVATIVES>(simd, self.column, self.sums);
        }
        let step = self.column.geometry.step;
        for sum in self.sums {
            sum.scale(step);
        }
    }
}

struct Scatter<'a> {
    slab: &'a mut Slab<f32>,
    geometry: &'a ParallelGeometry,
    view: &'a ViewRays<'a>,
    image: &'a dyn Fn(usize) -> f32,
}

impl WithSimd for Scatter<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        scatter::scatter(simd, self.slab, self.geometry, self.view, self.image);
    }
}

#[cfg(test)]
mod tests;
