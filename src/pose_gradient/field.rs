//! The interpolated field of each material, and its slopes.

use std::sync::Arc;

use crate::allocation::collected;
use crate::error::Result;
use crate::physics::MAX_MATERIALS;
use crate::pose_gradient::path_sums::{ALONG, PathSums, SLOPE, VALUE};
use crate::raycast::Ray;
use crate::raycast::ray::TRANSVERSE;
use crate::real::Real;
use crate::volume::{Volume, Voxel, Voxels};

/// Which of two neighbours along u and v.
const CORNERS: [[usize; 2]; 4] = [[0, 0], [1, 0], [0, 1], [1, 1]];

/// A volume's partial densities between voxel centres; in the outer half voxel the edge value holds.
pub(super) struct Field<T> {
    volume: Arc<Volume>,
    /// What each code of coded voxels means.
    table: Vec<(T, u8)>,
}

impl<T: Real> Field<T> {
    /// # Errors
    /// `OutOfMemory`.
    pub(super) fn new(volume: Arc<Volume>) -> Result<Self> {
        let table: &[Voxel] = match volume.voxels() {
            Voxels::Coded { table, .. } | Voxels::Texture { table, .. } => table,
            Voxels::Dense { .. } => &[],
        };
        let narrow = table.iter().map(|voxel| (T::of(voxel.density), voxel.label));
        let table = collected(narrow, "the volume's table")?;
        Ok(Self { volume, table })
    }

    pub(super) fn volume(&self) -> &Arc<Volume> {
        &self.volume
    }

    /// Density and label at a flat index.
    pub(super) fn voxel(&self, index: usize) -> (T, usize) {
        let (density, label) = match self.volume.voxels() {
            Voxels::Coded { codes, .. } => self.table[usize::from(codes[index])],
            Voxels::Dense { density, label } => (T::of(f64::from(density[index])), label[index]),
            Voxels::Texture { .. } => unreachable!("volumes in textures are refused"),
        };
        (density, usize::from(label) % MAX_MATERIALS)
    }

    /// The field along `ray`.
    pub(super) fn along<'a>(&'a self, ray: &'a Ray) -> FieldAlong<'a, T> {
        let sides = self.volume.grid().dimensions();
        let strides = [1, sides[0], sides[0] * sides[1]];
        let [u, v] = TRANSVERSE[ray.axis];
        let order = [ray.axis, u, v];
        FieldAlong {
            field: self,
            ray,
            sides: order.map(|axis| sides[axis]),
            strides: order.map(|a| strides[a]),
        }
    }
}

/// A field and a ray; axes in the order (s, u, v).
pub(super) struct FieldAlong<'a, T> {
    pub field: &'a Field<T>,
    pub ray: &'a Ray,
    pub sides: [usize; 3],
    pub strides: [usize; 3],
}

impl<T: Real> FieldAlong<'_, T> {
    /// (s, u, v) at s.
    pub(super) fn point(&self, s: f64) -> [f64; 3] {
        let [u, v] = [0, 1].map(|t| self.ray.base[t] + self.ray.slope[t] * (s - self.ray.centre));
        [s, u, v]
    }

    /// Adds `weight` times the field at s, and its slopes.
    #[inline]
    pub(super) fn add(&self, s: f64, weight: T, sums: &mut PathSums<T>) {
        let cell = Cell::new(s, self.sides[0], self.strides[0]);
        for k in 0..2 {
            self.add_plane(s, cell.first[k], [weight * cell.weight[k], weight * cell.slope[k]], sums);
        }
    }

    /// Adds `weight` times the field on a slice, and its slopes across the driving axis.
    #[inline]
    pub(super) fn add_slice(&self, slice: usize, weight: T, sums: &mut PathSums<T>) {
        self.add_plane(slice as f64, slice * self.strides[0], [weight, T::default()], sums);
    }

    /// Adds what the slice that starts at flat index `first` has at the (u, v) of s, with a weight and its slope along s.
    #[inline(always)]
    fn add_plane(&self, s: f64, first: usize, [weight, along]: [T; 2], sums: &mut PathSums<T>) {
        let [_, u, v] = self.point(s);
        let cu = Cell::new(u, self.sides[1], self.strides[1]);
        let cv = Cell::new(v, self.sides[2], self.strides[2]);
        let moment = T::of(s - self.ray.centre);
        let corners = CORNERS.map(|[ku, kv]| self.field.voxel(first + cu.first[ku] + cv.first[kv]));
        let label = corners[0].1;
        if corners.iter().all(|corner| corner.1 == label) {
            let [p00, p10, p01, p11] = corners.map(|corner| corner.0);
            let [low, high] = [p10 - p00, p11 - p01];
            let [lower, upper] = [p00 + cu.weight[1] * low, p01 + cu.weight[1] * high];
            let value = lower + cv.weight[1] * (upper - lower);
            let du = weight * cu.slope[1] * (low + cv.weight[1] * (high - low));
            let dv = weight * cv.slope[1] * (upper - lower);
            sums.add(label, [weight * value, du, dv, along * value], moment);
            return;
        }
        // Each corner to its own material.
        for ([ku, kv], (density, label)) in CORNERS.into_iter().zip(corners) {
            let value = cu.weight[ku] * cv.weight[kv] * density;
            let du = weight * cu.slope[ku] * cv.weight[kv] * density;
            let dv = weight * cu.weight[ku] * cv.slope[kv] * density;
            sums.add(label, [weight * value, du, dv, along * value], moment);
        }
    }

    /// The field at s, by label, and how it changes from there along the ray.
    pub(super) fn at(&self, s: f64) -> [[f64; 2]; MAX_MATERIALS] {
        let mut sums = PathSums::<T>::default();
        self.add(s, T::of(1.0), &mut sums);
        sums.of.map(|lanes| {
            let wide = lanes.map(Into::<f64>::into);
            let across = wide[SLOPE[0]] * self.ray.slope[0] + wide[SLOPE[1]] * self.ray.slope[1];
            [wide[VALUE], wide[ALONG] + across]
        })
    }
}

/// Two neighbours along one axis.
#[derive(Debug, Clone, Copy)]
struct Cell<T> {
    /// Their parts of the flat index.
    first: [usize; 2],
    weight: [T; 2],
    /// Of the weights.
    slope: [T; 2],
}

impl<T: Real> Cell<T> {
    /// The cell of coordinate `x` along an axis of `n` voxels; on a voxel's centre the upper one.
    #[inline]
    fn new(x: f64, n: usize, stride: usize) -> Self {
        let last = (n - 1) as f64;
        let inside = x >= 0.0 && x < last;
        let limited = x.clamp(0.0, last);
        let lower = (limited as usize).min(n.saturating_sub(2));
        let upper = T::of(limited - lower as f64);
        let slope = T::of(f64::from(u8::from(inside)));
        Self {
            first: [stride * lower, stride * (lower + 1).min(n - 1)],
            weight: [T::of(1.0) - upper, upper],
            slope: [T::default() - slope, slope],
        }
    }
}
