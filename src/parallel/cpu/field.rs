//! The voxels, with a border of zeros.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::{Error, Result};
use crate::parallel::ParallelGeometry;
use crate::real::Real;

/// The trilinear field. Voxels are held with z fastest, where neighbouring rows of the detector find theirs side by side, and
/// with one layer of zeros all around: no sample within one voxel of the volume asks whether it is outside.
#[derive(Debug, Clone)]
pub(super) struct Field<T> {
    /// With the border, x, y, z.
    sides: [usize; 3],
    values: Vec<T>,
}

/// The field and its slope at a point, per voxel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Sample<T> {
    pub value: T,
    pub slope: [T; 3],
}

impl<T: Real> Field<T> {
    /// Of voxels with x fastest.
    ///
    /// # Errors
    /// `InvalidArgument` when there is not one value per voxel, or one is not finite; `OutOfMemory`.
    pub(super) fn new(geometry: &ParallelGeometry, values: &[T]) -> Result<Self> {
        let [nx, ny, nz] = geometry.dimensions;
        if values.len() != nx * ny * nz {
            let valid = format!("{}, nx·ny·nz", nx * ny * nz);
            return Err(Error::invalid("volume's number of values", values.len(), valid));
        }
        let finite = |value: &T| Into::<f64>::into(*value).is_finite();
        if let Some(bad) = values.par_iter().position_first(|value| !finite(value)) {
            let at = [bad % nx, bad / nx % ny, bad / (nx * ny)];
            return Err(Error::invalid(
                format!("volume at voxel {at:?}"),
                Into::<f64>::into(values[bad]),
                "finite values",
            ));
        }
        let sides = [nx + 2, ny + 2, nz + 2];
        let mut padded = filled(sides.iter().product(), T::default(), "the volume")?;
        padded.par_chunks_mut(sides[1] * sides[2]).enumerate().for_each(|(i, slab)| {
            if !(1..=nx).contains(&i) {
                return;
            }
            for (j, line) in slab.chunks_mut(sides[2]).enumerate().skip(1).take(ny) {
                for (k, value) in line[1..=nz].iter_mut().enumerate() {
                    *value = values[(k * ny + j - 1) * nx + i - 1];
                }
            }
        });
        Ok(Self { sides, values: padded })
    }

    /// With the border: x, y, z.
    pub(super) fn sides(&self) -> [usize; 3] {
        self.sides
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
        let first = (cell[0] * sy + cell[1]) * sz + cell[2];
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
