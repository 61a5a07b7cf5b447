use glam::DVec3;

use super::*;
use crate::geometry::Grid;
use crate::physics::{Calibration, Thresholds};
use crate::volume::{Classification, Matter, Volume};

const DIMENSIONS: [usize; 3] = [75, 41, 58];

/// Vacuum with a few clumps of bone and of thin air, some of them at the border.
fn volume() -> Volume {
    let grid = Grid::centred(DIMENSIONS, DVec3::ONE).expect("valid");
    let clumps = [([20, 9, 30], 1000), ([23, 30, 31], -980), ([0, 40, 57], 1000), ([74, 0, 5], 1000)];
    let hu = (0..grid.voxel_count()).map(|at| {
        let voxel = [at % 75, at / 75 % 41, at / (75 * 41)];
        let near = |clump: [usize; 3]| (0..3).all(|axis| voxel[axis].abs_diff(clump[axis]) <= 1);
        clumps.iter().find(|(clump, _)| near(*clump)).map_or(-2000, |(_, hu)| *hu)
    });
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    Volume::from_int16(grid, &hu.collect::<Vec<_>>(), None, &how).expect("valid")
}

/// Rays in all directions through points of the volume, and along its axes.
fn rays() -> Vec<Ray> {
    let centre = DVec3::from_array(DIMENSIONS.map(|n| 0.5 * (n as f64 - 1.0)));
    let mut rays = Vec::new();
    for n in 0..1500 {
        let turn = f64::from(n);
        let place = |k: f64| 0.5 + 0.5 * (k * turn).sin();
        let point = DVec3::new(place(1.1) * 75.0, place(2.3) * 41.0, place(3.7) * 58.0) - 0.5;
        let any = DVec3::new((1.7 * turn).sin(), (0.9 * turn).cos(), (2.9 * turn).sin());
        let direction = if n % 10 == 0 { DVec3::AXES[n as usize / 10 % 3] } else { any };
        let stops = n % 7 == 0;
        let ends = [(n % 5 == 0).then_some(point), stops.then_some(point + 25.0 * direction)];
        rays.push(Ray::through(centre, point, direction, ends, direction.length()));
    }
    rays
}

fn cases() -> [Matter; 3] {
    [Matter::ANY, Matter::new(1 << 3, 0.0).expect("valid"), Matter::new(u8::MAX, 0.1).expect("valid")]
}

/// Calls `met` with each of these s of a ray at which a voxel that counts is interpolated from. Beyond the outermost centres
/// the edge holds.
fn where_anything_is(
    volume: &Volume,
    matter: Matter,
    ray: &Ray,
    s: impl Iterator<Item = f64>,
    mut met: impl FnMut(f64),
) {
    for s in s {
        let corner = ray.point(s).map(f64::floor);
        let counts = |n: usize| {
            let index = [0, 1, 2].map(|axis| {
                (corner[axis] + (n >> axis & 1) as f64).clamp(0.0, DIMENSIONS[axis] as f64 - 1.0) as usize
            });
            let voxel = volume.voxels().get((index[2] * 41 + index[1]) * 75 + index[0]);
            voxel.density > matter.floor() && matter.labels() >> voxel.label & 1 != 0
        };
        if (0..8).any(counts) {
            met(s);
        }
    }
}

#[test]
fn nothing_that_counts_is_cut_off() {
    let volume = volume();
    for matter in cases() {
        let occupied = volume.occupancy().and_then(|all| all.of(matter)).expect("little memory");
        let mut touched = 0;
        for ray in rays() {
            let Some(span) = ray.clip(DIMENSIONS) else { continue };
            let met = occupied.tighten(&ray, span, REACH);
            // Points of the ray, and the middles of the slices that it touches, which may lie outside of the span.
            let points = (0..=400).map(|n| span.enter + (span.leave - span.enter) * f64::from(n) / 400.0);
            let slices = (span.enter.round() as i32..=span.leave.round() as i32).map(f64::from);
            where_anything_is(&volume, matter, &ray, points.chain(slices), |s| {
                touched += 1;
                let met = met.unwrap_or_else(|| panic!("{ray:?} is said to meet nothing"));
                let s = s.clamp(span.enter, span.leave);
                assert!((met.enter..=met.leave).contains(&s), "{s} is not in {met:?} of {ray:?}");
            });
        }
        assert!(touched > 1000, "{matter:?}: {touched} points");
    }
}

#[test]
fn what_is_left_begins_and_ends_at_bricks_that_count() {
    let volume = volume();
    for matter in cases() {
        let occupied = volume.occupancy().and_then(|all| all.of(matter)).expect("little memory");
        let [c0, c1, c2] = occupied.levels()[0].count;
        let bricks: Vec<_> = (0..c0 * c1 * c2)
            .map(|n| [n % c0, n / c0 % c1, n / (c0 * c1)])
            .filter(|&brick| occupied.holds(brick))
            .collect();
        let (mut missed, mut met) = (0, 0);
        for ray in rays() {
            let Some(span) = ray.clip(DIMENSIONS) else { continue };
            let walk = Walk { levels: occupied.levels(), ray: &ray, span, reach: REACH };
            let near: Vec<_> = bricks.iter().filter_map(|&brick| walk.near(brick)).collect();
            let first = near.iter().map(|near| near.enter).reduce(f64::min);
            let last = near.iter().map(|near| near.leave).reduce(f64::max);
            match (occupied.tighten(&ray, span, REACH), first.zip(last)) {
                (Some(found), Some((first, last))) => {
                    met += 1;
                    assert!((0.0..=2.0 * REACH).contains(&(first - found.enter)), "{found:?}, {first}");
                    assert!((0.0..=2.0 * REACH).contains(&(found.leave - last)), "{found:?}, {last}");
                }
                (None, None) => missed += 1,
                (None, Some((first, last))) => assert_eq!(first, last, "{ray:?}"),
                (found, _) => panic!("{found:?} of {ray:?}"),
            }
        }
        assert!(met > 50 && missed > 50, "{matter:?}: {met} rays, {missed} miss");
    }
}

#[test]
fn a_full_volume_leaves_the_span() {
    let full = crate::volume::Occupied::new(DIMENSIONS, |_| true).expect("little memory");
    for ray in rays() {
        if let Some(span) = ray.clip(DIMENSIONS) {
            assert_eq!(full.tighten(&ray, span, REACH), Some(span));
        }
    }
}
