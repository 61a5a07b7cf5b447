//! One ray in exact arithmetic. Every float64 is a rational number, so that the ray of a pixel, its crossings with
//! planes and its samples are too; nothing here rounds but the length in mm.

use drr::geometry::{DetectorPose, Grid, Projection, View};
use glam::DVec3;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

/// An exact number.
pub(super) type Exact = BigRational;
pub(super) type Vector = [Exact; 3];

pub(super) fn exact(x: f64) -> Exact {
    BigRational::from_float(x).expect("the numbers of a valid view and grid are finite")
}

pub(super) fn half() -> Exact {
    exact(0.5)
}

fn vector(v: DVec3) -> Vector {
    v.to_array().map(exact)
}

fn add(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|axis| &a[axis] + &b[axis])
}

fn scaled(a: &Vector, by: &Exact) -> Vector {
    std::array::from_fn(|axis| &a[axis] * by)
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|axis| &a[axis] - &b[axis])
}

fn dot(a: &Vector, b: &Vector) -> Exact {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [[1, 2], [2, 0], [0, 1]].map(|[i, j]| &a[i] * &b[j] - &a[j] * &b[i])
}

/// World vectors to index space.
struct ToIndex {
    rows: [Vector; 3],
}

impl ToIndex {
    fn of(grid: &Grid) -> Self {
        let matrix = grid.index_to_world().matrix3;
        let [a, b, c] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(vector);
        let determinant = dot(&a, &cross(&b, &c));
        let rows = [cross(&b, &c), cross(&c, &a), cross(&a, &b)];
        Self { rows: rows.map(|row| row.map(|x| x / &determinant)) }
    }

    fn of_vector(&self, world: &Vector) -> Vector {
        self.rows.each_ref().map(|row| dot(row, world))
    }
}

/// The points `origin + t·direction`, index space, for t within `limits`.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub(super) origin: Vector,
    pub(super) direction: Vector,
    limits: [Option<Exact>; 2],
    /// World length of `direction`, mm.
    pub(super) mm: f64,
    /// The lines `BESIDE` pixels before and behind along the columns, then along the rows, where they are asked for.
    beside: Vec<[(Vector, Vector); 2]>,
}

/// Pixels: so few that differences are derivatives to the last digit of float64.
const BESIDE: f64 = 1.0 / (1_u64 << 40) as f64;

impl Line {
    /// The ray of a pixel (column, row), as the documentation of [`View`] defines it.
    pub(crate) fn of(view: &View, grid: &Grid, size: [usize; 2], pixel: [usize; 2]) -> Self {
        match view {
            View::Pose(pose) => Self::segment(pose, grid, pixel.map(|n| exact(n as f64))),
            View::Projection(projection) => {
                Self::half_line(projection, grid, size, pixel.map(|n| exact(n as f64)))
            }
        }
    }

    /// The same with the lines beside it, which say how wide its pixel is.
    pub(crate) fn with_pixel(self, view: &View, grid: &Grid, size: [usize; 2], pixel: [usize; 2]) -> Self {
        let line = |axis: usize, by: f64| {
            let mut at = pixel.map(|n| exact(n as f64));
            at[axis] += exact(by);
            let line = match view {
                View::Pose(pose) => Self::segment(pose, grid, at),
                View::Projection(projection) => Self::half_line(projection, grid, size, at),
            };
            (line.origin, line.direction)
        };
        let beside = (0..2).map(|axis| [line(axis, -BESIDE), line(axis, BESIDE)]).collect();
        Self { beside, ..self }
    }

    /// Half the extents along all axes, in the plane where the coordinate along `axis` is `s`, of the rectangle with
    /// the second moments of the pixel that is mapped there to first order.
    pub(super) fn half_widths(&self, axis: usize, s: &Exact) -> Vector {
        let crossing = |(origin, direction): &(Vector, Vector)| {
            let t = (s - &origin[axis]) / &direction[axis];
            add(origin, &scaled(direction, &t))
        };
        let half_sides = self.beside.iter().map(|[before, behind]| {
            scaled(&minus(&crossing(behind), &crossing(before)), &exact(0.25 / BESIDE))
        });
        let squares = half_sides.fold(vector(DVec3::ZERO), |sum, side| {
            add(&sum, &std::array::from_fn(|axis| &side[axis] * &side[axis]))
        });
        squares.map(|square| root(&square))
    }

    fn segment(pose: &DetectorPose, grid: &Grid, [i, j]: [Exact; 2]) -> Self {
        let to_index = ToIndex::of(grid);
        let origin = vector(grid.index_to_world().translation);
        let column = scaled(&vector(pose.column_step), &i);
        let row = scaled(&vector(pose.row_step), &j);
        let source = vector(pose.source);
        let along = minus(&add(&add(&vector(pose.first_pixel), &column), &row), &source);
        Self {
            origin: to_index.of_vector(&minus(&source, &origin)),
            direction: to_index.of_vector(&along),
            limits: [Some(exact(0.0)), Some(exact(1.0))],
            mm: length(&along),
            beside: Vec::new(),
        }
    }

    /// Where the two planes of the pixel meet, from the source on.
    fn half_line(
        projection: &Projection,
        grid: &Grid,
        [width, height]: [usize; 2],
        [i, j]: [Exact; 2],
    ) -> Self {
        let [x, y, w] = [0, 1, 3].map(|row| {
            let row = projection.matrix.row(row);
            (vector(row.truncate()), exact(row.w))
        });
        let clip = |pixel: Exact, n: usize| (pixel * exact(2.0) + exact(1.0)) / exact(n as f64) - exact(1.0);
        let plane = |(n, d): &(Vector, Exact), at: &Exact| (minus(n, &scaled(&w.0, at)), d - &w.1 * at);
        let (a, b) = (plane(&x, &clip(i, width)), plane(&y, &-clip(j, height)));
        let crossing = cross(&a.0, &b.0);
        let towards = scaled(&cross(&b.0, &crossing), &-&a.1);
        let point = add(&towards, &scaled(&cross(&a.0, &crossing), &b.1));
        let point = scaled(&point, &dot(&crossing, &crossing).recip());
        // Rays run towards growing w.
        let forward = if dot(&w.0, &cross(&x.0, &y.0)).is_negative() { exact(-1.0) } else { exact(1.0) };
        let along = scaled(&crossing, &forward);

        let to_index = ToIndex::of(grid);
        let translation = vector(grid.index_to_world().translation);
        let mut line = Self {
            origin: to_index.of_vector(&minus(&point, &translation)),
            direction: to_index.of_vector(&along),
            limits: [None, None],
            mm: length(&along),
            beside: Vec::new(),
        };
        if !w.0.iter().all(Zero::is_zero) {
            // The source may lie beside the line by what float32 rounds: its place along the driving axis counts.
            let axis = line.driving_axes()[0];
            let source = to_index.of_vector(&minus(&vector(projection.source), &translation));
            line.limits[0] = Some((&source[axis] - &line.origin[axis]) / &line.direction[axis]);
        }
        line
    }

    /// The line moved by an index-space vector.
    pub(crate) fn moved(&self, by: [f64; 3]) -> Self {
        Self { origin: add(&self.origin, &by.map(exact)), ..self.clone() }
    }

    /// The axis of the largest component of the direction and those equal to it but for rounding, largest first.
    pub(super) fn driving_axes(&self) -> Vec<usize> {
        let size = self.direction.each_ref().map(Signed::abs);
        let largest = size.iter().max().expect("three axes");
        let nearly = largest * exact(1.0 - 1e-12);
        let mut axes: Vec<_> = (0..3).filter(|&axis| size[axis] >= nearly).collect();
        axes.sort_by(|&a, &b| size[b].cmp(&size[a]));
        axes
    }

    pub(super) fn at(&self, t: &Exact) -> Vector {
        add(&self.origin, &scaled(&self.direction, t))
    }

    /// The part inside the box of `n` voxels, as an interval of t. Half-open: [−½, n−½).
    pub(super) fn span(&self, n: [usize; 3]) -> Option<[Exact; 2]> {
        let [mut from, mut to] = self.limits.clone();
        for (axis, n) in n.into_iter().enumerate() {
            let faces = [-0.5, n as f64 - 0.5].map(exact);
            let (origin, direction) = (&self.origin[axis], &self.direction[axis]);
            if direction.is_zero() {
                if *origin < faces[0] || *origin >= faces[1] {
                    return None;
                }
                continue;
            }
            let [a, b] = faces.map(|face| (face - origin) / direction);
            let (enter, leave) = if a < b { (a, b) } else { (b, a) };
            from = Some(from.map_or(enter.clone(), |from| from.max(enter)));
            to = Some(to.map_or(leave.clone(), |to| to.min(leave)));
        }
        match (from, to) {
            (Some(from), Some(to)) if from < to => Some([from, to]),
            _ => None,
        }
    }

    /// The ends of `span`, and every t between at which a coordinate is an integer + `offset`, ascending.
    pub(super) fn cuts(&self, span: &[Exact; 2], offset: &Exact) -> Vec<Exact> {
        let mut cuts = span.to_vec();
        let [enter, leave] = span.each_ref().map(|t| self.at(t));
        for (axis, (a, b)) in enter.into_iter().zip(leave).enumerate() {
            if a == b {
                continue;
            }
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            let mut plane = (low - offset).ceil() + offset;
            while plane <= high {
                cuts.push((&plane - &self.origin[axis]) / &self.direction[axis]);
                plane += exact(1.0);
            }
        }
        cuts.sort();
        cuts.dedup();
        cuts
    }
}

/// The square root, to the last digits of float64.
fn root(square: &Exact) -> Exact {
    if square.is_zero() {
        return exact(0.0);
    }
    // Scaled by an even power of two.
    let scale = 2.0_f64.powi((0.5 * square.to_f64().expect("finite").log2()).clamp(-400.0, 400.0) as i32);
    let unit = square / (exact(scale) * exact(scale));
    exact(unit.to_f64().expect("finite").sqrt()) * exact(scale)
}

fn length(v: &Vector) -> f64 {
    // Scaled by a power of two, so that squares neither overflow nor underflow.
    let largest = v.iter().map(Signed::abs).max().expect("three components");
    let scale = exact(2_f64.powi(largest.to_f64().expect("finite").log2().clamp(-1000.0, 1000.0) as i32));
    let unit = scaled(v, &scale.recip());
    dot(&unit, &unit).to_f64().expect("finite").sqrt() * scale.to_f64().expect("finite")
}
