//! Blocks of neighbouring rows, whose cells lie side by side.

use std::ops::Range;

use glam::DVec3;
use pulp::Simd;

use crate::parallel::cpu::fast::block::{Block, GROUP};
use crate::parallel::cpu::fast::lanes::Lanes;
use crate::parallel::cpu::fast::table::{Reach, Table};
use crate::parallel::cpu::fast::{Column, VECTORS, drift};
use crate::parallel::cpu::field::{Field, SLACK};
use crate::parallel::cpu::ray_sum::RaySum;
use crate::parallel::cpu::steps::{BLOCK, steps_inside};
use crate::parallel::engine::ViewRays;

/// Rows for which reading ahead finds one line of cells.
const AHEAD: usize = 128;

/// Values in a line of the cache.
const CACHED: usize = 16;

/// All rows of a column, in units of a step.
#[inline(always)]
pub(super) fn integrate<S: Simd, const DERIVATIVES: bool>(simd: S, column: Column<'_>, sums: &mut [RaySum]) {
    let lanes = VECTORS * S::F32_LANES;
    let ranges = ranges(column, sums.len(), lanes);
    let first = ranges.iter().filter(|range| !range.is_empty()).map(|range| range.start).min().unwrap_or(0);
    let end = ranges.iter().map(|range| range.end).max().unwrap_or(0);
    let middle = 0.5 * (column.geometry.steps as f64 - 1.0);
    let mut parts = vec![[Lanes::<S, DERIVATIVES>::zero(simd); VECTORS]; ranges.len()];
    for first in (first..end).step_by(BLOCK) {
        add_steps(simd, column, &ranges, first..end.min(first + BLOCK), &mut parts);
        for (parts, sums) in parts.iter_mut().zip(sums.chunks_mut(lanes)) {
            for (part, sums) in parts.iter_mut().zip(sums.chunks_mut(S::F32_LANES)) {
                part.add_to(sums, first as f64 - middle);
                *part = Lanes::zero(simd);
            }
        }
    }
}

/// For each block of so many rows, the steps at which it may be in the field; none where no ray counts.
#[inline(always)]
fn ranges(column: Column<'_>, rows: usize, lanes: usize) -> Vec<Range<usize>> {
    let Column { field, geometry, view, u } = column;
    let inside = |v: usize| {
        if !(v..rows.min(v + lanes)).any(|v| view.rays.counts(v * geometry.detector[0] + u)) {
            return 0..0;
        }
        let base = view.frame.at(u, v);
        let last = base + (lanes - 1) as f64 * view.frame.row;
        steps_inside(field.limits(), geometry, view.frame, [base, last])
    };
    (0..rows).step_by(lanes).map(inside).collect()
}

/// Adds these steps of all blocks to their parts; the first is counted as 0.
#[inline(always)]
fn add_steps<S: Simd, const DERIVATIVES: bool>(
    simd: S,
    column: Column<'_>,
    ranges: &[Range<usize>],
    steps: Range<usize>,
    parts: &mut [[Lanes<S, DERIVATIVES>; VECTORS]],
) {
    let Column { field, geometry, view, u } = column;
    let lanes = VECTORS * S::F32_LANES;
    let reach = Reach { drift: (lanes - 1) as f64 * drift(view), cells: lanes - 1 };
    let block = Block::<S>::new(field.sides(), drift(view));
    let middle = 0.5 * (geometry.steps as f64 - 1.0);
    let mut table = Table::<GROUP>::EMPTY;
    for group in steps.clone().step_by(GROUP) {
        let ks = (group..steps.end.min(group + GROUP)).map(|step| step as f64 - middle);
        read_ahead(field, view, u, geometry.detector[1], &ks);
        for (n, (range, parts)) in ranges.iter().zip(parts.iter_mut()).enumerate() {
            let inside = range.start.max(group)..range.end.min(group + GROUP);
            if inside.is_empty() {
                continue;
            }
            let base = view.frame.at(u, n * lanes);
            table.fill(field.sides(), base, view.frame.step, group as f64 - middle, reach);
            let (inside, k) = (inside.start - group..inside.end - group, (group - steps.start) as f32);
            let sums = block.integrate::<DERIVATIVES>(simd, field.values(), &table, inside, k);
            for (part, sum) in parts.iter_mut().zip(&sums) {
                part.merge(simd, sum);
            }
        }
    }
}

/// Reads what these steps of a column will need, one value of each line of the cache: many such reads wait for memory at the
/// same time, where samples wait one after the other.
#[inline(always)]
fn read_ahead(
    field: &Field<f32>,
    view: &ViewRays<'_>,
    u: usize,
    rows: usize,
    steps: &(impl Iterator<Item = f64> + Clone),
) {
    let [sx, sy, sz] = field.sides();
    let values = field.values();
    let mut read = 0;
    for v in (0..rows).step_by(AHEAD) {
        let middle = view.frame.at(u, v) + (0.5 * AHEAD as f64) * view.frame.row;
        for k in steps.clone() {
            let q = middle + k * view.frame.step;
            // Corners (0, 0) and (1, 1): neighbouring steps read the others.
            let cell = (q + 1.0).max(DVec3::ZERO);
            let [x, y] = [(cell.x as usize).min(sx - 2), (cell.y as usize).min(sy - 2)];
            let from = (cell.z as usize).saturating_sub(AHEAD / 2).min(sz);
            for line in [x * sy + y, (x + 1) * sy + y + 1] {
                let line = &values[SLACK + line * sz + from..][..AHEAD.min(sz - from)];
                // Sums of whole numbers wait for one another the least.
                for cached in line.chunks(CACHED) {
                    read ^= cached[0].to_bits();
                }
            }
        }
    }
    std::hint::black_box(read);
}
