//! The transpose of [`runs`](super::runs): blocks of rows give back to the lines of voxels that they read.

use glam::DVec3;
use pulp::Simd;

use crate::parallel::ParallelGeometry;
use crate::parallel::cpu::fast::block::{Block, GROUP, MAX_ROWS};
use crate::parallel::cpu::fast::lanes::load;
use crate::parallel::cpu::fast::table::{Reach, Table};
use crate::parallel::cpu::fast::{VECTORS, drift};
use crate::parallel::cpu::slab::Slab;
use crate::parallel::cpu::steps::steps_inside;
use crate::parallel::engine::ViewRays;

/// All rays of a view that count, into one slab.
#[inline(always)]
pub(super) fn scatter<S: Simd>(
    simd: S,
    slab: &mut Slab<f32>,
    geometry: &ParallelGeometry,
    view: &ViewRays<'_>,
    image: &dyn Fn(usize) -> f32,
) {
    let lanes = VECTORS * S::F32_LANES;
    let [nu, nv] = geometry.detector;
    let limits = slab.limits();
    let last = (lanes - 1) as f64;
    let reach = Reach { drift: last * drift(view), cells: lanes - 1 };
    let block = Block::<S>::new(slab.sides, drift(view));
    let middle = 0.5 * (geometry.steps as f64 - 1.0);
    let mut table = Table::<GROUP>::EMPTY;
    for u in 0..nu {
        let ends = [view.frame.at(u, 0), view.frame.at(u, nv - 1)];
        let all = steps_inside(limits, geometry, view.frame, ends);
        for group in all.clone().step_by(GROUP) {
            for v in (0..nv).step_by(lanes) {
                let base = view.frame.at(u, v);
                let rows = [base, base + last * view.frame.row];
                let inside = steps_inside(limits, geometry, view.frame, rows);
                let steps = inside.start.max(group)..inside.end.min(all.end).min(group + GROUP);
                if steps.is_empty() {
                    continue;
                }
                table.fill(slab.sides, base, view.frame.step, group as f64 - middle, reach);
                let values = shares(geometry, view, image, [u, v], lanes);
                for n in steps.start - group..steps.end - group {
                    add(simd, &block, slab, &table, n, &values);
                }
            }
        }
    }
}

/// What each sample of a block's rows gives, from row v on; 0 where rays do not count.
#[inline(always)]
fn shares(
    geometry: &ParallelGeometry,
    view: &ViewRays<'_>,
    image: &dyn Fn(usize) -> f32,
    [u, v]: [usize; 2],
    lanes: usize,
) -> [f32; MAX_ROWS] {
    let [nu, nv] = geometry.detector;
    let mut values = [0.0; MAX_ROWS];
    for (v, value) in (v..nv.min(v + lanes)).zip(&mut values) {
        let pixel = v * nu + u;
        if view.rays.counts(pixel) {
            *value = geometry.step as f32 * image(pixel);
        }
    }
    values
}

/// A step of a table: the whole block at once, or, where rows lie in several runs or outside, one run after the other.
#[inline(always)]
fn add<S: Simd>(
    simd: S,
    block: &Block<S>,
    slab: &mut Slab<f32>,
    table: &Table<GROUP>,
    n: usize,
    values: &[f32; MAX_ROWS],
) {
    let at = |of: &[[f64; GROUP]; 3]| DVec3::new(of[0][n], of[1][n], of[2][n]);
    let q = at(&table.position);
    if table.inside[n] != 0 {
        return add_run(simd, block, slab, q, at(&table.cell), values);
    }
    let lanes = VECTORS * S::F32_LANES;
    let mut from = 0;
    while from < lanes {
        let (cell, to) = block.run(q, from, lanes);
        if let Some((from, to)) = block.inside(cell, from, to) {
            let mut part = [0.0; MAX_ROWS];
            part[from..to].copy_from_slice(&values[from..to]);
            add_run(simd, block, slab, q, cell, &part);
        }
        from = to;
    }
}

/// Rows that lie in one run, others being 0: row 0 at `q`, in a cell that is its own or, along z, would be.
#[inline(always)]
fn add_run<S: Simd>(
    simd: S,
    block: &Block<S>,
    slab: &mut Slab<f32>,
    q: DVec3,
    cell: DVec3,
    values: &[f32; MAX_ROWS],
) {
    let fraction = (q - cell).as_vec3();
    let [layer, y, z] = (cell + 1.0).as_i64vec3().to_array();
    for x in 0..2 {
        let layer = layer as usize + x;
        if !slab.layers.contains(&layer) {
            continue;
        }
        let mut shares = [[simd.splat_f32s(0.0); VECTORS]; 2];
        let mut fractions = [simd.splat_f32s(0.0); VECTORS];
        for m in 0..VECTORS {
            let value = load::<S>(&values[m * S::F32_LANES..]);
            let [x_ramp, y_ramp, z_ramp] = block.ramp[m];
            let above = simd.mul_f32s(simd.add_f32s(simd.splat_f32s(fraction.x), x_ramp), value);
            let value = if x == 0 { simd.sub_f32s(value, above) } else { above };
            let above = simd.mul_f32s(simd.add_f32s(simd.splat_f32s(fraction.y), y_ramp), value);
            (shares[0][m], shares[1][m]) = (simd.sub_f32s(value, above), above);
            fractions[m] = simd.add_f32s(simd.splat_f32s(fraction.z), z_ramp);
        }
        let first = (slab.line(layer, y as usize) as i64 + z) as usize;
        for (y, shares) in shares.into_iter().enumerate() {
            let line = &mut slab.values[first + y * slab.sides[2]..][..=VECTORS * S::F32_LANES];
            add_line(simd, line, shares, fractions);
        }
    }
}

/// A block's values to a line of voxels: to each cell's lower end, and to its upper one, which is the next cell's lower.
#[inline(always)]
fn add_line<S: Simd>(simd: S, line: &mut [f32], values: [S::f32s; VECTORS], fractions: [S::f32s; VECTORS]) {
    let mut lane = [1.0_f32; MAX_ROWS];
    lane[0] = 0.0;
    let first = simd.equal_f32s(load::<S>(&lane), simd.splat_f32s(0.0));
    let mut carry = simd.splat_f32s(0.0);
    for m in 0..VECTORS {
        let above = simd.mul_f32s(fractions[m], values[m]);
        let below = simd.sub_f32s(values[m], above);
        // What the last lane gives to the next voxel comes first, and waits for the next vector.
        let turned = simd.rotate_right_f32s(above, 1);
        let sum = simd.add_f32s(below, simd.select_f32s(first, carry, turned));
        let line = &mut line[m * S::F32_LANES..][..S::F32_LANES];
        let voxels = &mut S::as_mut_simd_f32s(line).0[0];
        *voxels = simd.add_f32s(*voxels, sum);
        carry = turned;
    }
    line[VECTORS * S::F32_LANES] +=
        pulp::bytemuck::cast_slice::<S::f32s, f32>(std::slice::from_ref(&carry))[0];
}
