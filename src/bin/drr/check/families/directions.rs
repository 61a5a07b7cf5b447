//! Directions: components that are 0, −0 or nearly 0.

use drr::geometry::{DetectorPose, Projection, View};
use glam::{DMat4, DVec3, DVec4};

use super::AXIS_NAMES;
use crate::check::case::{Case, Set};
use crate::check::volumes::{SMALL, grey, mixed, unit_grid};

/// A point between planes: no ray through it along an axis is in a face.
const THROUGH: DVec3 = DVec3::new(2.25, 1.375, 3.125);

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for axis in 0..3 {
        cases.extend(along(axis));
        cases.extend(tilted(axis));
        cases.extend(zeros(axis));
    }
    cases
}

fn unit(axis: usize) -> DVec3 {
    DVec3::AXES[axis]
}

/// One pixel of parallel rays along an axis through a point.
pub(super) fn parallel(axis: usize, through: DVec3) -> View {
    let [u, v] = [[1, 2], [0, 2], [0, 1]][axis];
    let row = |axis: usize| (0.125 * unit(axis)).extend(-0.125 * through[axis]);
    let matrix = DMat4::from_cols(row(u), row(v), row(axis), DVec4::W).transpose();
    View::Projection(Projection { matrix, source: DVec3::ZERO })
}

/// The direction has two components that are exactly 0.
fn along(axis: usize) -> Vec<Case> {
    let ray = |sign: f64, through: DVec3| {
        let beside = through * (DVec3::ONE - unit(axis));
        Set::ray(
            mixed(unit_grid(SMALL)),
            beside - 20.0 * sign * unit(axis),
            beside + 20.0 * sign * unit(axis),
        )
    };
    let mut outer = THROUGH;
    outer[(axis + 1) % 3] = -0.375;
    let mut beam = ray(1.0, THROUGH);
    beam.views = vec![parallel(axis, THROUGH).into()];
    [
        ("between centres", ray(1.0, THROUGH)),
        ("backwards", ray(-1.0, THROUGH)),
        ("through centres", ray(1.0, DVec3::new(2.0, 1.0, 3.0))),
        ("in the outer half voxel", ray(1.0, outer)),
        ("parallel beam", beam),
    ]
    .map(|(how, set)| Case::exact(1, format!("along {}, {how}", AXIS_NAMES[axis]), set))
    .into()
}

/// The limit of a small tilt is no tilt.
fn tilted(axis: usize) -> Vec<Case> {
    let across = unit((axis + 1) % 3) - 0.5 * unit((axis + 2) % 3);
    let tilts = [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-300, 5e-324];
    // Through the centre of the first voxel, the origin: nothing there rounds a tilt away.
    let case = |tilt: f64| {
        let end = 16.0 * unit(axis) + tilt * across;
        let set = Set::ray(grey(unit_grid(SMALL)), -end, end);
        Case::exact(1, format!("along {}, tilted by {tilt:.0e}", AXIS_NAMES[axis]), set)
    };
    tilts.map(case).into()
}

/// The sign of a zero changes nothing, not a bit.
fn zeros(axis: usize) -> Vec<Case> {
    let through = THROUGH * (DVec3::ONE - unit(axis));
    let along = 16.0 * unit(axis);
    let pose = DetectorPose {
        source: through - along,
        first_pixel: through + along,
        column_step: unit((axis + 1) % 3),
        row_step: unit((axis + 2) % 3),
    };
    let negated = DetectorPose {
        source: negative_zeros(pose.source),
        first_pixel: negative_zeros(pose.first_pixel),
        column_step: negative_zeros(pose.column_step),
        row_step: negative_zeros(pose.row_step),
    };
    let set = |view| Set::new(mixed(unit_grid(SMALL)), [1, 1], view);
    let View::Projection(beam) = parallel(axis, through) else { unreachable!("made from a matrix") };
    let columns = beam.matrix.to_cols_array().map(|x| if x == 0.0 { -x } else { x });
    let negated_beam = Projection { matrix: DMat4::from_cols_array(&columns), ..beam };
    [
        ("pose", View::Pose(pose), View::Pose(negated)),
        ("matrix", View::Projection(beam), View::Projection(negated_beam)),
    ]
    .map(|(what, plus, minus)| {
        let name = format!("along {}, zeros of the {what} negated", AXIS_NAMES[axis]);
        Case::same(2, name, [set(plus), set(minus)])
    })
    .into()
}

fn negative_zeros(v: DVec3) -> DVec3 {
    DVec3::from_array(v.to_array().map(|x| if x == 0.0 { -x } else { x }))
}
