//! Where one ray's samples are, for a block of steps.

use glam::DVec3;

use crate::parallel::cpu::field::SLACK;

/// 2⁵²: adding it to a whole number from 0 to 2⁵² leaves that number in the low bits, which vectorises where a conversion does
/// not.
const WHOLE: f64 = 4_503_599_627_370_496.0;

/// The bits of a float64 below its exponent.
const LOW: u64 = (1 << 52) - 1;

/// Samples of a ray at N steps, computed for all of them at once in float64.
pub(super) struct Table<const N: usize> {
    /// The samples in index coordinates.
    pub position: [[f64; N]; 3],
    /// The lower corners of their cells.
    pub cell: [[f64; N]; 3],
    /// How far above these corners they are.
    pub fraction: [[f32; N]; 3],
    /// Where that corner is among the field's values; only where `inside`.
    pub index: [u64; N],
    /// All bits set where the sample, and its neighbours up to `reach`, lie in one run of cells and in the field.
    pub inside: [u64; N],
}

/// Neighbours of a sample that are to lie in one run of cells with it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// From the sample to the last of them, without whole voxels along z.
    pub drift: DVec3,
    /// Whole voxels along z.
    pub cells: usize,
}

impl Reach {
    /// The sample alone.
    pub(super) const NONE: Self = Self { drift: DVec3::ZERO, cells: 0 };
}

impl<const N: usize> Table<N> {
    pub(super) const EMPTY: Self = Self {
        position: [[0.0; N]; 3],
        cell: [[0.0; N]; 3],
        fraction: [[0.0; N]; 3],
        index: [0; N],
        inside: [0; N],
    };

    /// Steps `first`, `first` + 1, … from the middle one of the ray that is at `base` at the middle step.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "loops over several arrays of one length vectorise")]
    pub(super) fn fill(&mut self, sides: [usize; 3], base: DVec3, step: DVec3, first: f64, reach: Reach) {
        self.inside = [u64::MAX; N];
        let mut index = [0.0; N];
        for axis in 0..3 {
            let (base, step, drift) = (base[axis], step[axis], reach.drift[axis]);
            let side = sides[axis] as f64;
            let most = side - 3.0 - if axis == 2 { reach.cells as f64 } else { 0.0 };
            for n in 0..N {
                let q = base + (first + n as f64) * step;
                let cell = q.floor();
                let same = cell == (q + drift).floor() && cell >= -1.0 && cell <= most;
                self.inside[n] &= if same { u64::MAX } else { 0 };
                self.position[axis][n] = q;
                self.cell[axis][n] = cell;
                self.fraction[axis][n] = (q - cell) as f32;
                index[n] = index[n] * side + (cell + 1.0);
            }
        }
        for n in 0..N {
            self.index[n] = (index[n] + SLACK as f64 + WHOLE).to_bits() & LOW & self.inside[n];
        }
    }
}
