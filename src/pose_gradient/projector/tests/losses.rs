//! Losses, and arguments that are not valid.

use super::*;

#[test]
fn losses_are_sums_over_the_jacobian_for_any_number_of_threads() {
    let grid = sheared();
    let (volume, scene, view) = (volume(grid), scene(Algorithm::Joseph), views(&grid)[0]);
    let one = projector::<f64>(&volume, &scene);
    let jacobian = one.jacobian(&view, &MOTIONS[0], Signal::LineIntegral).expect("valid");
    let measured: Vec<f64> =
        jacobian.image.iter().enumerate().map(|(n, p)| p + 0.01 * (n % 5) as f64).collect();
    let mask: Vec<bool> = (0..measured.len()).map(|n| n % 7 != 3).collect();
    let mut expected = NormalEquations::<PARAMETERS>::default();
    for n in (0..measured.len()).filter(|&n| mask[n]) {
        expected.add(jacobian.image[n] - measured[n], &std::array::from_fn(|k| jacobian.derivatives[k][n]));
    }
    let sums = [1, 2, 5].map(|threads| {
        let context = Context::new(Backend::Cpu, threads).expect("threads");
        let projector = PoseProjector::<f64>::new(&context, volume.clone(), &scene).expect("valid");
        projector
            .loss_value_and_grad(&view, &MOTIONS[0], Signal::LineIntegral, &measured, Some(&mask))
            .expect("valid")
    });
    assert!(sums[0] == sums[1] && sums[0] == sums[2]);
    assert_eq!(sums[0].rays, expected.rays);
    assert!((sums[0].loss / expected.loss - 1.0).abs() < 1e-14);
    for k in 0..6 {
        assert!((sums[0].gradient[k] - expected.gradient[k]).abs() < 1e-12 * expected.gradient[k].abs());
        assert!((sums[0].hessian[k][k] / expected.hessian[k][k] - 1.0).abs() < 1e-13);
    }
}

#[test]
fn what_is_not_valid_is_refused_by_name() {
    let grid = upright();
    let (volume, good) = (volume(grid), scene(Algorithm::Joseph));
    let projector = projector::<f64>(&volume, &good);
    let (view, motion, image) = (views(&grid)[0], MOTIONS[0], vec![0.0; SIZE[0] * SIZE[1]]);
    let loss = |view: &DetectorPose, motion: &RigidMotion, image: &[f64], mask: Option<&[bool]>| {
        let sums = projector.loss_value_and_grad(view, motion, Signal::Intensity, image, mask);
        sums.expect_err("not valid").to_string()
    };
    let flat = DetectorPose { row_step: view.column_step, ..view };
    assert!(loss(&flat, &motion, &image, None).starts_with("view.column_step and row_step is"));
    let nan = RigidMotion { angles: [0.0, f64::NAN, 0.0], ..motion };
    assert!(loss(&view, &nan, &image, None).starts_with("motion.beta is NaN"));
    assert_eq!(loss(&view, &motion, &image[1..], None), "measured's length is 55; valid: 56, one per pixel");
    assert!(loss(&view, &motion, &image, Some(&[true])).starts_with("mask's length is 1"));
    assert!(loss(&view, &motion, &image, Some(&[false; 56])).starts_with("mask is empty"));
    let mut infinite = image.clone();
    infinite[7] = f64::INFINITY;
    assert_eq!(
        loss(&view, &motion, &infinite, None),
        "measured[7] is inf; valid: finite numbers where pixels count"
    );
    let but = std::array::from_fn::<_, 56, _>(|n| n != 7);
    let masked = projector.loss_value_and_grad(&view, &motion, Signal::Intensity, &infinite, Some(&but));
    assert_eq!(masked.expect("valid").rays, 55);
    let context = Context::new(Backend::Cpu, 1).expect("threads");
    let refused = |scene: &Scene| {
        PoseProjector::<f32>::new(&context, volume.clone(), scene).err().expect("not valid").to_string()
    };
    let tolerant = Scene { tolerance: Some(crate::Tolerance::STANDARD), ..good.clone() };
    assert!(refused(&tolerant).contains("a tolerance: give the scene a method"));
    let layers = [good.detector_layers.clone(), good.detector_layers.clone()].concat();
    assert!(refused(&Scene { detector_layers: layers, ..good.clone() }).contains("second detector layer"));
    let step = Algorithm::March { step: 0.0 };
    assert!(refused(&Scene { method: step.into(), ..good.clone() }).starts_with("scene.step_voxels is 0"));
    let far = projector.with_pivot(DVec3::new(0.0, f64::NAN, 0.0)).err().expect("NaN").to_string();
    assert!(far.starts_with("pivot is"), "{far}");
}
