//! A block of neighbouring rows: its samples at a few steps.

use std::ops::Range;

use glam::DVec3;
use pulp::Simd;

use crate::parallel::cpu::fast::VECTORS;
use crate::parallel::cpu::fast::lanes::{Lanes, MAX_LANES, interpolate, load};
use crate::parallel::cpu::fast::table::Table;
use crate::parallel::cpu::field::SLACK;

/// Steps that all blocks of a column take before any goes on: few, so that what they read is read in order.
pub(super) const GROUP: usize = 16;

/// Most rows of a block.
pub(super) const MAX_ROWS: usize = VECTORS * MAX_LANES;

/// What all blocks of a view have in common.
pub(super) struct Block<S: Simd> {
    pub sides: [usize; 3],
    pub drift: DVec3,
    /// 1/drift.
    lanes_per_cell: DVec3,
    /// From a block's first row to each, without whole voxels along z.
    pub ramp: [[S::f32s; 3]; VECTORS],
}

impl<S: Simd> Block<S> {
    #[inline(always)]
    pub(super) fn new(sides: [usize; 3], drift: DVec3) -> Self {
        let mut ramp = [[0.0_f32; MAX_ROWS]; 3];
        for axis in 0..3 {
            for (lane, offset) in ramp[axis].iter_mut().enumerate() {
                *offset = (lane as f64 * drift[axis]) as f32;
            }
        }
        let vector = |n: usize, axis: usize| load::<S>(&ramp[axis][n * S::F32_LANES..]);
        let ramp = std::array::from_fn(|n| [vector(n, 0), vector(n, 1), vector(n, 2)]);
        Self { sides, drift, lanes_per_cell: drift.recip(), ramp }
    }

    /// Some of a table's steps. The table's first is counted as `k`.
    #[inline(always)]
    pub(super) fn integrate<const DERIVATIVES: bool>(
        &self,
        simd: S,
        values: &[f32],
        table: &Table<GROUP>,
        steps: Range<usize>,
        k: f32,
    ) -> [Lanes<S, DERIVATIVES>; VECTORS] {
        let mut whole = [0_u8; GROUP];
        let mut broken = [0_u8; GROUP];
        let (mut wholes, mut brokens) = (0, 0);
        for n in steps {
            let inside = table.inside[n] != 0;
            whole[wholes & (GROUP - 1)] = n as u8;
            broken[brokens & (GROUP - 1)] = n as u8;
            wholes += usize::from(inside);
            brokens += usize::from(!inside);
        }
        let mut sums = [Lanes::zero(simd); VECTORS];
        for &n in &whole[..wholes] {
            self.add_whole(simd, values, table, usize::from(n), k, &mut sums);
        }
        for &n in &broken[..brokens] {
            self.add_broken(simd, values, table, usize::from(n), k, &mut sums);
        }
        sums
    }

    /// A step at which all rows lie in one run.
    #[inline(always)]
    fn add_whole<const DERIVATIVES: bool>(
        &self,
        simd: S,
        values: &[f32],
        table: &Table<GROUP>,
        n: usize,
        k: f32,
        sums: &mut [Lanes<S, DERIVATIVES>; VECTORS],
    ) {
        let n = n & (GROUP - 1);
        let fraction = [table.fraction[0][n], table.fraction[1][n], table.fraction[2][n]];
        let lines = self.lines(values, table.index[n] as usize);
        let k = simd.splat_f32s(k + n as f32);
        for (m, sum) in sums.iter_mut().enumerate() {
            let (value, slope) = self.sample::<DERIVATIVES>(simd, &lines, fraction, m);
            sum.add(simd, k, value, slope);
        }
    }

    /// A step at which rows lie in several runs, or outside: one run after the other, all others weighted 0.
    #[inline(always)]
    fn add_broken<const DERIVATIVES: bool>(
        &self,
        simd: S,
        values: &[f32],
        table: &Table<GROUP>,
        n: usize,
        k: f32,
        sums: &mut [Lanes<S, DERIVATIVES>; VECTORS],
    ) {
        let n = n & (GROUP - 1);
        let q = DVec3::new(table.position[0][n], table.position[1][n], table.position[2][n]);
        let k = simd.splat_f32s(k + n as f32);
        let lanes = VECTORS * S::F32_LANES;
        let mut from = 0;
        while from < lanes {
            let (cell, to) = self.run(q, from, lanes);
            if let Some((from, to)) = self.inside(cell, from, to) {
                let [_, sy, sz] = self.sides.map(|side| side as i64);
                let [x, y, z] = cell.to_array().map(|c| c as i64 + 1);
                let lines = self.lines(values, (SLACK as i64 + (x * sy + y) * sz + z) as usize);
                let fraction = (q - cell).to_array().map(|f| f as f32);
                let mut weights = [0.0_f32; MAX_ROWS];
                weights[from..to].fill(1.0);
                for (m, sum) in sums.iter_mut().enumerate() {
                    let (value, slope) = self.sample::<DERIVATIVES>(simd, &lines, fraction, m);
                    let weight = load::<S>(&weights[m * S::F32_LANES..]);
                    sum.add_weighted(simd, weight, k, value, slope);
                }
            }
            from = to;
        }
    }

    /// The cell of row `from`, as if along z it were row 0's, and the first row behind it that is in another run.
    #[inline(always)]
    pub(super) fn run(&self, q: DVec3, from: usize, lanes: usize) -> (DVec3, usize) {
        let cell = (q + from as f64 * self.drift).floor();
        let mut to = lanes as f64;
        for axis in 0..3 {
            // Rows that rise leave at the upper face, those that fall below the lower one.
            let drift = self.drift[axis];
            if drift > 0.0 {
                to = to.min(((cell[axis] + 1.0 - q[axis]) * self.lanes_per_cell[axis]).ceil());
            } else if drift < 0.0 {
                to = to.min(((cell[axis] - q[axis]) * self.lanes_per_cell[axis]).floor() + 1.0);
            }
        }
        (cell, (to as usize).max(from + 1))
    }

    /// Those rows of a run that are in the field.
    #[inline(always)]
    pub(super) fn inside(&self, cell: DVec3, from: usize, to: usize) -> Option<(usize, usize)> {
        let most = self.sides.map(|side| side as f64 - 3.0);
        let across = |axis: usize| cell[axis] >= -1.0 && cell[axis] <= most[axis];
        let from = (-1.0 - cell.z).max(from as f64);
        let to = (most[2] + 1.0 - cell.z).min(to as f64);
        (across(0) && across(1) && from < to).then_some((from as usize, to as usize))
    }

    /// The lines of corners (0, 0), (0, 1), (1, 0), (1, 1) along x and y, from the first row's lower corner.
    #[inline(always)]
    fn lines<'a>(&self, values: &'a [f32], first: usize) -> [&'a [f32]; 4] {
        let [_, sy, sz] = self.sides;
        let length = VECTORS * S::F32_LANES + 1;
        [
            &values[first..][..length],
            &values[first + sz..][..length],
            &values[first + sy * sz..][..length],
            &values[first + sy * sz + sz..][..length],
        ]
    }

    #[inline(always)]
    fn sample<const DERIVATIVES: bool>(
        &self,
        simd: S,
        lines: &[&[f32]; 4],
        [x, y, z]: [f32; 3],
        m: usize,
    ) -> (S::f32s, [S::f32s; 3]) {
        let at = m * S::F32_LANES;
        let corner = |line: &[f32]| [load::<S>(&line[at..]), load::<S>(&line[at + 1..])];
        let corners = [corner(lines[0]), corner(lines[1]), corner(lines[2]), corner(lines[3])];
        let fraction = [
            simd.add_f32s(simd.splat_f32s(x), self.ramp[m][0]),
            simd.add_f32s(simd.splat_f32s(y), self.ramp[m][1]),
            simd.add_f32s(simd.splat_f32s(z), self.ramp[m][2]),
        ];
        interpolate::<S, DERIVATIVES>(simd, corners, fraction)
    }
}
