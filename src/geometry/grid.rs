//! The voxel grid of a volume and its place in the world.

use glam::{DAffine3, DMat3, DVec3};

use crate::error::{Error, Result};
use crate::geometry::MAX_COORDINATE;

/// Most voxels along one axis; keeps every voxel index exact in float32 and in the kernels' integers.
pub(crate) const MAX_DIMENSION: usize = 1 << 15;
/// Most voxels of a volume (4 Gi): flat indices fit 32 bits, in the kernels too.
pub(crate) const MAX_VOXELS: usize = 1 << 32;
/// Smallest distance of neighbouring voxel centres, mm: squares and products of lengths stay far from underflow.
const MIN_SPACING: f64 = 1e-9;
/// Smallest |det| of index→world, relative to the product of its column norms.
const MIN_RELATIVE_DETERMINANT: f64 = 1e-6;

/// A grid of `dimensions[0] × dimensions[1] × dimensions[2]` voxels.
///
/// Voxel (i, j, k) is stored at `(k*n1 + j)*n0 + i`; integer indices are voxel *centres*, so the volume is the box
/// [−0.5, n−0.5] on every axis. Shear, mirroring and anisotropy are all in `index_to_world` (mm).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    dimensions: [usize; 3],
    index_to_world: DAffine3,
    world_to_index: DMat3,
}

impl Grid {
    /// A grid with any invertible index→world map.
    ///
    /// # Errors
    /// `InvalidArgument` when a dimension is 0 or too large, an entry is not finite or above 1e10, a column is shorter
    /// than 1e-9 mm, or the map is singular: |det| is compared with the product of the column norms, so that units do
    /// not matter.
    pub fn new(dimensions: [usize; 3], index_to_world: DAffine3) -> Result<Self> {
        for (axis, &n) in dimensions.iter().enumerate() {
            if n == 0 || n > MAX_DIMENSION {
                return Err(Error::invalid(format!("dimensions[{axis}]"), n, format!("1 … {MAX_DIMENSION}")));
            }
        }
        if dimensions.iter().product::<usize>() > MAX_VOXELS {
            let text = format!("{dimensions:?}");
            return Err(Error::invalid("dimensions", text, format!("at most {MAX_VOXELS} voxels in all")));
        }
        let matrix = index_to_world.matrix3;
        for (entry, value) in index_to_world.to_cols_array().into_iter().enumerate() {
            if !(value.abs() <= MAX_COORDINATE) {
                let argument = format!("index_to_world column {}, row {}", entry / 3, entry % 3);
                return Err(Error::invalid(
                    argument,
                    value,
                    format!("−{MAX_COORDINATE:e} … {MAX_COORDINATE:e} mm"),
                ));
            }
        }
        let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let norms = columns.map(DVec3::length);
        // Not by the norm whether a column is zero: that of 1e-200 underflows.
        let short = |axis: &usize| norms[*axis] < MIN_SPACING && columns[*axis] != DVec3::ZERO;
        if let Some(axis) = (0..3).find(short) {
            let argument = format!("index_to_world column {axis}, length");
            return Err(Error::invalid(argument, norms[axis], format!("at least {MIN_SPACING:e} mm")));
        }
        let relative = matrix.determinant().abs() / norms.iter().product::<f64>();
        // The negation also refuses NaN, which 0/0 gives for a zero column.
        if !(relative >= MIN_RELATIVE_DETERMINANT) || !matrix.inverse().is_finite() {
            let valid = format!(
                "columns independent: |det|/(product of column norms) ≥ {MIN_RELATIVE_DETERMINANT:e}"
            );
            return Err(Error::invalid("index_to_world", format!("singular (ratio {relative:.3e})"), valid));
        }
        Ok(Self { dimensions, index_to_world, world_to_index: matrix.inverse() })
    }

    /// An axis-aligned grid: `spacing` in mm, `origin` the world position of voxel (0,0,0)'s centre.
    pub fn axis_aligned(dimensions: [usize; 3], spacing: DVec3, origin: DVec3) -> Result<Self> {
        Self::new(dimensions, DAffine3 { matrix3: DMat3::from_diagonal(spacing), translation: origin })
    }

    /// The grid of blocks of so many voxels along each axis, at least 1. Its voxel 0 is in the middle of the first block; what
    /// the last ones lack lies beyond this grid's end.
    ///
    /// # Errors
    /// `InvalidArgument` for blocks of 0, and where voxels become too large for a grid.
    pub fn of_blocks(&self, block: [usize; 3]) -> Result<Self> {
        if block.contains(&0) {
            return Err(Error::invalid("block", format!("{block:?}"), "at least 1 along each axis"));
        }
        let factor = DVec3::from_array(block.map(|n| n as f64));
        let matrix3 = self.index_to_world.matrix3 * DMat3::from_diagonal(factor);
        let translation = self.index_to_world.transform_point3(0.5 * (factor - 1.0));
        let dimensions = std::array::from_fn(|axis| self.dimensions[axis].div_ceil(block[axis]));
        Self::new(dimensions, DAffine3 { matrix3, translation })
    }

    /// An axis-aligned grid whose box is centred on the world origin.
    pub fn centred(dimensions: [usize; 3], spacing: DVec3) -> Result<Self> {
        let last = DVec3::from_array(dimensions.map(|n| n as f64 - 1.0));
        Self::axis_aligned(dimensions, spacing, -0.5 * last * spacing)
    }

    /// Voxels along i, j, k.
    pub fn dimensions(&self) -> [usize; 3] {
        self.dimensions
    }

    /// Number of voxels.
    pub fn voxel_count(&self) -> usize {
        self.dimensions.iter().product()
    }

    /// Index → world (mm).
    pub fn index_to_world(&self) -> DAffine3 {
        self.index_to_world
    }

    /// The box's centre in index coordinates.
    pub fn centre_index(&self) -> DVec3 {
        DVec3::from_array(self.dimensions.map(|n| (n as f64 - 1.0) / 2.0))
    }

    /// The box's centre in the world, mm.
    pub fn centre(&self) -> DVec3 {
        self.index_to_world.transform_point3(self.centre_index())
    }

    /// A world point (mm) in index coordinates. Subtracts before it multiplies: a far origin costs no digits.
    pub fn point_to_index(&self, world: DVec3) -> DVec3 {
        self.world_to_index * (world - self.index_to_world.translation)
    }

    /// A world vector (mm) in index units.
    pub fn vector_to_index(&self, world: DVec3) -> DVec3 {
        self.world_to_index * world
    }

    /// Length in mm of a vector given in index units.
    pub fn length_mm(&self, index: DVec3) -> f64 {
        (self.index_to_world.matrix3 * index).length()
    }

    /// Distances between neighbouring voxel centres along i, j, k, mm.
    pub fn spacing(&self) -> DVec3 {
        let matrix = self.index_to_world.matrix3;
        DVec3::new(matrix.x_axis.length(), matrix.y_axis.length(), matrix.z_axis.length())
    }

    /// The smallest of [`Grid::spacing`], mm.
    pub fn smallest_spacing(&self) -> f64 {
        self.spacing().min_element()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spacings_are_lengths_whatever_their_directions() {
        let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -2.0) / 3.0, 0.7);
        let matrix3 = turned * DMat3::from_diagonal(DVec3::new(0.5, -2.0, 3.0));
        let grid = Grid::new([2, 3, 4], DAffine3 { matrix3, translation: DVec3::X }).expect("valid");
        assert!((grid.spacing() - DVec3::new(0.5, 2.0, 3.0)).abs().max_element() < 1e-15, "{grid:?}");
        assert!((grid.smallest_spacing() - 0.5).abs() < 1e-15);
    }

    #[test]
    fn voxels_from_picometres_to_the_largest_coordinate_have_an_inverse() {
        for spacing in [MIN_SPACING, 1.0, MAX_COORDINATE] {
            let columns = DVec3::new(MIN_SPACING, spacing, -MAX_COORDINATE);
            let grid = Grid::axis_aligned([2, 2, 2], columns, DVec3::ZERO).expect("valid");
            assert!((grid.vector_to_index(columns) - DVec3::ONE).length() < 1e-15, "{columns}");
        }
        // Denormal voxels have no inverse; a little larger ones lose their rays to underflow.
        for spacing in [0.0, 5e-324, 1e-310, 1e-300, 1e-160, 1e-100, 0.9 * MIN_SPACING] {
            let error = Grid::axis_aligned([2, 2, 2], DVec3::new(1.0, -spacing, 1.0), DVec3::ZERO);
            let message = error.expect_err("too small").to_string();
            assert!(message.starts_with("index_to_world"), "{spacing}: {message}");
        }
    }
}
