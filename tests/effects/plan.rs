//! What the planner leaves out of a scene's effects, and what that does to the image.

use drr::effects::{DetectorBlur, Effects, Filter, Heel, Noise, Profile, Scatter};
use drr::engine::SILENT;
use drr::{Projector, Scene, Tolerance};

use crate::stand::{SIGNALS, block, context, scene, view};

fn planned(effects: Effects, hu: f64) -> Projector {
    let scene = Scene { tolerance: Some(Tolerance::hu(hu)), ..scene(effects) };
    Projector::new(&context(), block(), scene).expect("planned")
}

fn left_out(projector: &Projector) -> Vec<&'static str> {
    projector.plan().left_out.iter().map(|left| left.name).collect()
}

/// Each effect so small that it cannot be seen, and so large that it can.
#[test]
fn what_changes_too_little_is_left_out_and_the_plan_says_so() {
    let grid = *Scene::new([1, 1]).expect("valid").spectrum.grid();
    let blur = |sigma: f64| Effects {
        detector_blur: Some(DetectorBlur::gaussians(&[(1.0, sigma)]).expect("valid")),
        ..Effects::default()
    };
    let filter = |mm: f64| Effects {
        filters: vec![Filter::named("air", grid, Profile::Flat { mm }).expect("built in")],
        ..Effects::default()
    };
    let heel =
        |depth_mm: f64| Effects { heel: Some(Heel { depth_mm, ..Heel::TYPICAL }), ..Effects::default() };
    for (name, small, large) in [
        ("detector blur", blur(0.03), blur(1.2)),
        ("filters", filter(0.01), filter(900.0)),
        ("heel effect", heel(1e-9), heel(5e-3)),
    ] {
        let (small, large) = (planned(small, 2.0), planned(large, 2.0));
        assert_eq!(left_out(&small), [name]);
        assert_eq!(left_out(&large), [""; 0], "{name}");
        let left = &small.plan().left_out[0];
        assert!(left.hu <= left.allowed_hu && left.allowed_hu < 2.0, "{left:?}");
        assert!(small.plan().to_string().contains(&format!("skip  {name}")), "{}", small.plan());
    }
    // Of the intensity fall-off takes 2 % here, which is no small thing; nor are scatter and noise.
    let others = Effects {
        fall_off: true,
        scatter: Some(Scatter { histories: 1000, seed: 0 }),
        noise: Some(Noise { photons_per_pixel: 1e9, quantum: true, electronic_photons: 0.0, seed: 0 }),
        ..Effects::default()
    };
    assert_eq!(left_out(&planned(others, 2.0)), [""; 0]);
}

/// Left out means not there: the image is bit for bit the one of a scene that never asked.
#[test]
fn what_is_left_out_does_not_run() {
    let small = Effects {
        detector_blur: Some(DetectorBlur::gaussians(&[(1.0, 0.01)]).expect("valid")),
        ..Effects::default()
    };
    let with = planned(small, 5.0);
    assert_eq!(left_out(&with), ["detector blur"]);
    let (images, stages) = with.project_timed(&[view(3.0)], SIGNALS, SILENT).expect("projects");
    assert!(stages.seconds().is_empty());
    let method = with.plan().method;
    let plain =
        Projector::new(&context(), block(), Scene { method, ..scene(Effects::default()) }).expect("valid");
    assert_eq!(images, plain.project(&[view(3.0)], SIGNALS, SILENT).expect("projects"));
}

/// A body so small that what it scatters is lost.
#[test]
fn scatter_of_next_to_nothing_is_left_out() {
    let speck = crate::stand::volume([40, 30, 36], |at| if at.length() < 3.0 { 0 } else { -1000 });
    let effects = Effects { scatter: Some(Scatter { histories: 1000, seed: 0 }), ..Effects::default() };
    let scene = Scene { tolerance: Some(Tolerance::hu(200.0)), ..scene(effects) };
    let projector = Projector::new(&context(), speck, scene).expect("planned");
    assert_eq!(left_out(&projector), ["scatter"], "{}", projector.plan());
}
