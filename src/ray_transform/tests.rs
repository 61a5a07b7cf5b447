//! The adjoint against the map, the map against chords.

use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

use super::*;
use crate::engine::Backend;
use crate::geometry::{DetectorPose, Projection};

const ALGORITHMS: [Algorithm; 6] = [
    Algorithm::Joseph,
    Algorithm::March { step: 0.7 },
    Algorithm::March { step: 2.5 },
    Algorithm::Siddon,
    Algorithm::DistanceDriven,
    Algorithm::Exact,
];

const SIZE: [usize; 2] = [13, 9];

fn context(threads: usize) -> Context {
    Context::new(Backend::Cpu, threads).expect("threads")
}

/// Axis-aligned; askew, with shear and a mirrored axis; and of single voxels along two axes.
fn grids() -> [Grid; 3] {
    let askew =
        DMat3::from_cols(DVec3::new(-1.7, 0.2, 0.0), DVec3::new(0.5, 1.9, 0.4), DVec3::new(0.1, 0.6, 2.5));
    let askew = DAffine3 { matrix3: askew, translation: DVec3::new(30.0, -12.0, 7.0) };
    [
        Grid::centred([19, 16, 14], DVec3::new(1.0, 1.3, 1.1)),
        Grid::new([14, 21, 10], askew),
        Grid::centred([1, 12, 1], DVec3::new(9.0, 1.0, 8.0)),
    ]
    .map(|grid| grid.expect("valid"))
}

/// From a source far away, near the corner of three driving axes, inside the volume, and at infinity; one that misses.
fn views(grid: &Grid) -> Vec<View> {
    let pose = |angle, sad| DetectorPose::c_arm(grid.centre(), angle, sad, sad + 40.0, 3.0, SIZE);
    let point = |x, y, z| grid.index_to_world().transform_point3(grid.centre_index() + DVec3::new(x, y, z));
    let step = |x, y, z| grid.index_to_world().transform_vector3(DVec3::new(x, y, z));
    let corner = DetectorPose {
        source: point(20.0, 21.0, 19.5),
        first_pixel: point(-20.0, 4.0, -36.0),
        column_step: step(2.0, -2.0, 0.1),
        row_step: step(-2.0, -2.0, 4.0),
    };
    let matrix = DMat4::from_diagonal(DVec4::new(0.05, 0.06, 0.005, 1.0))
        * DMat4::from_rotation_y(0.7)
        * DMat4::from_translation(-grid.centre());
    let miss = DetectorPose { first_pixel: grid.centre() + DVec3::splat(500.0), ..corner };
    vec![
        View::Pose(pose(17.0, 200.0)),
        View::Projection(Projection::from_pose(&pose(48.0, 60.0), SIZE).expect("valid")),
        View::Pose(corner),
        View::Pose(pose(100.0, 2.0)),
        View::Projection(Projection { matrix, source: DVec3::NAN }),
        View::Pose(miss),
    ]
}

fn transform<T: Real>(grid: Grid, algorithm: Algorithm, threads: usize) -> RayTransform<T> {
    RayTransform::new(&context(threads), grid, &views(&grid), SIZE, algorithm).expect("valid")
}

/// Values in [−1, 1] without any symmetry.
fn values<T: Real>(count: usize, seed: u64) -> Vec<T> {
    let mut state = seed;
    let mut value = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        T::of((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    };
    (0..count).map(|_| value()).collect()
}

/// Their inner product, and the same of the magnitudes.
fn dot<T: Real>(a: &[T], b: &[T]) -> [f64; 2] {
    a.iter().zip(b).fold([0.0, 0.0], |[sum, size], (a, b)| {
        let product = (*a).into() * (*b).into();
        [sum + product, size + product.abs()]
    })
}

fn adjoint_is_the_transpose<T: Real>(bound: f64) {
    for (n, grid) in grids().into_iter().enumerate() {
        for algorithm in ALGORITHMS {
            let transform = transform::<T>(grid, algorithm, 2);
            let (x, b) = (values(transform.domain(), 1), values(transform.range(), 2));
            let (ax, atb) = (transform.forward(&x).expect("valid"), transform.adjoint(&b).expect("valid"));
            let ([left, size], [right, _]) = (dot(&ax, &b), dot(&x, &atb));
            let off = (left - right).abs() / size;
            assert!(size > 1.0 && off < bound, "grid {n}, {algorithm}: {left} and {right}, {off:e} off");
        }
    }
}

#[test]
fn the_adjoint_is_the_transpose_in_float64() {
    adjoint_is_the_transpose::<f64>(1e-15);
}

#[test]
fn the_adjoint_is_the_transpose_in_float32() {
    adjoint_is_the_transpose::<f32>(2e-7);
}

#[test]
fn the_adjoint_is_the_transpose_element_by_element() {
    let grid = Grid::centred([5, 6, 7], DVec3::new(3.0, 2.5, 2.0)).expect("valid");
    for algorithm in ALGORITHMS {
        let transform = transform::<f64>(grid, algorithm, 2);
        let unit =
            |n: usize, count: usize| (0..count).map(|k| f64::from(u8::from(k == n))).collect::<Vec<_>>();
        let columns: Vec<_> = (0..transform.domain())
            .map(|voxel| transform.forward(&unit(voxel, transform.domain())).expect("valid"))
            .collect();
        for pixel in 0..transform.range() {
            let row = transform.adjoint(&unit(pixel, transform.range())).expect("valid");
            let same = |(value, column): (&f64, &Vec<f64>)| (value - column[pixel]).abs() < 4e-15;
            assert!(row.iter().zip(&columns).all(same), "{algorithm}, pixel {pixel}");
        }
    }
}

#[test]
fn views_have_rays_of_several_driving_axes() {
    for (grid, driven) in grids().into_iter().zip([3, 3, 2]) {
        let transform = transform::<f64>(grid, Algorithm::Joseph, 1);
        let axes = transform.drives.iter().map(|drives| drives.iter().filter(|drives| **drives).count());
        let axes: Vec<_> = axes.collect();
        assert!(axes[2] == driven && axes[5] == 0, "{axes:?}");
    }
}

#[test]
fn a_constant_volume_gives_chords() {
    for grid in grids() {
        for algorithm in ALGORITHMS {
            let transform = transform::<f64>(grid, algorithm, 1);
            let images = transform.forward(&vec![2.0; transform.domain()]).expect("valid");
            for (pixel, value) in images.into_iter().enumerate() {
                let chord = transform
                    .line(pixel)
                    .map_or(0.0, |line| (line.span.leave - line.span.enter) * line.ray.mm_per_slice);
                assert!((value - 2.0 * chord).abs() < 2e-13, "{algorithm}: {value}, chord {chord}");
            }
        }
    }
}

#[test]
fn images_and_back_projections_are_linear() {
    let combined = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 3.0 * a - 0.7 * b).collect::<Vec<_>>();
    let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    for algorithm in ALGORITHMS {
        let transform = transform::<f64>(grids()[1], algorithm, 2);
        let of = |x: &[f64]| transform.forward(x).expect("valid");
        let (x, y) = (values(transform.domain(), 3), values(transform.domain(), 4));
        assert!(same(&of(&combined(&x, &y)), &combined(&of(&x), &of(&y))), "{algorithm}");
        let of = |x: &[f64]| transform.adjoint(x).expect("valid");
        let (x, y) = (values(transform.range(), 5), values(transform.range(), 6));
        assert!(same(&of(&combined(&x, &y)), &combined(&of(&x), &of(&y))), "{algorithm}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let grid = Grid::centred([37, 41, 29], DVec3::new(0.6, 0.5, 0.7)).expect("valid");
    for algorithm in ALGORITHMS {
        let results = [1, 2, 3].map(|threads| {
            let transform = transform::<f32>(grid, algorithm, threads);
            let images = transform.forward(&values(transform.domain(), 7)).expect("valid");
            let back = transform.adjoint(&values(transform.range(), 8)).expect("valid");
            [images, back].map(|values| values.into_iter().map(f32::to_bits).collect::<Vec<_>>())
        });
        assert!(results[0] == results[1] && results[0] == results[2], "{algorithm}");
    }
}

#[test]
fn float32_is_near_its_twin() {
    for algorithm in ALGORITHMS {
        let (narrow, wide) =
            (transform::<f32>(grids()[1], algorithm, 2), transform(grids()[1], algorithm, 2));
        let x: Vec<f32> = values(narrow.domain(), 9);
        let images = narrow.forward(&x).expect("valid");
        let twin = wide.forward(&x.into_iter().map(f64::from).collect::<Vec<_>>()).expect("valid");
        let off = images.iter().zip(&twin).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-5, "{algorithm}: {off:e} mm");
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let grid = grids()[0];
    let made = |views: &[View], size, algorithm| {
        RayTransform::<f64>::new(&context(1), grid, views, size, algorithm).map(|_| ())
    };
    let message = |result: Result<()>| result.expect_err("refused").to_string();
    let good = views(&grid);
    let mut bad = good.clone();
    bad[2] = View::Pose(DetectorPose {
        source: DVec3::NAN,
        ..DetectorPose::c_arm(DVec3::ZERO, 0.0, 9.0, 20.0, 1.0, SIZE)
    });
    assert!(message(made(&bad, SIZE, Algorithm::Exact)).starts_with("views[2].source is [NaN"));
    assert_eq!(message(made(&[], SIZE, Algorithm::Exact)), "number of views is 0; valid: at least 1");
    assert_eq!(message(made(&good, [0, 4], Algorithm::Exact)), "size[0] is 0; valid: 1 … 32768 pixels");
    let step = message(made(&good, SIZE, Algorithm::March { step: 0.0 }));
    assert_eq!(step, "algorithm.step is 0; valid: 0.015625 … 8 voxels");

    let transform = transform::<f64>(grid, Algorithm::Exact, 1);
    let [voxels, pixels] = [transform.domain(), transform.range()];
    let short = transform.forward(&vec![0.0; voxels - 1]).map(|_| ());
    assert_eq!(message(short), format!("volume's length is {}; valid: {voxels}, one per voxel", voxels - 1));
    let mut images = vec![0.0; pixels];
    images[17] = f64::INFINITY;
    assert_eq!(message(transform.adjoint(&images).map(|_| ())), "images[17] is inf; valid: finite numbers");
}
