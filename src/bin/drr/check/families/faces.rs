//! Faces, edges and corners of voxels and of the volume.

use std::sync::Arc;

use drr::geometry::DetectorPose;
use drr::volume::Volume;
use glam::DVec3;

use super::AXIS_NAMES;
use super::directions::parallel;
use crate::check::case::{Case, Set};
use crate::check::volumes::{SMALL, grey, mixed, unit_grid, volume, water};

pub(super) fn cases() -> Vec<Case> {
    [in_faces(), along_edges(), through_corners(), grazing(), misses(), box_size()]
        .into_iter()
        .flatten()
        .collect()
}

/// A ray along `axis` through `at`: by pose, by uniforms, as a parallel beam.
fn axial(volume: Arc<Volume>, axis: usize, at: DVec3, sign: f64) -> Set {
    let along = 16.0 * sign * DVec3::AXES[axis];
    let at = at * (DVec3::ONE - DVec3::AXES[axis]);
    let mut set = Set::ray(volume, at - along, at + along);
    set.views.push(parallel(axis, at).into());
    set
}

fn in_faces() -> Vec<Case> {
    let mut cases = Vec::new();
    for (axis, along) in AXIS_NAMES.into_iter().enumerate() {
        let across = DVec3::AXES[(axis + 1) % 3];
        let inside = DVec3::splat(1.25);
        let high = SMALL[(axis + 1) % 3] as f64 - 0.5;
        let name = |how: &str| format!("in a face along {along}, {how}");
        let ray = |place: f64, sign: f64| {
            let at = inside * (DVec3::ONE - across) + place * across;
            axial(mixed(unit_grid(SMALL)), axis, at, sign)
        };
        cases.push(Case::exact(3, name("between voxels"), ray(1.5, 1.0)));
        cases.push(Case::exact(3, name("backwards"), ray(1.5, -1.0)));
        // Nearer to the face than float32 can tell.
        for off in [1e-3, 1e-9, 1e-12] {
            cases.push(Case::near_face(3, name(&format!("{off:.0e} above")), ray(1.5 + off, 1.0)));
            cases.push(Case::near_face(3, name(&format!("{off:.0e} below")), ray(1.5 - off, 1.0)));
        }
        cases.push(Case::exact(3, name("lower face of the box"), ray(-0.5, 1.0)));
        cases.push(Case::exact(3, name("upper face of the box"), ray(high, 1.0)));
    }
    cases
}

fn along_edges() -> Vec<Case> {
    let mut cases = Vec::new();
    for (axis, along) in AXIS_NAMES.into_iter().enumerate() {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let edge = |a: f64, b: f64| a * DVec3::AXES[u] + b * DVec3::AXES[v];
        let [high_u, high_v] = [u, v].map(|axis| SMALL[axis] as f64 - 0.5);
        for (how, at) in [
            ("inner", edge(1.5, 0.5)),
            ("lower, lower of the box", edge(-0.5, -0.5)),
            ("lower, upper of the box", edge(-0.5, high_v)),
            ("upper, upper of the box", edge(high_u, high_v)),
        ] {
            let name = format!("along an edge, {along}, {how}");
            cases.push(Case::exact(4, name, axial(mixed(unit_grid(SMALL)), axis, at, 1.0)));
        }
    }
    cases
}

/// Two or three planes at once, in grids with even and with odd sides.
fn through_corners() -> Vec<Case> {
    let mut cases = Vec::new();
    for n in [4, 5] {
        let grid = unit_grid([n; 3]);
        let corner = DVec3::splat(1.5);
        for direction in
            [[1, 1, 1], [1, -1, 1], [-1, -1, 1], [1, 1, 0], [1, 0, -1], [0, 1, 1], [2, 1, 1], [3, -1, 2]]
        {
            let along = 4.0 * DVec3::from_array(direction.map(f64::from));
            for (what, volume) in [("water", water(grid)), ("noise", grey(grid))] {
                let name = format!("corners of {n}^3 {what} along {direction:?}");
                cases.push(Case::exact(5, name, Set::ray(volume, corner - along, corner + along)));
            }
        }
    }
    cases
}

/// Rays that cut an edge or a corner of the box off: short chords.
fn grazing() -> Vec<Case> {
    let mut cases = Vec::new();
    let v = DVec3::new;
    let both_ways = |volume, at: DVec3, along: DVec3| Set::ray(volume, at + along, at - along);
    for depth in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
        let edge = v(-0.5 + depth, -0.5 + depth, 2.25);
        let set = both_ways(grey(unit_grid(SMALL)), edge, v(9.0, -9.0, 1.0));
        cases.push(Case::exact(6, format!("{depth:.0e} mm inside an edge"), set));
        let corner = v(4.5, 3.5, 5.5) - DVec3::splat(depth);
        let set = both_ways(mixed(unit_grid(SMALL)), corner, v(8.0, -4.0, -4.0));
        cases.push(Case::exact(6, format!("{depth:.0e} mm inside a corner"), set));
    }
    for slope in [1e-3, 1e-5, 1e-7] {
        // In and out through the same outer face, nearly parallel to it.
        let set = both_ways(grey(unit_grid(SMALL)), v(0.0, -0.5, 2.25), v(-10.0, -10.0 * slope, 0.0));
        cases.push(Case::near_face(6, format!("through an outer face at a slope of {slope:.0e}"), set));
    }
    cases
}

fn misses() -> Vec<Case> {
    let volume = || mixed(unit_grid(SMALL));
    let v = DVec3::new;
    let detector = DetectorPose::c_arm(v(0.0, 0.0, 400.0), 30.0, 1000.0, 1500.0, 1.0, [5, 4]);
    let ray = |from, to| Set::ray(volume(), from, to);
    let mut cases = vec![
        Case::vacuum(9, "touching an edge", ray(v(-1.5, 0.5, 2.0), v(0.5, -1.5, 2.0)).pose_only()),
        Case::vacuum(9, "touching a vertex", ray(v(-1.5, 0.5, -0.5), v(0.5, -1.5, -0.5)).pose_only()),
        Case::vacuum(9, "far beside", ray(v(-9.0, 50.0, 2.0), v(9.0, 50.5, 2.0))),
        Case::vacuum(9, "pointing away", ray(v(-9.0, 1.0, 2.0), v(-20.0, 1.5, 2.0))),
        Case::vacuum(9, "a whole detector beside", Set::posed(volume(), [5, 4], detector)),
    ];
    for (axis, along) in AXIS_NAMES.into_iter().enumerate() {
        let across = (axis + 1) % 3;
        let high = SMALL[across] as f64 - 0.5;
        for (how, place) in
            [("below the lower face", (-0.5_f64).next_down()), ("above the upper face", high.next_up())]
        {
            let mut at = DVec3::splat(1.25);
            at[across] = place;
            let name = format!("one ulp {how}, along {along}");
            cases.push(Case::vacuum(9, name, axial(volume(), axis, at, 1.0).pose_only()));
        }
    }
    cases
}

/// The box runs from the outer faces, not from the outermost centres.
fn box_size() -> Vec<Case> {
    let mut cases = Vec::new();
    for (axis, along) in AXIS_NAMES.into_iter().enumerate() {
        for (how, n, at) in [("ten voxels", 10, 4.25), ("one voxel", 1, 0.25)] {
            let set = axial(water(unit_grid([n; 3])), axis, DVec3::splat(at), 1.0);
            cases.push(Case::exact(10, format!("{how} along {along}"), set));
        }
    }
    // Vacuum around the outermost voxels is not seen by what goes through them.
    let n = 6;
    let padded = volume(unit_grid([n; 3]), |at| {
        let inside = at.iter().all(|&i| (2..n - 2).contains(&i));
        (if inside { 0 } else { -1000 }, 2)
    });
    let set = Set::ray(padded, DVec3::new(-9.0, 2.25, 2.5), DVec3::new(14.0, 2.75, 2.25));
    cases.push(Case::exact(10, "a core padded with vacuum", set));
    cases
}
