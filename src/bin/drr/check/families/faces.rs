//! Faces, edges and corners of voxels and of the volume.

use std::sync::Arc;

use drr::volume::Volume;
use glam::DVec3;

use super::directions::parallel;
use crate::check::case::{Case, Demand, Set};
use crate::check::volumes::{SMALL, grey, mixed, unit_grid, volume, water};

pub(super) fn cases() -> Vec<Case> {
    [in_faces(), along_edges(), through_corners(), grazing(), misses(), box_size()]
        .into_iter()
        .flatten()
        .collect()
}

/// Where the ray passes, as multiples of half a voxel: the box of `SMALL` runs from −½ to n − ½.
fn axial(volume: Arc<Volume>, axis: usize, at: DVec3, sign: f64) -> Set {
    let along = 16.0 * sign * DVec3::AXES[axis];
    let at = at * (DVec3::ONE - DVec3::AXES[axis]);
    let mut set = Set::ray(volume, at - along, at + along);
    set.views.push(parallel(axis, at).into());
    set
}

fn in_faces() -> Vec<Case> {
    let mut cases = Vec::new();
    for axis in 0..3 {
        let across = DVec3::AXES[(axis + 1) % 3];
        let inside = DVec3::new(1.25, 1.25, 1.25);
        let high = SMALL[(axis + 1) % 3] as f64 - 0.5;
        let at = |place: f64| inside * (DVec3::ONE - across) + place * across;
        let mut case = |how: String, place: f64, sign: f64, demand: fn(Set) -> Demand| {
            let name = format!("in a face along {}, {how}", ["x", "y", "z"][axis]);
            let set = axial(mixed(unit_grid(SMALL)), axis, at(place), sign);
            cases.push(Case { family: 3, name, demand: demand(set) });
        };
        case("between voxels".into(), 1.5, 1.0, Demand::Exact);
        case("backwards".into(), 1.5, -1.0, Demand::Exact);
        // Nearer to the face than float32 can tell.
        for off in [1e-3, 1e-9, 1e-12] {
            case(format!("{off:.0e} above"), 1.5 + off, 1.0, Demand::NearFace);
            case(format!("{off:.0e} below"), 1.5 - off, 1.0, Demand::NearFace);
        }
        case("lower face of the box".into(), -0.5, 1.0, Demand::Exact);
        case("upper face of the box".into(), high, 1.0, Demand::Exact);
    }
    cases
}

fn along_edges() -> Vec<Case> {
    let mut cases = Vec::new();
    for axis in 0..3 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let edge = |a: f64, b: f64| a * DVec3::AXES[u] + b * DVec3::AXES[v];
        let [high_u, high_v] = [u, v].map(|axis| SMALL[axis] as f64 - 0.5);
        for (how, at) in [
            ("inner", edge(1.5, 0.5)),
            ("lower, lower of the box", edge(-0.5, -0.5)),
            ("lower, upper of the box", edge(-0.5, high_v)),
            ("upper, upper of the box", edge(high_u, high_v)),
        ] {
            let name = format!("along an edge, {}, {how}", ["x", "y", "z"][axis]);
            let set = axial(mixed(unit_grid(SMALL)), axis, at, 1.0);
            cases.push(Case { family: 4, name, demand: Demand::Exact(set) });
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
                let set = Set::ray(volume, corner - along, corner + along);
                cases.push(Case { family: 5, name, demand: Demand::Exact(set) });
            }
        }
    }
    cases
}

/// Rays that cut an edge or a corner of the box off: short chords.
fn grazing() -> Vec<Case> {
    let mut cases = Vec::new();
    for depth in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
        let edge = DVec3::new(-0.5 + depth, -0.5 + depth, 2.25);
        let set = Set::ray(
            grey(unit_grid(SMALL)),
            edge + DVec3::new(9.0, -9.0, 1.0),
            edge - DVec3::new(9.0, -9.0, 1.0),
        );
        cases.push(Case {
            family: 6,
            name: format!("{depth:.0e} mm inside an edge"),
            demand: Demand::Exact(set),
        });
        let corner = DVec3::new(4.5, 3.5, 5.5) - DVec3::splat(depth);
        let set = Set::ray(
            mixed(unit_grid(SMALL)),
            corner + DVec3::new(8.0, -4.0, -4.0),
            corner - DVec3::new(8.0, -4.0, -4.0),
        );
        cases.push(Case {
            family: 6,
            name: format!("{depth:.0e} mm inside a corner"),
            demand: Demand::Exact(set),
        });
    }
    for slope in [1e-3, 1e-5, 1e-7] {
        // In and out through the same outer face, nearly parallel to it.
        let enter = DVec3::new(0.0, -0.5, 2.25);
        let set = Set::ray(
            grey(unit_grid(SMALL)),
            enter - DVec3::new(10.0, 10.0 * slope, 0.0),
            enter + DVec3::new(10.0, 10.0 * slope, 0.0),
        );
        cases.push(Case {
            family: 6,
            name: format!("through an outer face at a slope of {slope:.0e}"),
            demand: Demand::NearFace(set),
        });
    }
    cases
}

/// The largest number below x, and the smallest above.
fn neighbours(x: f64) -> [f64; 2] {
    [x.next_down(), x.next_up()]
}

fn misses() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut miss = |name: String, set: Set| cases.push(Case { family: 9, name, demand: Demand::Vacuum(set) });
    let inside = DVec3::splat(1.25);
    for axis in 0..3 {
        let across = (axis + 1) % 3;
        let high = SMALL[across] as f64 - 0.5;
        for (how, place) in
            [("below the lower face", neighbours(-0.5)[0]), ("above the upper face", neighbours(high)[1])]
        {
            let mut at = inside;
            at[across] = place;
            let along = 16.0 * DVec3::AXES[axis];
            let at = at * (DVec3::ONE - DVec3::AXES[axis]);
            let pose = crate::check::case::segment(at - along, at + along);
            let set = Set::new(mixed(unit_grid(SMALL)), [1, 1], drr::geometry::View::Pose(pose));
            miss(format!("one ulp {how}, along {}", ["x", "y", "z"][axis]), set);
        }
    }
    let volume = || mixed(unit_grid(SMALL));
    let v = DVec3::new;
    miss("touching an edge".into(), Set::ray(volume(), v(-1.5, 0.5, 2.0), v(0.5, -1.5, 2.0)).pose_only());
    miss("touching a vertex".into(), Set::ray(volume(), v(-1.5, 0.5, -0.5), v(0.5, -1.5, -0.5)).pose_only());
    miss("far beside".into(), Set::ray(volume(), v(-9.0, 50.0, 2.0), v(9.0, 50.5, 2.0)));
    miss("pointing away".into(), Set::ray(volume(), v(-9.0, 1.0, 2.0), v(-20.0, 1.5, 2.0)));
    miss("a whole detector beside".into(), {
        let pose = drr::geometry::DetectorPose::c_arm(v(0.0, 0.0, 400.0), 30.0, 1000.0, 1500.0, 1.0, [5, 4]);
        Set::posed(volume(), [5, 4], pose)
    });
    cases
}

/// The box runs from the outer faces, not from the outermost centres.
fn box_size() -> Vec<Case> {
    let mut cases = Vec::new();
    for axis in 0..3 {
        let set = axial(water(unit_grid([10, 10, 10])), axis, DVec3::splat(4.25), 1.0);
        cases.push(Case {
            family: 10,
            name: format!("ten voxels along {}", ["x", "y", "z"][axis]),
            demand: Demand::Exact(set),
        });
        let single = axial(water(unit_grid([1, 1, 1])), axis, DVec3::splat(0.25), 1.0);
        cases.push(Case {
            family: 10,
            name: format!("one voxel along {}", ["x", "y", "z"][axis]),
            demand: Demand::Exact(single),
        });
    }
    // Vacuum around the outermost voxels is not seen by what goes through them.
    let n = 6;
    let padded = volume(unit_grid([n; 3]), |at| {
        let inside = at.iter().all(|&i| (2..n - 2).contains(&i));
        (if inside { 0 } else { -1000 }, 2)
    });
    let set = Set::ray(padded, DVec3::new(-9.0, 2.25, 2.5), DVec3::new(14.0, 2.75, 2.25));
    cases.push(Case { family: 10, name: "a core padded with vacuum".into(), demand: Demand::Exact(set) });
    cases
}
