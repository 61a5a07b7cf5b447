//! Early exit, long sums, bone path.

use drr::engine::Layers;
use drr::geometry::View;
use drr::physics::{EnergyGrid, Spectrum};
use glam::DVec3;

use super::spectra::{through, tube, two_lines};
use crate::check::case::{Case, Set, segment};
use crate::check::volumes::{SMALL, mixed, noise, unit_grid, volume, water};

pub(super) fn cases() -> Vec<Case> {
    [early_exit(), long_sums(), bone()].into_iter().flatten().collect()
}

/// What is cut off is at most exp(−15) of I0, whatever the spectrum and the material.
fn early_exit() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |name: &str, set: Set, layers: Layers| {
        let mut set = Set { layers, ..set };
        set.views.iter_mut().for_each(|view| view.early_exit = true);
        cases.push(Case::exact(19, name, set));
    };
    let only = Layers { intensity: true, ..Layers::default() };
    for material in ["soft_tissue", "bone_cortical", "titanium", "steel_316l", "tungsten", "iodine"] {
        add(&format!("through {material}"), through(material, 900, tube()), only);
    }
    add("a faint line that passes", through("titanium", 900, two_lines(1e-4)), only);
    add("with the bone path", through("titanium", 900, tube()), Layers { bone_path: true, ..only });
    add("with the line integral", through("titanium", 900, tube()), Layers { line_integral: true, ..only });
    add("with the areal density", through("titanium", 900, tube()), Layers { areal_density: true, ..only });
    add(
        "beside the K edge",
        through("tungsten", 900, {
            let grid = EnergyGrid::new(69.0, 1.0, 3).expect("valid");
            Spectrum::new("flat", grid, vec![1.0; 3]).expect("valid")
        }),
        only,
    );
    cases
}

/// Samples by the ten thousand: neither sums nor positions drift.
fn long_sums() -> Vec<Case> {
    let long = |n: usize| unit_grid([n, 1, 2]);
    let along = |n: usize, rise: f64| {
        let middle = 0.5 * (n as f64 - 1.0);
        let ends = [-1.0, 1.0].map(|sign| DVec3::new(middle + sign * (middle + 9.0), 0.0, 0.5 + sign * rise));
        View::Pose(segment(ends[0], ends[1]))
    };
    let columns = |n: usize| volume(long(n), |[i, _, k]| (-1000 + 125 * (9.0 * noise(i + k * n)) as i16, 2));
    let set = |volume, view, step| Set { step, ..Set::new(volume, [1, 1], view) };
    [
        ("100 000 steps through water", set(water(long(25_000)), along(25_000, 0.0), 0.25)),
        ("2 000 000 steps through water", set(water(long(32_768)), along(32_768, 0.25), 1.0 / 64.0)),
        ("4 000 voxels of noise", set(columns(4000), along(4000, 0.0), 0.25)),
        ("4 000 voxels of noise, inclined", set(columns(4000), along(4000, 0.375), 0.5)),
    ]
    .map(|(name, set)| Case::exact(20, name, set))
    .into_iter()
    .chain(along_interfaces())
    .collect()
}

/// Rays that keep to an oblique interface: an error of position that samples share is in every one of them.
fn along_interfaces() -> Vec<Case> {
    let mut cases = Vec::new();
    let n = 300;
    for (slope, offset) in [(1.0, 1.4e-5), (1.0, 0.3), (-0.37, 1.4e-5), (0.73, -0.2)] {
        let middle = 0.5 * (f64::from(n) - 1.0);
        let foot = move |i: usize| slope * (i as f64 - middle) + middle;
        let grid = unit_grid([n as usize, n as usize, 1]);
        let ends = [-1.0, 1.0]
            .map(|sign| DVec3::new(middle + sign * middle, middle + sign * slope * middle + offset, 0.125));
        let view = || View::Pose(segment(ends[0], ends[1]));
        let half_space = volume(grid, move |[i, j, _]| (if j as f64 > foot(i) { 600 } else { -1000 }, 3));
        let foil =
            volume(grid, move |[i, j, _]| (if (j as f64 - foot(i)).round() == 1.0 { 600 } else { -1000 }, 3));
        for (what, volume) in [("a half-space", half_space), ("a foil", foil)] {
            let name = format!("along {what} of slope {slope}, {offset} off");
            cases.push(Case::near_face(20, name, Set::new(volume, [1, 1], view())));
        }
    }
    cases
}

/// Lengths through bone, whatever the density.
fn bone() -> Vec<Case> {
    let grid = unit_grid(SMALL);
    let v = DVec3::new;
    let checkered = |hu: i16| volume(grid, move |[i, j, k]| (hu, if (i + j + k) % 2 == 0 { 3 } else { 2 }));
    [
        ("bone of no density", Set::ray(checkered(-1000), v(-9.0, 1.2, 2.1), v(15.0, 2.2, 3.3))),
        ("a chequer of bone", Set::ray(checkered(700), v(-9.0, -8.0, 2.1), v(12.0, 11.0, 3.3))),
        ("bone from inside", Set::ray(checkered(700), v(2.1, 1.2, 2.1), v(12.0, 3.0, 3.3))),
        ("all materials", Set::ray(mixed(grid), v(2.1, -9.2, 2.1), v(2.6, 13.0, 3.3))),
    ]
    .map(|(name, set)| Case::exact(28, name, set))
    .into()
}
