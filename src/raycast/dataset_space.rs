//! Dataset space: a volume's box in mm along its own axes, and the rays that meet it.

use glam::DVec3;

use crate::geometry::Grid;
use crate::raycast::WorldRay;

/// The space in which a volume is the box from 0 to voxels × spacing along each axis, mm.
///
/// An integer index is the *centre* of a voxel, as everywhere in this library, so that an index i is at (i + ½) × spacing: the
/// box's corner is that of voxel (0, 0, 0), and its far corner that of the last voxel. Spacings are the distances of
/// neighbouring voxel centres in the world. Where axes are at right angles, lengths in this space are the world's; of a
/// sheared grid they are not, and the scale of a direction tells by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DatasetSpace {
    grid: Grid,
    spacing: DVec3,
}

/// A half-line in dataset space, whose direction has length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DatasetRay {
    /// Where it starts, mm.
    pub origin: DVec3,
    /// Where it goes.
    pub direction: DVec3,
}

/// Where a ray is inside a volume's box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RaySample {
    /// The ray in dataset space.
    pub ray: DatasetRay,
    /// From the origin to where it enters, mm of dataset space; 0 where it starts inside.
    pub entry: f64,
    /// From the origin to where it leaves; never less than `entry`.
    pub exit: f64,
    /// `entry` in the world, mm.
    pub world_entry: f64,
    /// `exit` in the world, mm.
    pub world_exit: f64,
}

impl DatasetSpace {
    /// That of volumes on `grid`.
    pub fn new(grid: &Grid) -> Self {
        Self { grid: *grid, spacing: grid.spacing() }
    }

    /// The box's far corner, mm.
    pub fn size(&self) -> DVec3 {
        DVec3::from_array(self.grid.dimensions().map(|n| n as f64)) * self.spacing
    }

    /// A world point (mm).
    pub fn point(&self, world: DVec3) -> DVec3 {
        (self.grid.point_to_index(world) + 0.5) * self.spacing
    }

    /// A point of dataset space (mm) in the world.
    pub fn point_to_world(&self, point: DVec3) -> DVec3 {
        self.grid.index_to_world().transform_point3(point / self.spacing - 0.5)
    }

    /// A direction of the world, of length 1, as one of dataset space, and the scale: mm of dataset space that are passed in
    /// one of the world.
    pub fn direction(&self, world: DVec3) -> (DVec3, f64) {
        let moved = self.grid.vector_to_index(world) * self.spacing;
        let scale = moved.length();
        (moved / scale, scale)
    }

    /// A direction of dataset space, of length 1, as one of the world, and the scale: mm of the world that are passed in one
    /// of dataset space.
    pub fn direction_to_world(&self, direction: DVec3) -> (DVec3, f64) {
        let moved = self.grid.index_to_world().transform_vector3(direction / self.spacing);
        let scale = moved.length();
        (moved / scale, scale)
    }

    /// Where a ray is inside the box; `None` when it misses, or when the box lies behind its origin.
    pub fn cast(&self, ray: &WorldRay) -> Option<RaySample> {
        let (direction, scale) = self.direction(ray.direction());
        let ray = DatasetRay { origin: self.point(ray.origin()), direction };
        let [entry, exit] = ray.within(self.size())?;
        Some(RaySample { ray, entry, exit, world_entry: entry / scale, world_exit: exit / scale })
    }
}

impl DatasetRay {
    /// Where the ray is inside the closed box from 0 to `size`, as distances from its origin, by slabs.
    ///
    /// Along an axis on which the direction is exactly 0, of either sign, the ray is inside or outside by comparison. No
    /// threshold decides instead: a tilt of 1e-16 moves a ray from 1e10 mm away by 1e-6 mm, and a denormal one gives a quotient
    /// that is 0 or infinite, never NaN, and so what no tilt gives.
    fn within(&self, size: DVec3) -> Option<[f64; 2]> {
        let [mut entry, mut exit] = [0.0_f64, f64::INFINITY];
        for axis in 0..3 {
            let (from, along) = (self.origin[axis], self.direction[axis]);
            if along == 0.0 {
                if !(0.0..=size[axis]).contains(&from) {
                    return None;
                }
            } else {
                let [near, far] = [(0.0 - from) / along, (size[axis] - from) / along];
                entry = entry.max(near.min(far));
                exit = exit.min(near.max(far));
            }
        }
        (exit >= entry).then_some([entry, exit])
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3};

    use super::*;

    const SIZE: DVec3 = DVec3::new(4.0, 6.0, 10.0);

    fn within(origin: [f64; 3], direction: [f64; 3]) -> Option<[f64; 2]> {
        let ray = WorldRay::new(origin.into(), direction.into()).expect("valid");
        DatasetRay { origin: ray.origin(), direction: ray.direction() }.within(SIZE)
    }

    #[test]
    fn a_ray_along_an_axis_is_inside_by_comparison() {
        assert_eq!(within([1.0, -5.0, 2.0], [0.0, 3.0, 0.0]), Some([5.0, 11.0]));
        for (x, hit) in [(0.0, true), (4.0, true), (-1e-300, false), (4.0 + 1e-15, false)] {
            assert_eq!(within([x, -5.0, 2.0], [0.0, 1.0, 0.0]).is_some(), hit, "x = {x}");
        }
        assert_eq!(within([4.0, 6.0, -1.0], [0.0, 0.0, 1.0]), Some([1.0, 11.0]), "along an edge");
    }

    #[test]
    fn signed_zeros_and_denormal_tilts_are_no_tilt() {
        for origin in [[1.0, -5.0, 2.0], [0.0, -5.0, 10.0], [-1e-9, -5.0, 2.0], [1.0, 9.0, 2.0]] {
            let straight = within(origin, [0.0, 1.0, 0.0]);
            for tilt in [-0.0, 5e-324, -5e-324, 1e-310] {
                let tilted = within(origin, [tilt, 1.0, -tilt]);
                // On a face, a tilt outwards leaves the box where it enters it.
                if origin[0] != 0.0 || tilt == 0.0 {
                    assert_eq!(tilted, straight, "{origin:?}, tilt {tilt:e}");
                }
            }
        }
    }

    #[test]
    fn small_tilts_count() {
        // 1e-17 is far below the last bit of 1; over 1e10 mm it is 1e-7 mm.
        let from = [-0.5e-7, -1e10, 5.0];
        assert_eq!(within(from, [0.0, 1.0, 0.0]), None);
        let [entry, exit] = within(from, [1e-17, 1.0, 0.0]).expect("it arrives inside");
        assert!((entry - 1e10).abs() < 1e-5 && (exit - entry - 6.0).abs() < 1e-5, "{entry} … {exit}");
    }

    #[test]
    fn a_ray_from_inside_enters_at_0_and_one_away_from_the_box_misses() {
        assert_eq!(within([1.0, 2.0, 3.0], [0.0, 0.0, -1.0]), Some([0.0, 3.0]));
        assert_eq!(within([1.0, 7.0, 3.0], [0.0, 1.0, 0.0]), None);
        assert_eq!(within([1.0, 7.0, 3.0], [0.0, -1.0, 0.0]), Some([1.0, 7.0]));
        // From a face outwards: a point of the closed box.
        assert_eq!(within([1.0, 6.0, 3.0], [0.0, 1.0, 0.0]), Some([0.0, 0.0]));
    }

    #[test]
    fn a_ray_through_a_corner_touches_it() {
        let root = 3_f64.sqrt();
        let [entry, exit] = within([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]).expect("through the corner");
        assert!((entry - root).abs() < 1e-15 && (exit - 5.0 * root).abs() < 1e-14);
        let [entry, exit] = within([-1.0, 1.0, -1.0], [1.0, -1.0, 1.0]).expect("a point");
        assert_eq!(entry, exit);
        assert_eq!(within([-1.0, 1.0 - 1e-12, -1.0], [1.0, -1.0, 1.0]), None);
    }

    /// Anisotropic voxels on axes that are askew to each other and to the world.
    fn sheared() -> Grid {
        let columns = DMat3::from_cols(
            DVec3::new(-0.7, 0.02, 0.0),
            DVec3::new(0.05, 0.69, 0.1),
            DVec3::new(0.0, 0.9, 2.5),
        );
        Grid::new([64, 48, 33], DAffine3 { matrix3: columns, translation: DVec3::new(30.0, -12.0, 7.0) })
            .expect("valid")
    }

    #[test]
    fn dataset_space_and_world_are_each_others_inverse() {
        let space = DatasetSpace::new(&sheared());
        assert!(
            (space.point(sheared().index_to_world().translation) - 0.5 * sheared().spacing()).length()
                < 1e-13
        );
        let last = sheared().index_to_world().transform_point3(DVec3::new(63.5, 47.5, 32.5));
        assert!((space.point(last) - space.size()).length() < 1e-12);
        for world in [DVec3::new(3.0, -40.0, 11.0), DVec3::new(-700.0, 20.0, 1e4)] {
            assert!(
                (space.point_to_world(space.point(world)) - world).length() < 1e-15 * world.length() + 1e-12
            );
            let (direction, scale) = space.direction(world.normalize());
            let (back, back_scale) = space.direction_to_world(direction);
            assert!((back - world.normalize()).length() < 1e-15 && (scale * back_scale - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn world_distances_lead_to_the_boxs_faces() {
        let (grid, space) = (sheared(), DatasetSpace::new(&sheared()));
        let mut scales = Vec::new();
        for toward in [[0.3, 0.2, 0.7], [0.5, 0.9, 0.1], [0.05, 0.5, 0.5]] {
            let inside = space.point_to_world(DVec3::from_array(toward) * space.size());
            let ray =
                WorldRay::new(DVec3::new(300.0, -200.0, 150.0), inside - DVec3::new(300.0, -200.0, 150.0));
            let ray = ray.expect("valid");
            let sample = space.cast(&ray).expect("it was aimed at the box");
            scales.push(sample.entry / sample.world_entry);
            for distance in [sample.world_entry, sample.world_exit] {
                let index = grid.point_to_index(ray.origin() + distance * ray.direction());
                let end = DVec3::from_array(grid.dimensions().map(|n| n as f64 - 0.5));
                let off = (index + 0.5).abs().min((index - end).abs()).min_element();
                assert!(off < 1e-11, "{off:e} voxels off a face");
            }
        }
        assert!(scales.iter().all(|scale| (scale - 1.0).abs() > 1e-3), "a sheared grid scales: {scales:?}");
    }

    #[test]
    fn how_voxels_are_stored_does_not_move_a_ray() {
        // The same box with its axes in another order and mirrored, moved together with the ray.
        let grid = Grid::axis_aligned([8, 6, 4], DVec3::new(0.5, 1.0, 2.0), DVec3::new(3.0, -1.0, 0.25))
            .expect("valid");
        let corner = grid.index_to_world().transform_point3(DVec3::new(7.0, 0.0, 3.0));
        let columns = DMat3::from_cols(2.0 * DVec3::NEG_Z, 0.5 * DVec3::NEG_X, DVec3::Y);
        let stored = Grid::new([4, 8, 6], DAffine3 { matrix3: columns, translation: corner }).expect("valid");
        let far = DVec3::new(1024.0, -4096.0, 512.0);
        let moved =
            Grid::new(stored.dimensions(), DAffine3 { translation: corner + far, ..stored.index_to_world() })
                .expect("valid");
        let mut hits = 0;
        for n in 0..200 {
            let turn = f64::from(n);
            let origin = DVec3::new(20.0 * turn.sin(), 20.0 * turn.cos(), 5.0 * (0.7 * turn).sin());
            let towards =
                grid.centre() + DVec3::new((3.0 * turn).sin(), (5.0 * turn).cos(), 1.0) * 3.0 - origin;
            let ray = WorldRay::new(origin, towards).expect("valid");
            let there = WorldRay::new(origin + far, towards).expect("valid");
            let one = DatasetSpace::new(&grid).cast(&ray);
            for other in [DatasetSpace::new(&stored).cast(&ray), DatasetSpace::new(&moved).cast(&there)] {
                assert_eq!(one.is_some(), other.is_some(), "{ray:?}");
                if let (Some(one), Some(other)) = (one, other) {
                    hits += 1;
                    assert!((one.world_entry - other.world_entry).abs() < 1e-11, "{one:?} {other:?}");
                    assert!((one.world_exit - other.world_exit).abs() < 1e-11, "{one:?} {other:?}");
                }
            }
        }
        assert!((50..400).contains(&hits), "{hits} hits");
    }
}
