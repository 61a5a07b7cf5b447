//! Focal spots: from points all over them, and what the planner makes of small ones.

use drr::effects::{Effects, FocalSpot};
use drr::engine::SILENT;
use drr::geometry::{Projection, View};
use drr::{Focus, Projector, Scene, Tolerance};

use crate::stand::{
    SIDE, SIGNALS, SIZE, block, context, image, intensity, pose, projector, scene, view, volume,
};

fn spot(width_mm: f64, height_mm: f64) -> Effects {
    Effects { focal_spot: Some(FocalSpot { width_mm, height_mm }), ..Effects::default() }
}

/// A thin plate that covers half of the view: its edge's shadow is a ramp as wide as the penumbra.
#[test]
fn the_shadow_of_an_edge_is_a_ramp_as_wide_as_the_penumbra() {
    // A plate of one voxel's thickness at y = 1, seen straight from 600 mm in front; the detector 300 mm behind.
    let plate = volume([60, 2, 60], |at| if at.y > 0.0 && at.x < 0.0 { 0 } else { -1000 });
    let width_mm = 8.0;
    let straight = drr::geometry::DetectorPose::c_arm(glam::DVec3::ZERO, 0.0, 600.0, 900.0, 0.5, SIZE);
    let expected_views = vec![View::Pose(straight)];
    let scene = Scene { expected_views, ..scene(spot(width_mm, 0.0)) };
    let images =
        projector(&plate, scene).project(&[View::Pose(straight).into()], SIGNALS, SILENT).expect("projects");
    let row = &images.intensity[SIDE / 2 * SIDE..][..SIDE];
    let (covered, open) = (f64::from(row[0]), f64::from(row[SIDE - 1]));
    assert!((open - 1.0).abs() < 1e-6 && covered < 0.999, "{covered} {open}");
    let blur = width_mm * (900.0 - 601.0) / 601.0;
    for (i, &signal) in row.iter().enumerate() {
        let from_edge = (i as f64 - (SIDE as f64 - 1.0) / 2.0) * 0.5;
        let ramp = (0.5 + from_edge / blur).clamp(0.0, 1.0);
        let seen = (f64::from(signal) - covered) / (open - covered);
        // The voxels' own ramp is 2 mm wide at the plate, 3 mm on the detector: it rounds the ends.
        assert!((seen - ramp).abs() < 0.11, "pixel {i}: {seen} for {ramp}");
        if (ramp - 0.5).abs() < 0.15 {
            assert!((seen - ramp).abs() < 0.02, "pixel {i}: {seen} for {ramp}");
        }
    }
}

#[test]
fn a_small_spot_is_left_out_with_its_error_and_a_large_one_is_not() {
    let volume = block();
    let with = |width_mm: f64, hu: f64| {
        let scene = Scene { tolerance: Some(Tolerance::hu(hu)), ..scene(spot(width_mm, width_mm)) };
        Projector::new(&context(), volume.clone(), scene).expect("planned")
    };
    let small = with(0.01, 2.0);
    let plan = small.plan();
    let [left] = plan.left_out.as_slice() else { panic!("{:?}", plan.left_out) };
    assert!(
        left.name == "focal spot" && left.hu <= left.allowed_hu && left.what.contains("penumbra"),
        "{left:?}"
    );
    assert!(plan.to_string().contains("skip  focal spot"), "{plan}");
    // What was left out is not in the code that runs: bit for bit the image without it.
    let plain = Scene { tolerance: Some(Tolerance::hu(2.0)), ..scene(Effects::default()) };
    let plain = Projector::new(&context(), volume.clone(), plain).expect("planned");
    let own = |projector: &Projector| projector.project(&[view(3.0)], SIGNALS, SILENT).expect("projects");
    // The plain one may sum few energies; both keep the tolerance.
    let rms = hu(&own(&small).line_integral, &own(&plain).line_integral);
    assert!(rms < 2.0, "{rms}");
    let large = with(3.0, 0.05);
    assert!(
        large.plan().left_out.is_empty()
            && large.plan().focus.as_ref().is_some_and(|f| f.focus == Focus::Points)
    );
}

/// However small its penumbra, a spot that is simulated has an extent.
#[test]
fn a_penumbra_of_half_a_pixel_is_seen() {
    let volume = block();
    let (point, spread) = (intensity(&volume, Effects::default()), intensity(&volume, spot(2.0, 2.0)));
    let worst = crate::stand::worst_ratio(&spread, &point);
    assert!(worst > 1e-4 && worst < 0.05, "{worst}");
}

/// The chosen way is as good as it says, over every pixel.
#[test]
fn a_convolution_keeps_the_tolerance_that_it_was_chosen_for() {
    let volume = block();
    let exact = image(&volume, scene(spot(8.0, 8.0)));
    let mut convolved = 0;
    for hu_allowed in [20.0, 60.0, 200.0, 600.0] {
        let scene = Scene { tolerance: Some(Tolerance::hu(hu_allowed)), ..scene(spot(8.0, 8.0)) };
        let projector = Projector::new(&context(), volume.clone(), scene).expect("planned");
        let focus = projector.plan().focus.clone().expect("a focal spot").focus;
        if focus == Focus::Convolved {
            convolved += 1;
            // What lies before the volume would be blurred with it.
            let exposure = projector.expose(&[view(3.0)], SILENT).expect("exposes");
            let uneven =
                Scene { effects: Effects { fall_off: true, ..spot(8.0, 8.0) }, ..projector.scene().clone() };
            let message = exposure.develop(&uneven, SIGNALS).expect_err("refused").to_string();
            assert!(message.contains("fall-off") && message.contains("convolution"), "{message}");
        }
        let own = projector.project(&[view(3.0)], SIGNALS, SILENT).expect("projects");
        let rms = hu(&own.line_integral, &exact.line_integral);
        assert!(rms <= hu_allowed, "{hu_allowed} HU: {rms} with {focus:?}");
    }
    assert!(convolved > 0, "no tolerance made the planner convolve");
}

/// Root mean square in HU-equivalents over the pixels above a twentieth of the largest p.
fn hu(own: &[f32], right: &[f32]) -> f64 {
    let floor = 0.05 * right.iter().copied().fold(0.0, f32::max);
    let errors: Vec<f64> = own
        .iter()
        .zip(right)
        .filter(|(_, right)| **right > floor)
        .map(|(own, right)| 1000.0 * f64::from((own - right) / right))
        .collect();
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn a_point_keeps_the_total_and_an_impossible_spot_is_refused() {
    let volume = block();
    // The photons are the same, differently spread: sums agree where the body's shadow is inside the detector.
    let (point, spread) = (intensity(&volume, Effects::default()), intensity(&volume, spot(8.0, 8.0)));
    let [a, b] = [&point, &spread].map(|image| image.iter().sum::<f64>());
    assert!((a / b - 1.0).abs() < 2e-3 && crate::stand::worst_ratio(&spread, &point) > 0.01, "{a} {b}");

    let error = |effects: Effects, pixel_mm: f64| {
        let expected_views = vec![View::Pose(pose(pixel_mm))];
        let scene = Scene { expected_views, ..scene(effects) };
        Projector::new(&context(), volume.clone(), scene).err().map(|error| error.to_string())
    };
    let message = error(spot(10.0, 0.1), 0.01).expect("too large");
    assert!(
        message.starts_with("scene.effects.focal_spot.width_mm is 10") && message.contains("penumbra"),
        "{message}"
    );
    assert_eq!(error(spot(1.0, 0.1), 3.0), None);
    // A matrix does not say where the detector is.
    let matrix = View::Projection(Projection::from_pose(&pose(3.0), SIZE).expect("valid"));
    let projector = projector(&volume, scene(spot(1.0, 1.0)));
    let message = projector.project(&[matrix.into()], SIGNALS, SILENT).expect_err("no detector").to_string();
    assert!(message.contains("focal_spot") && message.contains("matrix"), "{message}");
}
