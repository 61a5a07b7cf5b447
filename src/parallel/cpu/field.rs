//! The voxels, with a border of zeros.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::{Error, Result};
use crate::parallel::ParallelGeometry;
use crate::real::Real;

/// Zeros before and behind the voxels: lanes that do not count may read past the ends of a line.
pub(super) const SLACK: usize = 64;

/// Layers of x that are copied together: a whole line of the cache of the caller's voxels.
const LAYERS: usize = 16;

/// Bounds of index coordinates x, y, z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits(pub [[f64; 2]; 3]);

impl Limits {
    /// Where a field with these sides, border counted, is not 0.
    pub(super) fn of(sides: [usize; 3]) -> Self {
        Self(sides.map(|side| [-1.0, side as f64 - 2.0]))
    }
}

/// The trilinear field. Voxels are held with z fastest, where neighbouring rows of the detector find theirs side by side, and
/// with one layer of zeros all around: no sample within one voxel of the volume asks whether it is outside.
#[derive(Debug, Clone)]
pub(in crate::parallel) struct Field<T> {
    /// With the border, x, y, z.
    sides: [usize; 3],
    /// Between two slacks.
    values: Vec<T>,
}

/// The field and its slope at a point, per voxel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Sample<T> {
    pub value: T,
    pub slope: [T; 3],
}

/// Sides with the border.
pub(in crate::parallel) fn padded(dimensions: [usize; 3]) -> [usize; 3] {
    dimensions.map(|n| n + 2)
}

impl<T: Real> Field<T> {
    /// Of voxels with x fastest.
    ///
    /// # Errors
    /// `InvalidArgument` when there is not one value per voxel, or one is not finite; `OutOfMemory`.
    pub(in crate::parallel) fn new(geometry: &ParallelGeometry, values: &[T]) -> Result<Self> {
        check(geometry.dimensions, values)?;
        let sides = padded(geometry.dimensions);
        let count = sides.iter().product::<usize>() + 2 * SLACK;
        let mut field = Self { sides, values: filled(count, T::default(), "the volume")? };
        field.fill(values);
        Ok(field)
    }

    fn fill(&mut self, values: &[T]) {
        let [nx, ny, nz] = self.sides.map(|n| n - 2);
        let [_, sy, sz] = self.sides;
        let layers = &mut self.values[SLACK + sy * sz..][..nx * sy * sz];
        layers.par_chunks_mut(LAYERS * sy * sz).enumerate().for_each(|(n, layers)| {
            let first = n * LAYERS;
            let width = LAYERS.min(nx - first);
            for (j, k) in (0..ny).flat_map(|j| (0..nz).map(move |k| (j, k))) {
                let piece = &values[(k * ny + j) * nx + first..][..width];
                for (layer, &value) in layers.chunks_exact_mut(sy * sz).zip(piece) {
                    layer[(j + 1) * sz + k + 1] = value;
                }
            }
        });
    }

    /// Sides and values, with the border but no slack, z fastest.
    pub(in crate::parallel) fn into_parts(mut self) -> ([usize; 3], Vec<T>) {
        self.values.truncate(self.values.len() - SLACK);
        self.values.drain(..SLACK);
        (self.sides, self.values)
    }

    /// With the border: x, y, z.
    pub(super) fn sides(&self) -> [usize; 3] {
        self.sides
    }

    /// Where it is not 0.
    pub(super) fn limits(&self) -> Limits {
        Limits::of(self.sides)
    }

    /// Voxels and border with z fastest, between two slacks.
    pub(super) fn values(&self) -> &[T] {
        &self.values
    }

    /// The field at an index-space point. On a plane through voxel centres, its slope is the upper cell's.
    pub(super) fn at(&self, point: [f64; 3]) -> Sample<T> {
        let mut cell = [0; 3];
        let mut upper = [T::default(); 3];
        for axis in 0..3 {
            let floor = point[axis].floor();
            if !(floor >= -1.0 && floor <= (self.sides[axis] - 3) as f64) {
                return Sample::default();
            }
            cell[axis] = (floor + 1.0) as usize;
            upper[axis] = T::of(point[axis] - floor);
        }
        let [_, sy, sz] = self.sides;
        let first = SLACK + (cell[0] * sy + cell[1]) * sz + cell[2];
        let [fx, fy, fz] = upper;
        let v = &self.values;
        let pair = |index: usize| (v[index], v[index + 1] - v[index]);
        let [p00, p01, p10, p11] = [first, first + sz, first + sy * sz, first + sy * sz + sz].map(pair);
        let along_z = |(value, slope): (T, T)| value + fz * slope;
        let [v00, v01, v10, v11] = [p00, p01, p10, p11].map(along_z);
        let (v0, v1) = (v00 + fy * (v01 - v00), v10 + fy * (v11 - v10));
        let dy0 = v01 - v00;
        let dz = |a: (T, T), b: (T, T)| a.1 + fy * (b.1 - a.1);
        let (dz0, dz1) = (dz(p00, p01), dz(p10, p11));
        Sample {
            value: v0 + fx * (v1 - v0),
            slope: [v1 - v0, dy0 + fx * (v11 - v10 - dy0), dz0 + fx * (dz1 - dz0)],
        }
    }
}

fn check<T: Real>([nx, ny, nz]: [usize; 3], values: &[T]) -> Result<()> {
    if values.len() != nx * ny * nz {
        let valid = format!("{}, nx·ny·nz", nx * ny * nz);
        return Err(Error::invalid("volume's number of values", values.len(), valid));
    }
    let finite = |value: &T| Into::<f64>::into(*value).is_finite();
    if let Some(bad) = values.par_iter().position_first(|value| !finite(value)) {
        let at = [bad % nx, bad / nx % ny, bad / (nx * ny)];
        let value: f64 = values[bad].into();
        return Err(Error::invalid(format!("volume at voxel {at:?}"), value, "finite values"));
    }
    Ok(())
}
