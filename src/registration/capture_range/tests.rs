//! Tables of starts.

use super::*;
use crate::pose_gradient::Signal;
use crate::registration::phantom::{pair, registrar};

fn row(distance: f64, successes: usize) -> CaptureRow {
    CaptureRow { distance, starts: 20, successes, median_error: 0.0, largest_success: 0.0 }
}

#[test]
fn the_range_ends_before_the_first_distance_that_fails() {
    let range = |successes: [usize; 3]| {
        let rows = successes.into_iter().zip([2.0, 4.0, 8.0]).map(|(n, distance)| row(distance, n)).collect();
        CaptureRange { rows }.distance()
    };
    assert_eq!(range([20, 19, 18]), 4.0);
    assert_eq!(range([18, 20, 20]), 0.0);
    assert_eq!(range([20, 20, 20]), 8.0);
}

#[test]
fn starts_are_as_far_as_they_should_be_and_differ() {
    let registrar = registrar::<f32>(1, 1);
    let target = TargetError::new(registrar.finest().volume().grid(), registrar.finest().pivot());
    let truth = RigidMotion { angles: [0.1, 0.0, -0.2], ..RigidMotion::default() };
    let mut seen = Vec::new();
    for distance in [0.5, 5.0, 50.0] {
        for n in 0..5 {
            let mut random = RowRandom::new(3, 0, STARTS, n);
            let start = start(&truth, &target, distance, [random.draws(), random.draws()]);
            assert!((target.between(&truth, &start) / distance - 1.0).abs() < 1e-9);
            assert!(!seen.contains(&start.to_array()));
            seen.push(start.to_array());
        }
    }
}

#[test]
fn near_starts_come_back_and_far_ones_do_not() {
    let registrar = registrar::<f32>(2, 3);
    let truth = RigidMotion { angles: [0.02, -0.05, 0.03], ..RigidMotion::default() };
    let poses = pair(registrar.finest().volume().grid());
    let images =
        poses.map(|pose| registrar.finest().project(&pose, &truth, Signal::LineIntegral).expect("valid"));
    let view = |v: usize| RegistrationView { pose: poses[v], measured: &images[v], mask: None };
    let options = CaptureOptions { distances: vec![5.0, 400.0], starts: 2, ..CaptureOptions::default() };
    let mut reported = 0;
    let range = registrar
        .capture_range(&[view(0), view(1)], &truth, &options, &mut |_, _, _| {
            reported += 1;
            ControlFlow::Continue(())
        })
        .expect("valid");
    assert_eq!((range.rows[0].successes, range.rows[1].successes, reported), (2, 0, 4));
    assert_eq!(range.distance(), 5.0);
    assert!(range.rows[0].median_error < 5e-6, "{range:?}");
}

#[test]
fn a_start_that_fails_is_not_captured() {
    let registrar = registrar::<f32>(1, 2);
    let poses = pair(registrar.finest().volume().grid());
    let still = RigidMotion::default();
    let image = registrar.finest().project(&poses[0], &still, Signal::LineIntegral).expect("valid");
    let views = [RegistrationView { pose: poses[0], measured: &image, mask: None }];
    // The last valid place: about half of the starts are beyond it.
    let truth = RigidMotion { translation: glam::DVec3::new(1e10, 0.0, 0.0), ..still };
    let options = CaptureOptions { distances: vec![5.0], starts: 8, ..CaptureOptions::default() };
    let mut failed = 0;
    let range = registrar.capture_range(&views, &truth, &options, &mut |_, _, left| {
        failed += usize::from(left == f64::INFINITY);
        ControlFlow::Continue(())
    });
    let row = range.expect("a table").rows[0];
    assert!(row.starts == 8 && (1..8).contains(&failed) && row.successes <= 8 - failed, "{row:?} {failed}");
    let none = registrar.capture_range(&[], &truth, &options, &mut |_, _, _| ControlFlow::Continue(()));
    assert!(none.is_err());
}

#[test]
fn bad_options_are_named() {
    let refused = |options: CaptureOptions| options.validate().expect_err("not valid").to_string();
    let good = CaptureOptions::default;
    assert!(refused(CaptureOptions { distances: vec![], ..good() }).starts_with("distances is 0"));
    assert!(refused(CaptureOptions { distances: vec![2.0, 1.0], ..good() }).starts_with("distances[1] is 1"));
    assert!(refused(CaptureOptions { starts: 0, ..good() }).starts_with("starts is 0"));
    assert!(refused(CaptureOptions { success: f64::NAN, ..good() }).starts_with("success is NaN"));
}
