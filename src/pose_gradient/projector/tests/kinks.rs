//! Where the signal has no derivative, or nearly none.

use super::*;

#[test]
fn kinks_have_a_slope_between_those_of_either_side() {
    // Rays of the middle column and row run along planes through voxel centres, where the field's slope jumps.
    let grid = Grid::centred([9, 9, 9], DVec3::ONE).expect("valid");
    let hu: Vec<f32> = (0..729).map(|n| ((n * n * 31 + n * 7919) % 1009) as f32).collect();
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("known");
    let volume = Arc::new(Volume::from_float32(grid, &hu, Some(&[2; 729]), &how).expect("valid"));
    let view = DetectorPose::c_arm(DVec3::ZERO, 0.0, 500.0, 1000.0, 4.0, [3, 3]);
    let still = RigidMotion::default();
    for algorithm in [Algorithm::Joseph, Algorithm::March { step: 0.7 }, Algorithm::Exact] {
        let scene = Scene { method: algorithm.into(), ..Scene::new([3, 3]).expect("valid") };
        let projector = projector::<f64>(&volume, &scene);
        let jacobian = projector.jacobian(&view, &still, Signal::LineIntegral).expect("valid");
        for (k, pixels) in [(3, [1, 4, 7]), (5, [3, 4, 5])] {
            let h = 1e-6;
            let at = |by: f64| projector.project(&view, &moved(&still, k, by), Signal::LineIntegral);
            let [before, here, after] = [-h, 0.0, h].map(|by| at(by).expect("valid"));
            for n in pixels {
                let (left, right) = ((here[n] - before[n]) / h, (after[n] - here[n]) / h);
                assert!((left - right).abs() > 1e-4, "{algorithm}: no kink at {n}");
                let derivative = jacobian.derivatives[k][n];
                let (low, high) = (left.min(right) - 1e-7, left.max(right) + 1e-7);
                assert!(
                    low < derivative && derivative < high,
                    "{algorithm}, {n}: {derivative}, {low} … {high}"
                );
            }
        }
    }
}

#[test]
fn a_far_source_sees_no_motion_along_its_beam() {
    let grid = upright();
    let projector = projector::<f64>(&volume(grid), &scene(Algorithm::Exact));
    let view = DetectorPose::c_arm(grid.centre(), 0.0, 1e7, 1e7 + 100.0, 3.0, SIZE);
    let jacobian = projector.jacobian(&view, &MOTIONS[0], Signal::LineIntegral).expect("valid");
    let largest = |k: usize| jacobian.derivatives[k].iter().fold(0.0_f64, |most, d| most.max(d.abs()));
    assert!(largest(4) < 1e-5 * largest(3).min(largest(5)), "{:e} {:e}", largest(3), largest(4));
}

#[test]
fn rays_that_nothing_passes_have_finite_derivatives() {
    let grid = Grid::centred(DIMENSIONS, DVec3::splat(2e4)).expect("valid");
    let view = DetectorPose::c_arm(DVec3::ZERO, 23.0, 1e6, 2e6, 3e4, SIZE);
    let projector = projector::<f64>(&volume(grid), &scene(Algorithm::Joseph));
    let [p, i] = [Signal::LineIntegral, Signal::Intensity]
        .map(|signal| projector.jacobian(&view, &MOTIONS[0], signal).expect("valid"));
    let opaque = (0..p.image.len()).filter(|&n| i.image[n] == 0.0).collect::<Vec<_>>();
    assert!(opaque.len() > 10);
    for n in opaque {
        assert!(p.image[n] > 700.0 && p.image[n].is_finite());
        for (p, i) in p.derivatives.iter().zip(&i.derivatives) {
            assert!(p[n].is_finite() && p[n] != 0.0 && i[n] == 0.0);
        }
    }
}
