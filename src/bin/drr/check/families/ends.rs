//! Sources and detectors inside the volume, or on its surface: only what lies between them counts.

use glam::DVec3;

use crate::check::case::{Case, Set};
use crate::check::volumes::{SMALL, grey, mixed, unit_grid};

pub(super) fn cases() -> Vec<Case> {
    let v = DVec3::new;
    let outside = v(9.0, 8.0, -4.0);
    let ray = |from, to| Set::ray(mixed(unit_grid(SMALL)), from, to);
    vec![
        Case::exact(7, "source inside a voxel", ray(v(2.25, 1.5, 3.125), outside)),
        Case::exact(7, "source at a voxel's centre", ray(v(2.0, 1.0, 3.0), outside)),
        Case::near_face(7, "source in a face", ray(v(2.5, 1.25, 3.125), outside)),
        Case::near_face(7, "source on an edge", ray(v(2.5, 1.5, 3.125), outside)),
        Case::near_face(7, "source on a corner", ray(v(2.5, 1.5, 3.5), outside)),
        Case::near_face(7, "source on a corner, along an edge", ray(v(2.5, 1.5, 3.5), v(2.5, 1.5, 30.0))),
        Case::near_face(7, "source on a face of the box", ray(v(-0.5, 1.25, 2.125), v(9.0, 2.0, 4.0))),
        Case::near_face(7, "source on a corner of the box", ray(v(-0.5, -0.5, -0.5), v(6.0, 3.0, 7.0))),
        Case::near_face(
            7,
            "source one ulp inside the box",
            ray(v((-0.5_f64).next_up(), 1.25, 2.125), v(9.0, 2.0, 4.0)),
        ),
        Case::near_face(
            7,
            "source one ulp outside the box",
            ray(v((-0.5_f64).next_down(), 1.25, 2.125), v(9.0, 2.0, 4.0)),
        ),
        Case::exact(8, "pixel inside", ray(outside, v(2.25, 1.5, 3.125))),
        Case::near_face(8, "pixel in a face", ray(outside, v(2.5, 1.25, 3.125))),
        Case::near_face(8, "pixel on a corner", ray(outside, v(2.5, 1.5, 3.5))),
        Case::near_face(8, "pixel on a face of the box", ray(v(-9.0, 2.0, 4.0), v(-0.5, 1.25, 2.125))),
        Case::exact(8, "pixel in front of the box", ray(v(-9.0, 2.0, 2.5), v(-0.75, 1.25, 2.125))),
        Case::exact(8, "both in one voxel", ray(v(2.125, 1.0625, 3.25), v(1.75, 0.75, 3.375))),
        Case::exact(
            8,
            "both in one voxel, 1e-9 mm apart",
            ray(v(2.125, 1.0625, 3.25), v(2.125 + 1e-9, 1.0625, 3.25)),
        ),
        Case::exact(8, "both inside, voxels apart", ray(v(0.3, 0.2, 0.1), v(3.7, 2.9, 5.1))),
        continuous(),
    ]
}

/// A source moves through a face of the box pixel by pixel: the views are one ray each.
fn continuous() -> Case {
    let at = |step: f64| DVec3::new(-0.5 + step, 1.3, 2.2);
    let mut set = Set::ray(grey(unit_grid(SMALL)), at(-1e-3), DVec3::new(9.0, 2.0, 4.0));
    for step in [-1e-6, -1e-9, 1e-9, 1e-6, 1e-3] {
        let more = Set::ray(set.volume.clone(), at(step), DVec3::new(9.0, 2.0, 4.0));
        set.views.extend(more.views);
    }
    Case::exact(7, "source moving into the box", set)
}
