//! One material's density in exact arithmetic, and its integral along a line by each algorithm's rule.

use drr::Algorithm;
use drr::volume::{Volume, Voxel};
use num_traits::{Signed, ToPrimitive, Zero};

use super::line::{Exact, Line, Vector, exact, half};

/// A scalar field on the voxels.
pub(super) struct Field {
    values: Vec<Exact>,
    n: [usize; 3],
}

impl Field {
    /// `value` of each voxel.
    pub(super) fn of(volume: &Volume, value: impl Fn(Voxel) -> f64) -> Self {
        let grid = volume.grid();
        let values = (0..grid.voxel_count()).map(|i| exact(value(volume.voxels().get(i)))).collect();
        Self { values, n: grid.dimensions() }
    }

    /// The integral along the line in (unit of the field)·mm, for each choice of driving axis that rounding leaves
    /// open.
    pub(super) fn integrals(&self, line: &Line, algorithm: Algorithm) -> Vec<f64> {
        let Some(span) = line.span(self.n) else {
            return vec![0.0];
        };
        let mm = |integral: Exact| integral.to_f64().expect("finite") * line.mm;
        // The weights of every rule sum to the chord.
        if self.values.iter().all(|value| *value == self.values[0]) {
            return vec![mm((&span[1] - &span[0]) * &self.values[0])];
        }
        let along = |axis: usize, step: f64, at_centres: bool| {
            mm(cells(line, &span, axis, (step, at_centres), |_, point| self.interpolated(point)))
        };
        let covered = |axis: usize| {
            let mean = |s: &Exact, point: &Vector| self.covered(point, axis, &line.half_widths(axis, s));
            mm(cells(line, &span, axis, (1.0, true), mean))
        };
        match algorithm {
            Algorithm::Siddon => vec![mm(self.siddon(line, &span))],
            Algorithm::Exact => vec![mm(self.trilinear(line, &span))],
            Algorithm::Joseph => line.driving_axes().into_iter().map(|axis| along(axis, 1.0, true)).collect(),
            Algorithm::DistanceDriven => line.driving_axes().into_iter().map(covered).collect(),
            Algorithm::March { step } => {
                line.driving_axes().into_iter().map(|axis| along(axis, step, false)).collect()
            }
        }
    }

    /// Voxels are constant on [i−½, i+½).
    fn siddon(&self, line: &Line, span: &[Exact; 2]) -> Exact {
        let voxel = |x: &Exact, n: usize| (x + half()).floor().to_usize().expect("inside").min(n - 1);
        let cuts = line.cuts(span, &half());
        let piece = |pair: &[Exact]| {
            let middle = line.at(&((&pair[0] + &pair[1]) * half()));
            let value = self.at(std::array::from_fn(|axis| voxel(&middle[axis], self.n[axis])));
            if value.is_zero() { exact(0.0) } else { (&pair[1] - &pair[0]) * value }
        };
        cuts.windows(2).map(piece).sum()
    }

    /// The interpolated field is a cubic along each piece, for which Simpson's rule is exact.
    fn trilinear(&self, line: &Line, span: &[Exact; 2]) -> Exact {
        let cuts = line.cuts(span, &exact(0.0));
        let piece = |pair: &[Exact]| {
            let [begin, middle, end] = [&pair[0], &((&pair[0] + &pair[1]) * half()), &pair[1]]
                .map(|t| self.interpolated(&line.at(t)));
            (&pair[1] - &pair[0]) * (begin + middle * exact(4.0) + end) / exact(6.0)
        };
        cuts.windows(2).map(piece).sum()
    }

    /// The mean of a slice of `along` over a rectangle around a point in it, of which what is beyond the border counts
    /// for the outermost voxels.
    fn covered(&self, point: &Vector, along: usize, half_widths: &Vector) -> Exact {
        let parts: [_; 3] = std::array::from_fn(|axis| {
            if axis == along {
                // A slice is one voxel thick, and the point in its middle.
                return vec![(point[axis].to_usize().expect("a slice"), exact(1.0))];
            }
            parts(&point[axis], &half_widths[axis], self.n[axis])
        });
        let [x, y, z] = &parts;
        let mut sum = exact(0.0);
        for ((k, of_z), (j, of_y)) in z.iter().flat_map(|z| y.iter().map(move |y| (z, y))) {
            let row: Exact = x.iter().map(|(i, of_x)| self.at([*i, *j, *k]) * of_x).sum();
            sum += row * of_y * of_z;
        }
        sum
    }

    fn at(&self, [i, j, k]: [usize; 3]) -> &Exact {
        &self.values[(k * self.n[1] + j) * self.n[0] + i]
    }

    /// Linear between centres along every axis; beyond the outermost centres the edge holds.
    fn interpolated(&self, point: &Vector) -> Exact {
        let cell: [_; 3] = std::array::from_fn(|axis| {
            let last = self.n[axis] - 1;
            let held = point[axis].clone().max(exact(0.0)).min(exact(last as f64));
            let lower = held.floor().to_usize().expect("held within the volume");
            (lower, (lower + 1).min(last), held - exact(lower as f64))
        });
        let [x, y, z] = &cell;
        let row = |j: usize, k: usize| lerp(self.at([x.0, j, k]), self.at([x.1, j, k]), &x.2);
        let plane = |k: usize| lerp(&row(y.0, k), &row(y.1, k), &y.2);
        lerp(&plane(z.0), &plane(z.1), &z.2)
    }
}

/// One sample per cell [−½ + k·step, −½ + (k+1)·step] of the axis, weighted by the part inside: at the cell's centre,
/// or at that of the part.
fn cells(
    line: &Line,
    span: &[Exact; 2],
    axis: usize,
    (step, at_centres): (f64, bool),
    sample: impl Fn(&Exact, &Vector) -> Exact,
) -> Exact {
    let step = exact(step);
    let coordinate = |t: &Exact| &line.origin[axis] + t * &line.direction[axis];
    let (a, b) = (coordinate(&span[0]), coordinate(&span[1]));
    let (enter, leave) = if a < b { (a, b) } else { (b, a) };
    let mut lower = ((&enter + half()) / &step).floor() * &step - half();
    let mut sum = exact(0.0);
    while lower < leave {
        let upper = &lower + &step;
        let (from, to) = ((&lower).max(&enter), (&upper).min(&leave));
        let s = if at_centres { (&lower + &upper) * half() } else { (from + to) * half() };
        let t = (&s - &line.origin[axis]) / &line.direction[axis];
        sum += (to - from) * sample(&s, &line.at(&t));
        lower = upper;
    }
    sum / line.direction[axis].abs()
}

/// The smallest half-width of a footprint, voxels.
const POINT: f64 = 1e-6;

/// The parts of [middle − width, middle + width] that are over each of `n` voxels.
fn parts(middle: &Exact, width: &Exact, n: usize) -> Vec<(usize, Exact)> {
    let (last, width) = (exact((n - 1) as f64), width.clone().max(exact(POINT)));
    let voxel = |x: Exact| (x + half()).floor().max(exact(0.0)).min(last.clone()).to_usize().expect("inside");
    let (first, end) = (voxel(middle - &width), voxel(middle + &width));
    let below = |face: Exact| (half() + (face - middle) / &width * half()).max(exact(0.0)).min(exact(1.0));
    let mut before = exact(0.0);
    let part = |voxel: usize| {
        let until = if voxel == end { exact(1.0) } else { below(exact(voxel as f64) + half()) };
        let part = &until - &before;
        before = until;
        (voxel, part)
    };
    (first..=end).map(part).collect()
}

fn lerp(a: &Exact, b: &Exact, t: &Exact) -> Exact {
    if a == b || t.is_zero() { a.clone() } else { a + (b - a) * t }
}
