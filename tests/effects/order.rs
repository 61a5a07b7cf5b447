//! In which order effects meet the image, and what scatter adds.

use std::time::Duration;

use drr::effects::{DetectorBlur, Effects, Filter, FocalSpot, Profile, Scatter};
use drr::engine::{Backend, SILENT};
use drr::physics::Spectrum;
use drr::{Context, Projector, Scene};

use crate::stand::{SIGNALS, block, blurred, image, intensity, nothing, scene, view, worst_ratio};

const SCATTER: Scatter = Scatter { histories: 2000, seed: 0 };

fn scattered(effects: Effects) -> Effects {
    Effects { scatter: Some(SCATTER), ..effects }
}

#[test]
fn scatter_is_added_where_something_scatters() {
    let volume = block();
    let (with, without) =
        (intensity(&volume, scattered(Effects::default())), intensity(&volume, Effects::default()));
    let scatter: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a - b).collect();
    assert!(scatter.iter().all(|s| *s > 0.0));
    // 60 mm of water 270 mm in front of the detector: some percent of the primary, and smoother than it.
    let largest = scatter.iter().zip(&without).map(|(s, p)| s / p).fold(0.0, f64::max);
    assert!(largest > 0.01 && largest < 0.5, "{largest}");
    assert_eq!(
        intensity(&nothing(), scattered(Effects::default())),
        intensity(&nothing(), Effects::default())
    );
}

/// Scatter is there before the detector blurs: what is blurred is the sum.
#[test]
fn scatter_comes_before_the_detector_s_blur() {
    let volume = block();
    let blur = |effects: Effects| Effects {
        detector_blur: Some(DetectorBlur::gaussians(&[(1.0, 24.0)]).expect("valid")),
        ..effects
    };
    let expected = blurred(&intensity(&volume, scattered(Effects::default())), 8.0);
    let both = intensity(&volume, blur(scattered(Effects::default())));
    assert!(worst_ratio(&both, &expected) < 5e-7, "{}", worst_ratio(&both, &expected));
    // The other way round is another image.
    let primary = intensity(&volume, Effects::default());
    let sharp: Vec<f64> =
        intensity(&volume, scattered(Effects::default())).iter().zip(&primary).map(|(a, b)| a - b).collect();
    let other: Vec<f64> = blurred(&primary, 8.0).iter().zip(&sharp).map(|(p, s)| p + s).collect();
    assert!(worst_ratio(&other, &expected) > 1e-4);
}

/// The focal spot blurs what the volume lets pass, and scatter comes of that.
#[test]
fn the_focal_spot_comes_before_blur_and_blur_sees_it() {
    let volume = block();
    let spot =
        Effects { focal_spot: Some(FocalSpot { width_mm: 8.0, height_mm: 8.0 }), ..Effects::default() };
    let blur = Some(DetectorBlur::gaussians(&[(1.0, 9.0)]).expect("valid"));
    let expected = blurred(&intensity(&volume, spot.clone()), 3.0);
    let both = intensity(&volume, Effects { detector_blur: blur, ..spot });
    assert!(worst_ratio(&both, &expected) < 5e-7, "{}", worst_ratio(&both, &expected));
}

/// What scatters is what a filter has let through.
#[test]
fn scatter_behind_a_filter_is_that_of_the_filtered_spectrum() {
    let volume = block();
    let grid = *scene(Effects::default()).spectrum.grid();
    let copper = || Filter::named("copper", grid, Profile::Flat { mm: 2.0 }).expect("built in");
    let share = |effects: Effects, spectrum: &Spectrum| {
        let image = |effects: Effects| -> f64 {
            let scene = Scene { spectrum: spectrum.clone(), ..scene(effects) };
            image(&volume, scene).intensity.iter().map(|&i| f64::from(i)).sum()
        };
        image(scattered(effects.clone())) / image(effects) - 1.0
    };
    let tube = scene(Effects::default()).spectrum;
    let filter = copper();
    let weights = tube.weights().iter().zip(&filter.coefficients);
    let weights = weights.map(|(w, mu)| w * (-0.2 * filter.density * mu).exp()).collect();
    let hardened = Spectrum::new("behind copper", grid, weights).expect("valid");
    let filtered = share(Effects { filters: vec![copper()], ..Effects::default() }, &tube);
    let folded = share(Effects::default(), &hardened);
    assert!((filtered / folded - 1.0).abs() < 0.02, "{filtered} {folded}");
    let soft = share(Effects::default(), &tube);
    assert!((soft / folded - 1.0).abs() > 0.04, "{soft} {folded}");
}

/// Kernels are made while a pool's threads help each other out.
#[test]
fn scatter_can_be_wanted_from_many_threads_of_one_context() {
    let context = Context::new(Backend::Cpu, 4).expect("threads start");
    let volume = block();
    std::thread::scope(|scope| {
        for n in 0..8 {
            let (context, volume) = (&context, &volume);
            scope.spawn(move || {
                std::thread::sleep(Duration::from_millis(30 * n));
                let effects =
                    Effects { scatter: Some(Scatter { histories: 20_000, seed: n }), ..Effects::default() };
                let projector = Projector::new(context, volume.clone(), scene(effects)).expect("valid");
                projector.project(&[view(3.0)], SIGNALS, SILENT).expect("projects");
            });
        }
    });
}

/// Fall-off and scatter: scatter is made of the primary that is there.
#[test]
fn scatter_follows_the_primary() {
    let volume = block();
    let fall_off = Effects { fall_off: true, ..Effects::default() };
    let share = |effects: Effects| {
        let with: f64 = intensity(&volume, scattered(effects.clone())).iter().sum();
        with / intensity(&volume, effects).iter().sum::<f64>()
    };
    let (even, falling) = (share(Effects::default()), share(fall_off));
    assert!((even / falling - 1.0).abs() < 0.01, "{even} {falling}");
}
