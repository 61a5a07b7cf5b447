//! Grids: anisotropic, far away, thin, sheared, mirrored, nearly singular.

use drr::geometry::{DetectorPose, Grid, View};
use glam::{DAffine3, DMat3, DVec3};

use crate::check::case::{Case, Set, segment};
use crate::check::volumes::{SMALL, affine_grid, grey, mixed, spaced_grid, unit_grid, water};

pub(super) fn cases() -> Vec<Case> {
    [anisotropic(), far_sources(), far_volumes(), thin(), affine(), refused()].into_iter().flatten().collect()
}

/// From a distance through a point of the volume, given in voxels, along a direction in mm.
fn through(grid: &Grid, at: DVec3, direction: DVec3, distance: f64) -> DetectorPose {
    let at = grid.index_to_world().transform_point3(at);
    segment(at - distance * direction.normalize(), at + distance * direction.normalize())
}

fn anisotropic() -> Vec<Case> {
    let mut cases = Vec::new();
    for spacing in [
        [0.3, 0.3, 10.0],
        [0.001, 1.0, 1.0],
        [1.0, 1000.0, 1.0],
        [0.01, 0.3, 10.0],
        [1e-3, 1e-3, 1e-3],
        [100.0, 100.0, 0.1],
    ] {
        let grid = spaced_grid(SMALL, DVec3::from_array(spacing));
        for direction in [[1.0, 0.2, 0.1], [0.1, 0.2, 1.0]] {
            let pose = through(&grid, DVec3::new(2.2, 1.3, 2.7), DVec3::from_array(direction), 5000.0);
            let name = format!("{spacing:?} mm along {direction:?}");
            cases.push(Case::exact(11, name, Set::posed(mixed(grid), [1, 1], pose)));
        }
    }
    cases
}

/// The nearer the parallel limit, the larger the numbers that cancel.
fn far_sources() -> Vec<Case> {
    let mut cases = Vec::new();
    let grid = unit_grid(SMALL);
    for distance in [1e4, 1e6, 1e9] {
        for (how, direction) in [
            ("oblique", DVec3::new(0.9, 0.3, 0.2)),
            ("along x", DVec3::X),
            ("steep", DVec3::new(0.01, -0.02, 1.0)),
        ] {
            let at = DVec3::new(2.2, 1.3, 2.7);
            let source = at - distance * direction.normalize();
            let pose = segment(source, at + 500.0 * direction.normalize());
            let name = format!("from {distance:.0e} mm, {how}");
            cases.push(Case::exact(12, name, Set::posed(mixed(grid), [1, 1], pose)));
        }
    }
    // Next to so small a volume everything that is taken from the source's end of the ray shows.
    let small = spaced_grid(SMALL, DVec3::splat(1e-3));
    let at = small.centre();
    let pose = segment(
        at - 1e9 * DVec3::new(0.9, 0.3, 0.2).normalize(),
        at + 40.0 * DVec3::new(0.9, 0.3, 0.2).normalize(),
    );
    let set = Set::new(mixed(small), [1, 1], View::Pose(pose));
    cases.push(Case::exact(12, "from 1e9 mm, voxels of a micrometre", set));
    cases
}

/// Scanner coordinates far from the origin cancel before anything is rounded.
fn far_volumes() -> Vec<Case> {
    let mut cases = Vec::new();
    for offset in [1e3, 65_536.0, 1e6 + 0.3, 1e9] {
        for direction in [DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.3, 0.2, 0.8)] {
            let origin = DVec3::new(offset, -0.7 * offset, 0.3 * offset);
            let grid = affine_grid(SMALL, [[1.0, 0.0, 0.0], [0.0, 1.2, 0.0], [0.0, 0.0, 0.9]], origin);
            let pose = through(&grid, DVec3::new(2.2, 1.3, 2.7), direction, 700.0);
            let name = format!("{offset:.1e} mm away, along {direction}");
            // Float32 uniforms cannot say where a source is to a mm there; poses can.
            let set = if offset < 1e5 {
                Set::posed(mixed(grid), [1, 1], pose)
            } else {
                Set::new(mixed(grid), [1, 1], View::Pose(pose))
            };
            cases.push(Case::exact(13, name, set));
        }
    }
    cases
}

fn thin() -> Vec<Case> {
    let mut cases = Vec::new();
    for n in [[1, 1, 1], [1, 5, 6], [5, 1, 6], [5, 6, 1], [7, 1, 1], [1, 7, 1], [1, 1, 7], [2, 2, 2]] {
        let grid = unit_grid(n);
        for direction in [DVec3::new(1.0, 0.3, 0.2), DVec3::new(0.05, 0.04, 1.0)] {
            let at = 0.5 * DVec3::from_array(n.map(|n| n as f64 - 1.0)) + DVec3::splat(0.2);
            let pose = through(&grid, at, direction, 30.0);
            let name = format!("{n:?} voxels along {direction}");
            cases.push(Case::exact(14, name, Set::posed(mixed(grid), [1, 1], pose)));
        }
    }
    let grid = unit_grid([1, 1, 4096]);
    let pose = through(&grid, DVec3::new(0.1, 0.2, 2000.0), DVec3::new(1e-6, 0.0, 1.0), 9000.0);
    cases.push(Case::exact(14, "a long column of water", Set::posed(water(grid), [1, 1], pose)));
    cases
}

fn affine() -> Vec<Case> {
    let c = (0.5_f64).cos();
    let s = (0.5_f64).sin();
    let d = (0.5_f64).sqrt();
    let eighth_turn = [[d, d, 0.0], [-d, d, 0.0], [0.0, 0.0, 1.0]];
    let origin = DVec3::new(3.0, -7.0, 11.0);
    [
        ("sheared, as by a gantry's tilt", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.4, 1.5]]),
        ("sheared in every axis", [[1.0, 0.1, -0.2], [0.3, 1.1, 0.2], [-0.4, 0.5, 1.3]]),
        ("mirrored in x", [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        ("mirrored in every axis", [[-1.0, 0.0, 0.0], [0.0, -1.1, 0.0], [0.0, 0.0, -0.9]]),
        ("axes permuted", [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        ("rotated by half a radian", [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]),
        ("rotated by 45 degrees", eighth_turn),
        ("nearly singular, 1:1e3", [[1.0, 0.0, 0.0], [1.0, 1e-3, 0.0], [0.0, 0.0, 1.0]]),
        ("nearly singular, 1:1e5", [[1.0, 0.0, 0.0], [1.0, 1e-5, 0.0], [0.0, 0.0, 1.0]]),
        ("voxels of a nanometre", [[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1e-6]]),
        ("voxels of a kilometre", [[1e6, 0.0, 0.0], [0.0, 1e6, 0.0], [0.0, 0.0, 1e6]]),
    ]
    .into_iter()
    .flat_map(|(name, columns)| {
        [DVec3::new(1.0, 0.3, 0.2), DVec3::new(-0.2, 0.4, 1.0)].map(|direction| {
            let grid = affine_grid(SMALL, columns, origin);
            let size = grid.length_mm(DVec3::splat(6.0));
            let pose = through(&grid, DVec3::new(2.2, 1.3, 2.7), direction, 20.0 * size);
            let set = Set::new(mixed(grid), [1, 1], View::Pose(pose));
            Case::exact(15, format!("{name}, along {direction}"), set)
        })
    })
    .chain([Case::exact(15, "a diagonal of a rotated grid", {
        let grid = affine_grid([6; 3], eighth_turn, DVec3::ZERO);
        Set::posed(grey(grid), [1, 1], through(&grid, DVec3::new(2.4, 2.4, 2.3), DVec3::Y, 30.0))
    })])
    .collect()
}

/// Relative to its columns a matrix is singular or not, whatever the unit.
fn refused() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, columns) in [
        ("singular", [[1.0, 2.0, 0.0], [2.0, 4.0, 0.0], [0.0, 0.0, 1.0]]),
        ("singular with large entries", [[1e4, 2e4, 0.0], [2e4, 4e4, 1e-3], [0.0, 0.0, 1e4]]),
        ("a column of zeros", [[0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        ("NaN", [[f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        ("infinite", [[1.0, 0.0, 0.0], [0.0, f64::INFINITY, 0.0], [0.0, 0.0, 1.0]]),
    ] {
        let matrix = DAffine3::from_mat3(DMat3::from_cols_array_2d(&columns));
        cases.push(Case::refused(15, name, "index_to_world", move |_| Grid::new(SMALL, matrix)));
    }
    for n in [[0, 4, 6], [5, 0, 6], [1 << 20, 4, 6], [1 << 15, 1 << 15, 1 << 15]] {
        let name = format!("{n:?} voxels");
        cases.push(Case::refused(14, name, "dimensions", move |_| Grid::centred(n, DVec3::ONE)));
    }
    cases
}
