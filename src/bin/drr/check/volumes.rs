//! Small volumes to look through. Densities of up to 1 g/cm³ are eighths, exact in every precision.

use std::sync::Arc;

use drr::geometry::Grid;
use drr::physics::{Calibration, Thresholds};
use drr::volume::{Classification, Volume};
use glam::{DAffine3, DMat3, DVec3};

/// The sides of most volumes, voxels.
pub(crate) const SMALL: [usize; 3] = [5, 4, 6];
/// The label of soft tissue.
const SOFT_TISSUE: u8 = 2;

pub(crate) fn classification() -> Classification {
    Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in")
}

/// Voxels of 1 mm, the first one centred on the origin: index and world coordinates are the same.
pub(crate) fn unit_grid(n: [usize; 3]) -> Grid {
    spaced_grid(n, DVec3::ONE)
}

/// The first voxel is centred on the origin.
pub(crate) fn spaced_grid(n: [usize; 3], spacing: DVec3) -> Grid {
    Grid::axis_aligned(n, spacing, DVec3::ZERO).expect("valid")
}

/// Any columns, mm; the first voxel is centred on `origin`.
pub(crate) fn affine_grid(n: [usize; 3], columns: [[f64; 3]; 3], origin: DVec3) -> Grid {
    let [x, y, z] = columns.map(DVec3::from_array);
    Grid::new(n, DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: origin }).expect("valid")
}

/// 0 … 1 from an integer.
pub(crate) fn noise(n: usize) -> f64 {
    let mut z = (n as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Integer CT numbers and labels by voxel.
pub(crate) fn volume(grid: Grid, voxel: impl Fn([usize; 3]) -> (i16, u8)) -> Arc<Volume> {
    let [n0, n1, _] = grid.dimensions();
    let at = |i: usize| voxel([i % n0, i / n0 % n1, i / (n0 * n1)]);
    let (hu, labels): (Vec<_>, Vec<_>) = (0..grid.voxel_count()).map(at).unzip();
    Arc::new(Volume::from_int16(grid, &hu, Some(&labels), &classification()).expect("valid"))
}

/// Density and material differ from voxel to voxel, all four materials.
pub(crate) fn mixed(grid: Grid) -> Arc<Volume> {
    let [n0, n1, _] = grid.dimensions();
    volume(grid, |[i, j, k]| {
        let n = (k * n1 + j) * n0 + i;
        (-1000 + 125 * (9.0 * noise(n)) as i16, (4.0 * noise(n + 7919)) as u8)
    })
}

/// Soft tissue whose density differs from voxel to voxel, in float32.
pub(crate) fn grey(grid: Grid) -> Arc<Volume> {
    let hu: Vec<f32> =
        (0..grid.voxel_count()).map(|i| -1000.0 + 125.0 * (9.0 * noise(i)).floor() as f32).collect();
    let labels = vec![SOFT_TISSUE; hu.len()];
    Arc::new(Volume::from_float32(grid, &hu, Some(&labels), &classification()).expect("valid"))
}

/// Soft tissue of 1 g/cm³.
pub(crate) fn water(grid: Grid) -> Arc<Volume> {
    uniform(grid, SOFT_TISSUE)
}

/// Everything of 1 g/cm³ and one label.
pub(crate) fn uniform(grid: Grid, label: u8) -> Arc<Volume> {
    volume(grid, |_| (0, label))
}
