//! Several steps of one ray at once, whose corners are fetched one by one.

use pulp::Simd;

use crate::parallel::cpu::fast::Column;
use crate::parallel::cpu::fast::lanes::{Lanes, MAX_LANES, interpolate, load};
use crate::parallel::cpu::fast::table::{Reach, Table};
use crate::parallel::cpu::field::SLACK;
use crate::parallel::cpu::ray_sum::RaySum;
use crate::parallel::cpu::steps::{BLOCK, steps_inside, weight};

/// 0, 1, 2, …
const COUNT: [f32; BLOCK] = {
    let mut count = [0.0; BLOCK];
    let mut n = 0;
    while n < BLOCK {
        count[n] = n as f32;
        n += 1;
    }
    count
};

/// All rows of a column, in units of a step.
#[inline(always)]
pub(super) fn integrate<S: Simd, const DERIVATIVES: bool>(simd: S, column: Column<'_>, sums: &mut [RaySum]) {
    let Column { field, geometry, view, u } = column;
    let middle = 0.5 * (geometry.steps as f64 - 1.0);
    let mut table = Table::EMPTY;
    for (v, sum) in sums.iter_mut().enumerate() {
        let pixel = v * geometry.detector[0] + u;
        if !view.rays.counts(pixel) {
            continue;
        }
        let base = view.frame.at(u, v);
        let inside = steps_inside(field.limits(), geometry, view.frame, [base, base]);
        for first in inside.clone().step_by(BLOCK) {
            let count = BLOCK.min(inside.end - first);
            let from = first as f64 - middle;
            table.fill(field.sides(), base, view.frame.step, from, Reach::NONE);
            let mut weights = [0.0_f32; BLOCK];
            for (weight, inside) in weights.iter_mut().zip(&table.inside).take(count) {
                *weight = if *inside == 0 { 0.0 } else { 1.0 };
            }
            if view.rays.lengths.is_some() {
                let length = view.rays.length(pixel);
                for (n, value) in weights.iter_mut().enumerate().take(count) {
                    *value *= (weight(geometry, first + n, length) / geometry.step) as f32;
                }
            }
            let part = block::<S, DERIVATIVES>(simd, field.values(), field.sides(), &table, &weights);
            part.reduce_to(simd, sum, from);
        }
    }
}

/// The steps of a table, weighted.
#[inline(always)]
fn block<S: Simd, const DERIVATIVES: bool>(
    simd: S,
    values: &[f32],
    [_, sy, sz]: [usize; 3],
    table: &Table<BLOCK>,
    weights: &[f32; BLOCK],
) -> Lanes<S, DERIVATIVES> {
    let mut sums = Lanes::zero(simd);
    let ends = [0, 1, sz, sz + 1, sy * sz, sy * sz + 1, sy * sz + sz, sy * sz + sz + 1];
    for at in (0..BLOCK).step_by(S::F32_LANES) {
        let mut fetched = [[0.0_f32; MAX_LANES]; 8];
        for lane in 0..S::F32_LANES {
            // What is weighted 0 is read where there are voxels.
            let first = (table.index[at + lane] as usize).max(SLACK);
            let cell = &values[first..][..sy * sz + sz + 2];
            for (corner, end) in fetched.iter_mut().zip(ends) {
                corner[lane] = cell[end];
            }
        }
        let corner = |n: usize| [load::<S>(&fetched[2 * n]), load::<S>(&fetched[2 * n + 1])];
        let corners = [corner(0), corner(1), corner(2), corner(3)];
        let [x, y, z] = &table.fraction;
        let fraction = [load::<S>(&x[at..]), load::<S>(&y[at..]), load::<S>(&z[at..])];
        let (value, slope) = interpolate::<S, DERIVATIVES>(simd, corners, fraction);
        sums.add_weighted(simd, load::<S>(&weights[at..]), load::<S>(&COUNT[at..]), value, slope);
    }
    sums
}
