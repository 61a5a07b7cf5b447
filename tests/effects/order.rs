//! In which order effects meet the image, and what scatter adds.

use drr::effects::{DetectorBlur, Effects, FocalSpot, Scatter};

use crate::stand::{block, blurred, intensity, nothing, worst_ratio};

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
    assert!(worst_ratio(&both, &expected) < 2e-6, "{}", worst_ratio(&both, &expected));
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
    assert!(worst_ratio(&both, &expected) < 2e-6, "{}", worst_ratio(&both, &expected));
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
