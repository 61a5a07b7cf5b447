//! The same rays through the same voxels, elsewhere in the world or the other way round.

use drr::Algorithm::{Exact, Joseph, Siddon};
use drr::ViewRequest;
use drr::geometry::{DetectorPose, Projection, View};
use glam::{DAffine3, DMat4, DVec3};
use proptest::prelude::*;

use crate::case::{ANY, Case, RAYS, cases, sized_cases};
use crate::pose::in_cube;
use crate::scenes;
use crate::support::noise;
use crate::tolerance::{Tolerance, identical, sum};

/// Multiples of 2⁻²⁰ mm, whose sums and differences up to 10⁹ mm float64 holds exactly.
fn on_lattice(v: DVec3) -> DVec3 {
    let per_mm = 20_f64.exp2();
    (v * per_mm).round() / per_mm
}

/// Every zero negative or not as `sign` says.
fn signed_zeros<const N: usize>(values: [f64; N], sign: &mut impl FnMut() -> bool) -> [f64; N] {
    values.map(|x| {
        if x != 0.0 {
            x
        } else if sign() {
            -0.0
        } else {
            0.0
        }
    })
}

/// The scene along the world's axes and with its origin in a corner voxel: the detector's middle ray is parallel to
/// `axis`, its columns and rows to the other two.
fn straightened(case: &Case, axis: usize) -> Case {
    let [u, v] = [DVec3::AXES[(axis + 1) % 3], DVec3::AXES[(axis + 2) % 3]];
    let matrix = case.index_to_world.matrix3;
    let spacing = DVec3::new(matrix.x_axis.length(), matrix.y_axis.length(), matrix.z_axis.length());
    let index_to_world = DAffine3::from_scale(spacing);
    let middle = case.pose.pixel(0.5 * (case.size[0] as f64 - 1.0), 0.5 * (case.size[1] as f64 - 1.0));
    let length = (middle - case.pose.source).length();
    let [width, height] = case.size.map(|n| n / 2);
    let [column_step, row_step] = [case.pose.column_step.length() * u, case.pose.row_step.length() * v];
    // The central ray goes through 0 along one axis and beside it along the other.
    let at = 0.37 * (case.dimensions[(axis + 1) % 3] as f64 - 1.0) * spacing * u;
    let source = at - 0.4 * length * DVec3::AXES[axis];
    let first_pixel =
        at + 0.6 * length * DVec3::AXES[axis] - width as f64 * column_step - height as f64 * row_step;
    let pose = DetectorPose { source, first_pixel, column_step, row_step };
    Case { index_to_world, pose, ..case.clone() }
}

/// The scene's grid and view, as a pose, as its matrix or as parallel rays, with other signs of its zeros.
fn with_signed_zeros(case: &Case, seed: u64) -> (Case, Vec<ViewRequest>) {
    let mut n = 0;
    let mut sign = || {
        n += 1;
        seed != 0 && noise(seed.wrapping_add(n)) < 0.5
    };
    let mut vector = |v: DVec3| DVec3::from_array(signed_zeros(v.to_array(), &mut sign));
    let pose = DetectorPose {
        source: vector(case.pose.source),
        first_pixel: vector(case.pose.first_pixel),
        column_step: vector(case.pose.column_step),
        row_step: vector(case.pose.row_step),
    };
    let cone = Projection::from_pose(&case.pose, case.size).expect("valid");
    let mut parallel = cone;
    (parallel.matrix.x_axis.w, parallel.matrix.y_axis.w, parallel.matrix.z_axis.w) = (0.0, 0.0, 0.0);
    parallel.matrix.w_axis.w = 1.0;
    let mut views = vec![View::Pose(pose).into()];
    for projection in [cone, parallel] {
        let source = DVec3::from_array(signed_zeros(projection.source.to_array(), &mut sign));
        let matrix = DMat4::from_cols_array(&signed_zeros(projection.matrix.to_cols_array(), &mut sign));
        views.push(View::Projection(Projection { matrix, source }).into());
    }
    let index_to_world =
        DAffine3::from_cols_array(&signed_zeros(case.index_to_world.to_cols_array(), &mut sign));
    (Case { index_to_world, ..case.clone() }, views)
}

proptest! {
    #![proptest_config(scenes(48))]

    #[test]
    fn lengths_scale_with_the_world(case in cases(ANY), exponent in -4..=4) {
        let scale = f64::from(exponent).exp2();
        let scaled = case.moved(DAffine3::from_scale(DVec3::splat(scale)));
        for &engine in case.engines() {
            let mut expected = case.project(engine);
            expected.areal_density.iter_mut().chain(&mut expected.bone_path).for_each(|x| *x *= scale);
            let mut got = scaled.project(engine);
            // Not linear in the lengths.
            (got.intensity, got.line_integral) = (expected.intensity.clone(), expected.line_integral.clone());
            identical(&got, &expected)?;
        }
    }

    #[test]
    fn a_mirrored_world_is_the_same(case in cases(ANY), axis in 0..3_usize) {
        let mirrored = case.moved(DAffine3::from_scale(DVec3::ONE - 2.0 * DVec3::AXES[axis]));
        for &engine in case.engines() {
            identical(&mirrored.project(engine), &case.project(engine))?;
        }
    }

    #[test]
    fn a_turned_world_is_the_same(case in cases(ANY), axis in in_cube(1.0), angle in -3.0..3.0) {
        prop_assume!(axis.length() > 0.1);
        let turned = case.moved(DAffine3::from_axis_angle(axis.normalize(), angle));
        for &engine in case.engines() {
            Tolerance::of(&case, engine).check(&turned.project(engine), &case.project(engine))?;
        }
    }

    #[test]
    fn a_moved_world_is_the_same(case in cases(ANY), by in in_cube(6.0), exact in any::<bool>()) {
        let by = by.map(|exponent| 10_f64.powf(exponent.abs()).copysign(exponent));
        let mut case = case;
        case.index_to_world.translation = on_lattice(case.index_to_world.translation);
        let DetectorPose { source, first_pixel, column_step, row_step } = case.pose;
        case.pose = DetectorPose {
            source: on_lattice(source),
            first_pixel: on_lattice(first_pixel),
            column_step: on_lattice(column_step),
            row_step: on_lattice(row_step),
        };
        let moved = case.moved(DAffine3::from_translation(if exact { on_lattice(by) } else { by }));
        for &engine in case.engines() {
            let [got, expected] = [&moved, &case].map(|case| case.project(engine));
            // A matrix holds the distances to the world's origin, and rounds them.
            if exact && !case.matrix {
                identical(&got, &expected)?;
            } else {
                Tolerance::of(&moved, engine).check(&got, &expected)?;
            }
        }
    }

    #[test]
    fn a_ray_is_the_same_from_its_other_end(case in sized_cases(RAYS, [1, 1])) {
        let case = Case { matrix: false, ..case };
        let DetectorPose { source, first_pixel, .. } = case.pose;
        let back = Case { pose: DetectorPose { source: first_pixel, first_pixel: source, ..case.pose }, ..case.clone() };
        for &engine in case.engines() {
            Tolerance::of(&case, engine).check(&back.project(engine), &case.project(engine))?;
        }
    }

    /// Not for the march, whose sample in a cell is at the middle of the ray's part of it.
    #[test]
    fn two_parts_of_a_ray_add_up(case in sized_cases(&[Joseph, Siddon, Exact], [1, 1]), at in -0.6..0.6_f64) {
        let case = Case { matrix: false, ..case };
        let DetectorPose { source, first_pixel, .. } = case.pose;
        let ray = first_pixel - source;
        let sides = case.dimensions.map(|n| n as f64);
        let across = case.grid().length_mm(DVec3::from_array(sides)) / ray.length();
        let nearest = (case.grid().centre() - source).dot(ray) / ray.length_squared();
        let between = source.lerp(first_pixel, (nearest + at * across).clamp(0.01, 0.99));
        let parts = [
            DetectorPose { first_pixel: between, ..case.pose },
            DetectorPose { source: between, ..case.pose },
        ]
        .map(|pose| Case { pose, ..case.clone() });
        for &engine in case.engines() {
            let [first, second] = parts.each_ref().map(|part| Tolerance::of(part, engine));
            let [a, b] = parts.each_ref().map(|part| part.project(engine));
            first.plus(&second).check(&sum(&a, &b), &case.project(engine))?;
        }
    }

    #[test]
    fn zeros_have_no_sign(case in cases(ANY), axis in 0..3_usize, seed in 1..u64::MAX) {
        let case = straightened(&case, axis);
        let [plus, minus] = [0, seed].map(|seed| with_signed_zeros(&case, seed));
        for &engine in case.engines() {
            let [expected, got] = [&plus, &minus].map(|(case, views)| case.project_views(engine, views));
            identical(&got, &expected)?;
        }
    }
}
