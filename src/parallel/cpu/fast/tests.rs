//! What is vectorised against the plain sum, ray by ray.

use super::*;
use crate::parallel::cpu::steps::integrate as plain;
use crate::parallel::frame::Frame;
use crate::parallel::{RaySelection, ViewParameters};

/// Values without any symmetry, to the very border.
fn field(geometry: &ParallelGeometry) -> Field<f32> {
    let [nx, ny, nz] = geometry.dimensions;
    let value = |n: usize| 0.5 + ((n * 7919) % 1009) as f32 / 1009.0;
    let values: Vec<f32> = (0..nx * ny * nz).map(value).collect();
    Field::new(geometry, &values).expect("valid")
}

/// Largest difference of values, slopes and moments from the plain sums' of float64, each to the largest such sum; in
/// float32 the plain sums differ by rounding as well.
fn difference(geometry: &ParallelGeometry, parameters: ViewParameters, rays: RaySelection<'_>) -> [f64; 3] {
    let field = field(geometry);
    let frame = Frame::new(geometry, &parameters);
    let derivatives = Frame::derivatives(geometry, &parameters);
    let view = ViewRays { frame: &frame, derivatives: &derivatives, rays };
    let [nu, nv] = geometry.detector;
    let (mut most, mut off) = ([0.0_f64; 3], [0.0_f64; 3]);
    for u in 0..nu {
        let column = Column { field: &field, geometry, view: &view, u };
        let [mut values, mut sums] = [vec![RaySum::default(); nv], vec![RaySum::default(); nv]];
        integrate::<false>(column, &mut values);
        integrate::<true>(column, &mut sums);
        for v in 0..nv {
            let pixel = v * nu + u;
            if !rays.counts(pixel) {
                continue;
            }
            assert_eq!(values[v].value, sums[v].value, "with derivatives or without, at [{u}, {v}]");
            let plain = plain(&field, geometry, &frame, [u, v], rays.length(pixel));
            let mut compare = |n: usize, fast: f64, plain: f64| {
                most[n] = most[n].max(plain.abs());
                off[n] = off[n].max((fast - plain).abs());
            };
            compare(0, sums[v].value, plain.value);
            for axis in 0..3 {
                compare(1, sums[v].slope[axis], plain.slope[axis]);
                compare(2, sums[v].moment[axis], plain.moment[axis]);
            }
        }
    }
    assert!(most[0] > 0.0);
    [0, 1, 2].map(|n| off[n] / most[n])
}

/// Nothing is cubic, rows are no multiple of lanes, rays start and end outside.
fn geometry() -> ParallelGeometry {
    let spacing = DVec3::new(1.0, 1.3, 0.8);
    let geometry = ParallelGeometry::new([23, 19, 41], spacing, [9, 53], [3.1, 0.8]).with_step(0.37);
    ParallelGeometry {
        centre: DVec3::new(0.4, -3.0, 0.2),
        detector_centre: [0.1, -0.3],
        steps: 150,
        ..geometry
    }
}

fn view(alpha: f64, beta: f64, phi: f64) -> ViewParameters {
    ViewParameters { alpha, beta, phi, dx: 0.33, dz: -0.41 }
}

#[test]
fn any_angle_and_any_tilt_is_the_plain_sum() {
    for phi in [0.0, 0.4, 1.3, 1.6, 3.0, 4.4, -0.9] {
        for (alpha, beta) in [(0.0, 0.0), (0.013, -0.007), (-0.05, 0.03), (0.2, 0.1), (1.2, -0.6), (3.1, 0.0)]
        {
            let off = difference(&geometry(), view(alpha, beta, phi), RaySelection::default());
            assert!(off[0] < 1e-6 && off[1] < 2e-5 && off[2] < 2e-5, "{alpha}, {beta}, {phi}: {off:?}");
        }
    }
}

#[test]
fn rows_need_not_be_as_far_apart_as_voxels() {
    for dv in [0.3, 0.5, 0.7, 0.81, 0.79, 1.0, 1.6, 2.3] {
        let geometry = ParallelGeometry { pixel: [3.1, dv], ..geometry() };
        let off = difference(&geometry, view(0.02, 0.03, 0.7), RaySelection::default());
        assert!(off[0] < 1e-6 && off[1] < 2e-5 && off[2] < 2e-5, "{dv}: {off:?}");
    }
}

#[test]
fn masks_and_lengths_are_those_of_the_plain_sum() {
    let geometry = geometry();
    let mask: Vec<bool> = (0..geometry.pixels()).map(|pixel| pixel % 7 < 2).collect();
    let lengths = |pixel: usize| [-9.0 + 0.01 * pixel as f64, 3.0 + 0.003 * pixel as f64];
    let lengths: Vec<_> = (0..geometry.pixels()).map(lengths).collect();
    for rays in [
        RaySelection { mask: Some(&mask), lengths: None },
        RaySelection { mask: None, lengths: Some(&lengths) },
        RaySelection { mask: Some(&mask), lengths: Some(&lengths) },
    ] {
        for (alpha, beta) in [(0.01, 0.02), (0.9, 0.1)] {
            let off = difference(&geometry, view(alpha, beta, 0.5), rays);
            assert!(off[0] < 1e-6 && off[1] < 2e-5 && off[2] < 2e-5, "{alpha}, {beta}: {off:?}");
        }
    }
}

#[test]
fn samples_in_faces_take_the_upper_cells_slope() {
    let geometry = ParallelGeometry::new([11, 9, 20], DVec3::ONE, [11, 20], [1.0, 1.0]);
    let off = difference(&geometry, ViewParameters::default(), RaySelection::default());
    assert!(off[0] < 1e-6 && off[1] < 1e-5 && off[2] < 1e-5, "{off:?}");
}
