//! Layers, blur and pixels of the detector.

use drr::Scene;
use drr::effects::{DetectorBlur, Effects, FillFactor};

use crate::stand::{SIDE, block, blurred, image, intensity, response, scene, worst_ratio};

#[test]
fn both_layers_are_what_each_is_alone() {
    let volume = block();
    let layers = ["top_energy", "bottom_energy"].map(response);
    let both = image(&volume, Scene { detector_layers: layers.to_vec(), ..scene(Effects::default()) });
    assert_eq!((both.detector_layers, both.intensity.len()), (2, 2 * SIDE * SIDE));
    for (n, layer) in layers.into_iter().enumerate() {
        let alone = image(&volume, Scene { detector_layers: vec![layer], ..scene(Effects::default()) });
        let [own, other] = [both.of_detector_layer(&both.line_integral, 0, n), &alone.line_integral[..]];
        for (a, b) in own.iter().zip(other) {
            assert!((a - b).abs() <= 3e-7 * b + 1e-7, "{a} {b}");
        }
        let [own, other] = [both.of_detector_layer(&both.intensity, 0, n), &alone.intensity[..]];
        assert!(own.iter().zip(other).all(|(a, b)| (a / b - 1.0).abs() < 3e-7));
    }
    // The bottom layer sees what the top one and the mask let through: harder radiation.
    let [top, bottom] = [0, 1].map(|n| both.of_detector_layer(&both.line_integral, 0, n).to_vec());
    let behind = top.iter().zip(&bottom).filter(|(p, _)| **p > 0.5);
    assert!(behind.clone().count() > 100 && behind.into_iter().all(|(top, bottom)| bottom < top));
}

#[test]
fn blur_is_the_convolution_that_the_mtf_says() {
    let volume = block();
    let blur = DetectorBlur::gaussians(&[(0.7, 6.0), (0.3, 15.0)]).expect("valid");
    let plain = intensity(&volume, Effects::default());
    let with = intensity(&volume, Effects { detector_blur: Some(blur), ..Effects::default() });
    // Pixels of 3 mm.
    let (narrow, wide) = (blurred(&plain, 2.0), blurred(&plain, 5.0));
    let expected: Vec<f64> = narrow.iter().zip(&wide).map(|(a, b)| 0.7 * a + 0.3 * b).collect();
    assert!(worst_ratio(&with, &expected) < 5e-7, "{}", worst_ratio(&with, &expected));
    assert!(worst_ratio(&with, &plain) > 0.1);
}

#[test]
fn an_active_area_sees_its_part_of_the_photons() {
    let volume = block();
    let with = |fill: f64, supersampling: usize| {
        let fill_factor = Some(FillFactor::new(fill).expect("valid"));
        let effects = Effects { fill_factor, ..Effects::default() };
        image(&volume, Scene { supersampling, ..scene(effects) })
    };
    let whole = |supersampling: usize| image(&volume, Scene { supersampling, ..scene(Effects::default()) });
    let wide = |image: &[f32]| image.iter().map(|&x| f64::from(x)).collect::<Vec<_>>();
    // One ray stands for the whole pixel.
    let halved: Vec<f64> = wide(&whole(1).intensity).iter().map(|x| 0.5 * x).collect();
    assert!(worst_ratio(&wide(&with(0.5, 1).intensity), &halved) < 3e-7);
    // All of the area is what supersampling is without a fill factor.
    assert!(worst_ratio(&wide(&with(1.0, 3).intensity), &wide(&whole(3).intensity)) < 5e-7);
    // A ninth of the area: the middle one of nine rays.
    let ninth: Vec<f64> = wide(&whole(1).intensity).iter().map(|x| x / 9.0).collect();
    assert!(worst_ratio(&wide(&with(1.0 / 9.0, 3).intensity), &ninth) < 5e-7);
    // The open field has the same active area.
    let corner = with(0.5, 1).line_integral[0];
    assert!(corner.abs() < 3e-7, "{corner}");
}
