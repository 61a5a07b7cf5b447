//! The distance-driven mean: what it conserves, what it averages, and its limits.
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::sync::Arc;

use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, Projection, View};
use drr::volume::Volume;
use drr::{Algorithm, Scene, ViewRequest};
use glam::{DMat4, DVec2, DVec3, DVec4};
use support::{awkward_grid, classification, noise, poses, projector};

const SOFT_TISSUE: usize = 2;

/// Soft tissue of 0 HU, 1 g/cm³, and what `hu` makes of it.
fn volume(grid: Grid, hu: impl Fn([usize; 3]) -> i16) -> Arc<Volume> {
    let [n0, n1, _] = grid.dimensions();
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|v| hu([v % n0, v / n0 % n1, v / n0 / n1])).collect();
    let labels = vec![SOFT_TISSUE as u8; hu.len()];
    Arc::new(Volume::from_int16(grid, &hu, Some(&labels), &classification()).expect("valid"))
}

/// Areal densities in float64, g/cm².
fn exactly(volume: &Arc<Volume>, algorithm: Algorithm, size: [usize; 2], view: ViewRequest) -> Vec<f64> {
    let layers = Layers { areal_density: true, ..Layers::default() };
    let projector = projector(Backend::Reference, volume, Scene::new(size).expect("valid"));
    let images = projector.reference(algorithm, &[view], layers, SILENT).expect("projects");
    images.areal_density(0, SOFT_TISSUE).to_vec()
}

fn fast(volume: &Arc<Volume>, size: [usize; 2], view: ViewRequest) -> Vec<f64> {
    let layers = Layers { areal_density: true, ..Layers::default() };
    let scene = Scene { method: Algorithm::DistanceDriven.into(), ..Scene::new(size).expect("valid") };
    let images = projector(Backend::Cpu, volume, scene).project(&[view], layers, SILENT).expect("projects");
    images.areal_density(0, SOFT_TISSUE).iter().map(|&x| f64::from(x)).collect()
}

/// Both engines: their images, and how close each has to be, relative.
fn both(volume: &Arc<Volume>, size: [usize; 2], view: &ViewRequest) -> [(Vec<f64>, f64); 2] {
    [
        (exactly(volume, Algorithm::DistanceDriven, size, view.clone()), 1e-13),
        (fast(volume, size, view.clone()), 1e-6),
    ]
}

/// Parallel rays along (slope, 1), mm per mm of z. Pixels are `pixel` mm large on planes across z, along x and y; at z = 0
/// the middle of the detector is at `middle`.
fn parallel(slope: DVec2, pixel: DVec2, middle: DVec2, [width, height]: [usize; 2]) -> ViewRequest {
    let [a, b] = [2.0 / (pixel.x * width as f64), 2.0 / (pixel.y * height as f64)];
    let rows = [
        DVec4::new(a, 0.0, -a * slope.x, -a * middle.x),
        // Rows of pixels go down.
        DVec4::new(0.0, -b, b * slope.y, b * middle.y),
        DVec4::new(0.0, 0.0, 0.001, 0.0),
        DVec4::W,
    ];
    let matrix = DMat4::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose();
    View::Projection(Projection { matrix, source: DVec3::NAN }).into()
}

#[test]
fn a_constant_volume_gives_chords() {
    let mut hits = 0;
    for grid in
        [awkward_grid([20, 24, 16]), Grid::axis_aligned([9, 1, 30], DVec3::ONE, DVec3::ZERO).expect("valid")]
    {
        let water = volume(grid, |_| 0);
        // Pixels of several voxels.
        for (name, pose) in poses(&grid, [9, 8]) {
            let request = ViewRequest::from(View::Pose(pose));
            let chords = exactly(&water, Algorithm::Siddon, [9, 8], request.clone());
            hits += chords.iter().filter(|&&chord| chord > 0.0).count();
            for (seen, relative) in both(&water, [9, 8], &request) {
                for (seen, chord) in seen.iter().zip(&chords) {
                    assert!((seen - chord).abs() <= relative * chord, "{name}: {seen} of {chord}");
                }
            }
        }
    }
    assert!(hits > 200, "{hits}");
}

#[test]
fn pixels_of_one_voxel_give_the_sums_of_their_columns() {
    let grid = Grid::axis_aligned([7, 6, 40], DVec3::new(1.5, 0.7, 2.0), DVec3::ZERO).expect("valid");
    let hu = |[i, j, k]: [usize; 3]| (1000.0 * noise((i + 7 * (j + 6 * k)) as u64)) as i16 - 500;
    let body = volume(grid, hu);
    let view = parallel(DVec2::ZERO, DVec2::new(1.5, 0.7), DVec2::new(4.5, 1.75), [7, 6]);
    for (seen, relative) in both(&body, [7, 6], &view) {
        for (pixel, seen) in seen.iter().enumerate() {
            // 2 mm each.
            let density = |k: usize| body.voxels().get(42 * k + pixel).density;
            let column: f64 = (0..40).map(|k| 0.2 * density(k)).sum();
            assert!((seen - column).abs() < relative * column, "{pixel}: {seen} of {column}");
        }
    }
}

/// What rays through points do not have: whatever the pixels' size and place, none of the mass is lost or seen twice. A
/// border of vacuum, so that no pixel that sees any has its ray outside the volume.
#[test]
fn all_pixels_together_see_the_whole_mass() {
    let (n, border) = ([24, 26, 12], 7);
    let spacing = DVec3::new(1.1, 0.9, 1.6);
    let grid = Grid::axis_aligned(n, spacing, DVec3::new(-12.0, -11.0, -9.0)).expect("valid");
    let hu = |[i, j, k]: [usize; 3]| {
        let inside = (border..n[0] - border).contains(&i) && (border..n[1] - border).contains(&j);
        if inside { (1900.0 * noise((i + 24 * (j + 26 * k)) as u64)) as i16 - 900 } else { -1000 }
    };
    let body = volume(grid, hu);
    // mg: mm³ of g/cm³.
    let voxels = (0..grid.voxel_count()).map(|v| body.voxels().get(v).density);
    let mass = voxels.sum::<f64>() * spacing.element_product();
    for (slope, pixel, middle, size) in [
        ([0.0, 0.0], [1.1, 0.9], [0.0, 0.0], [40, 40]),
        ([0.0, 0.0], [1.1, 0.9], [0.37, -0.61], [40, 40]),
        ([0.0, 0.0], [0.13, 0.21], [0.01, 0.02], [270, 190]),
        ([0.0, 0.0], [7.3, 6.1], [1.3, 2.9], [7, 8]),
        ([0.12, -0.2], [0.77, 1.7], [0.4, 0.1], [60, 40]),
        ([-0.23, 0.15], [4.9, 3.3], [-2.0, 1.0], [12, 16]),
    ] {
        let [slope, pixel, middle] = [slope, pixel, middle].map(DVec2::from_array);
        let view = parallel(slope, pixel, middle, size);
        // Across the rays pixels are as much smaller as slices are longer.
        let area = pixel.element_product() / slope.extend(1.0).length();
        for ((seen, _), relative) in both(&body, size, &view).into_iter().zip([1e-12, 1e-6]) {
            // g/cm² times mm² is 10 mg.
            let seen = 10.0 * area * seen.iter().sum::<f64>();
            assert!(
                (seen / mass - 1.0).abs() < relative,
                "{slope} {pixel} {middle}: {:e}",
                seen / mass - 1.0
            );
        }
    }
    // Rays through the middles of the large pixels do not.
    let view = parallel(DVec2::ZERO, DVec2::new(7.3, 6.1), DVec2::new(1.3, 2.9), [7, 8]);
    let siddon: f64 = exactly(&body, Algorithm::Siddon, [7, 8], view).iter().sum();
    assert!((10.0 * 7.3 * 6.1 * siddon / mass - 1.0).abs() > 0.01);
}

/// Pixels about five voxels wide in a cone, against the mean of 20 × 20 exact lengths through voxels in each. What is left is
/// that slices are crossed at their middles only, and rectangles that stand for parallelograms.
#[test]
fn wide_pixels_are_means_over_their_area() {
    let (grid, size, fine) = (Grid::centred([40, 44, 36], DVec3::ONE).expect("valid"), [8, 7], 20);
    let body = volume(grid, |[i, j, k]| {
        let p = DVec3::new(i as f64 - 19.5, j as f64 - 21.5, k as f64 - 17.5);
        if p.length() < 15.0 { (400.0 * noise((i + 40 * (j + 44 * k)) as u64)) as i16 } else { -1000 }
    });
    for (angle, bound) in [(0.0, 1.5e-3), (20.0, 1e-3), (45.0, 2e-3)] {
        let pose = DetectorPose::c_arm(DVec3::ZERO, angle, 500.0, 750.0, 7.5, size);
        let middles = exactly(&body, Algorithm::DistanceDriven, size, View::Pose(pose).into());
        let rays = DetectorPose {
            first_pixel: pose.pixel(-0.5 + 0.5 / f64::from(fine), -0.5 + 0.5 / f64::from(fine)),
            column_step: pose.column_step / f64::from(fine),
            row_step: pose.row_step / f64::from(fine),
            ..pose
        };
        let many = size.map(|n| n * fine as usize);
        let lengths = exactly(&body, Algorithm::Siddon, many, View::Pose(rays).into());
        let (mut off, mut all) = (0.0, 0.0);
        for (pixel, seen) in middles.iter().enumerate() {
            let [i, j] = [pixel % size[0], pixel / size[0]].map(|n| n * fine as usize);
            let rows = (0..fine as usize).map(|b| &lengths[(j + b) * many[0] + i..][..fine as usize]);
            let mean = rows.flatten().sum::<f64>() / f64::from(fine * fine);
            off += (seen - mean).powi(2);
            all += mean * mean;
        }
        let off = (off / all).sqrt();
        assert!(off < bound, "{angle}: {off:e}");
    }
}

#[test]
fn a_pixel_far_below_a_voxel_is_the_voxel_under_it() {
    let grid = Grid::axis_aligned([5, 4, 30], DVec3::ONE, DVec3::ZERO).expect("valid");
    let hu = |[i, j, _]: [usize; 3]| 100 * i as i16 - 70 * j as i16;
    let body = volume(grid, hu);
    let density = |i: usize, j: usize| body.voxels().get(5 * j + i).density;
    for pixel in [1e-3, 1e-9, 1e-30] {
        for (at, right) in [
            ([2.2, 1.4], density(2, 1)),
            ([-0.4, 3.3], density(0, 3)),
            ([2.5, 1.0], 0.5 * (density(2, 1) + density(3, 1))),
        ] {
            let view = parallel(DVec2::ZERO, DVec2::splat(pixel), DVec2::from_array(at), [1, 1]);
            for (seen, relative) in both(&body, [1, 1], &view) {
                assert!((seen[0] / 3.0 - right).abs() < relative, "{pixel:e} at {at:?}: {seen:?}");
            }
        }
    }
}

/// Every third pixel of every third row is as wide as it was, and a part of one is a part as wide.
#[test]
fn pixels_keep_their_size_however_their_rays_are_chosen() {
    let grid = awkward_grid([20, 24, 16]);
    let body = volume(grid, |[i, j, k]| (900.0 * noise((i + 20 * (j + 24 * k)) as u64)) as i16);
    let (_, pose) = poses(&grid, [12, 9])[4];
    let few = DetectorPose { column_step: 3.0 * pose.column_step, row_step: 3.0 * pose.row_step, ..pose };
    let all = both(&body, [12, 9], &View::Pose(pose).into());
    let some = both(&body, [4, 3], &ViewRequest { stride: 3, ..View::Pose(few).into() });
    for ((all, relative), (some, _)) in all.iter().zip(&some) {
        for (n, some) in some.iter().enumerate() {
            let all = all[n / 4 * 3 * 12 + n % 4 * 3];
            assert!((some - all).abs() <= 10.0 * relative * all, "{n}: {some} {all}");
        }
    }
    let layers = Layers { areal_density: true, ..Layers::default() };
    let halves = DetectorPose {
        first_pixel: pose.pixel(-0.25, -0.25),
        column_step: 0.5 * pose.column_step,
        row_step: 0.5 * pose.row_step,
        ..pose
    };
    for ((halves, relative), backend) in
        both(&body, [24, 18], &View::Pose(halves).into()).iter().zip([Backend::Reference, Backend::Cpu])
    {
        let scene = Scene { supersampling: 2, ..Scene::new([12, 9]).expect("valid") };
        let scene = Scene { method: Algorithm::DistanceDriven.into(), ..scene };
        let images = projector(backend, &body, scene).project(&[View::Pose(pose).into()], layers, SILENT);
        let images = images.expect("projects");
        for (n, &whole) in images.areal_density(0, SOFT_TISSUE).iter().enumerate() {
            let [i, j] = [n % 12, n / 12];
            let part = |k: usize| halves[(2 * j + k / 2) * 24 + 2 * i + k % 2];
            let mean = 0.25 * (0..4).map(part).sum::<f64>();
            assert!((f64::from(whole) - mean).abs() <= relative.max(2e-7) * mean, "{n}: {whole} {mean}");
        }
    }
    let none = ViewRequest { stride: 0, ..View::Pose(pose).into() };
    let projector = projector(Backend::Cpu, &body, Scene::new([12, 9]).expect("valid"));
    let error = projector.project(&[none], layers, SILENT).expect_err("no pixel is that wide");
    assert!(error.to_string().starts_with("views[0].stride is 0"), "{error}");
}
