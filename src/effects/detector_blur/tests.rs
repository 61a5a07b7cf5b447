use std::f64::consts::PI;

use super::*;

const PITCH: [f64; 2] = [0.2, 0.25];

/// A scintillator of two parts, some light that goes straight, and glare.
fn detector() -> DetectorBlur {
    DetectorBlur::gaussians(&[(0.1, 0.0), (0.5, 0.13), (0.3, 0.4), (0.1, 1.5)]).expect("valid")
}

/// A line of samples along a column (axis 0: the next samples are other columns) as the detector shows it.
fn line_spread(blur: &DetectorBlur, axis: usize) -> Vec<f64> {
    let size = [[201, 3], [3, 201]][axis];
    let line = Plane::of_points(size, |i, j| f64::from(u8::from([i, j][axis] == 100)));
    let seen = blur.applied(&line, PITCH).expect("memory");
    (0..201).map(|n| if axis == 0 { seen.row(1)[n] } else { seen.row(n)[1] }).collect()
}

#[test]
fn the_mtf_of_a_line_is_the_one_stated() {
    let blur = detector();
    let bound = blur.worst_response_error(PITCH).expect("memory");
    let mut worst = 0.0_f64;
    for (axis, pitch) in PITCH.into_iter().enumerate() {
        let spread = line_spread(&blur, axis);
        for f in (0..=128).map(|k| f64::from(k) / 256.0) {
            let wave = |(n, value): (usize, &f64)| value * (2.0 * PI * f * (n as f64 - 100.0)).cos();
            let seen: f64 = spread.iter().enumerate().map(wave).sum();
            worst = worst.max((seen - blur.mtf(f / pitch)).abs());
        }
    }
    assert!((worst / bound - 1.0).abs() < 1e-6, "{worst} of {bound}");
    // The narrow Gaussian of half the weight has 0.65 and 0.52 samples.
    assert!(bound < 0.12, "{bound}");
    let wide = DetectorBlur::gaussians(&[(0.6, 0.5), (0.4, 2.0)]).expect("valid");
    assert!(wide.worst_response_error(PITCH).expect("memory") < 2e-7);
}

#[test]
fn a_point_gets_the_variance_of_the_mixture() {
    let blur = detector();
    let square = |part: &BlurComponent| part.weight * part.sigma_mm * part.sigma_mm;
    let exact: f64 = blur.components().iter().map(square).sum();
    for (axis, pitch) in PITCH.into_iter().enumerate() {
        let spread = line_spread(&blur, axis);
        let square = |(n, value): (usize, &f64)| value * ((n as f64 - 100.0) * pitch).powi(2);
        let variance: f64 = spread.iter().enumerate().map(square).sum();
        assert!((variance / exact - 1.0).abs() < 1e-5, "{variance} for {exact}");
    }
}

#[test]
fn the_mean_of_an_image_without_edges_stays() {
    let blur = detector();
    let flat = Plane::filled([50, 20], 0.7).expect("memory");
    assert_eq!(blur.applied(&flat, PITCH), Ok(flat));
    assert!((line_spread(&blur, 0).iter().sum::<f64>() - 1.0).abs() < 1e-13);
}

#[test]
fn a_mixture_is_found_again_from_its_mtf() {
    let blur = detector();
    let frequencies: Vec<f64> = (0..60).map(|k| 0.07 * f64::from(k)).collect();
    let mtf: Vec<f64> = frequencies.iter().map(|f| blur.mtf(*f)).collect();
    let (found, error) = DetectorBlur::curve(&frequencies, &mtf).expect("valid");
    assert!(error < 1e-3, "{error}");
    let between = (0..413).map(|k| 0.01 * f64::from(k));
    let worst = between.map(|f| (found.mtf(f) - blur.mtf(f)).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-3, "{worst}");
    assert!(found.components().len() <= MAX_BLUR_COMPONENTS);
}

#[test]
fn a_lorentzian_mtf_is_nearly_a_mixture() {
    let frequencies: Vec<f64> = (1..=20).map(|k| 0.25 * f64::from(k)).collect();
    let mtf: Vec<f64> = frequencies.iter().map(|f| 1.0 / (1.0 + (f / 1.3).powi(2))).collect();
    let (found, error) = DetectorBlur::curve(&frequencies, &mtf).expect("valid");
    let worst = frequencies.iter().zip(&mtf).map(|(f, value)| (found.mtf(*f) - value).abs());
    assert_eq!(error, worst.fold(0.0, f64::max));
    assert!(error < 2e-4, "{error}");
    assert!(found.validate().is_ok() && (found.mtf(0.0) - 1.0).abs() < 1e-15);
}

#[test]
fn what_no_mixture_is_like_is_said_to_be_far() {
    // A pixel's aperture: it reaches 0, and then rises.
    let frequencies: Vec<f64> = (0..40).map(|k| 0.05 * f64::from(k)).collect();
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { ((PI * x).sin() / (PI * x)).abs() };
    let mtf: Vec<f64> = frequencies.iter().map(|f| sinc(*f)).collect();
    let (_, error) = DetectorBlur::curve(&frequencies, &mtf).expect("valid");
    assert!((0.05..0.2).contains(&error), "{error}");
    // Not blurred at all.
    let (sharp, error) = DetectorBlur::curve(&[1.0, 2.0], &[1.0, 1.0]).expect("valid");
    assert!(error < 1e-12 && sharp.largest_sigma_mm() < 1e-3, "{sharp:?}");
    // Nothing left: as wide as they come.
    let (_, error) = DetectorBlur::curve(&[1.0, 2.0], &[0.0, 0.0]).expect("valid");
    assert!(error < 1e-6, "{error}");
}

#[test]
fn what_is_no_point_spread_is_refused() {
    let named = |parts: &[(f64, f64)]| DetectorBlur::gaussians(parts).expect_err("invalid").to_string();
    for (parts, name) in [
        (vec![(0.5, 0.1), (0.4, 0.2)], "detector_blur: sum of the weights"),
        (vec![(f64::NAN, 0.1)], "detector_blur[0].weight"),
        (vec![(0.0, 0.1), (1.0, 0.2)], "detector_blur[0].weight"),
        (vec![(-0.5, 0.1), (1.5, 0.2)], "detector_blur[0].weight"),
        (vec![(0.5, 0.1), (0.5, f64::NAN)], "detector_blur[1].sigma_mm"),
        (vec![(1.0, -0.1)], "detector_blur[0].sigma_mm"),
        (vec![(1.0, 100.1)], "detector_blur[0].sigma_mm"),
        (vec![], "number of Gaussians"),
        (vec![(0.1, 1.0); 10], "number of Gaussians"),
    ] {
        assert!(named(&parts).contains(name), "{}", named(&parts));
    }
    let sum: f64 = DetectorBlur::gaussians(&[(0.5, 0.1), (0.5 + 9e-7, 0.2)])
        .expect("near enough")
        .components()
        .iter()
        .map(|part| part.weight)
        .sum();
    assert!((sum - 1.0).abs() < 1e-15);
}

#[test]
fn what_is_no_mtf_is_refused() {
    let named = |f: &[f64], mtf: &[f64]| DetectorBlur::curve(f, mtf).expect_err("invalid").to_string();
    let many: Vec<f64> = (0..257).map(f64::from).collect();
    for (f, mtf, name) in [
        (vec![1.0, 0.5], vec![0.8, 0.6], "detector_blur.frequencies_per_mm[1]"),
        (vec![1.0, 1.0], vec![0.8, 0.6], "detector_blur.frequencies_per_mm[1]"),
        (vec![-1.0, 1.0], vec![0.8, 0.6], "detector_blur.frequencies_per_mm[0]"),
        (vec![1.0, f64::INFINITY], vec![0.8, 0.6], "detector_blur.frequencies_per_mm[1]"),
        (vec![f64::NAN, 1.0], vec![0.8, 0.6], "detector_blur.frequencies_per_mm[0]"),
        (vec![1.0, 2.0], vec![1.01, 0.6], "detector_blur.mtf[0]"),
        (vec![1.0, 2.0], vec![0.9, f64::NAN], "detector_blur.mtf[1]"),
        (vec![1.0, 2.0], vec![0.9, -0.1], "detector_blur.mtf[1]"),
        (vec![0.0, 2.0], vec![0.9, 0.1], "detector_blur.mtf[0]"),
        (vec![1.0, 2.0], vec![0.9], "number of values"),
        (vec![1.0], vec![0.9], "number of points"),
        (many.clone(), vec![0.5; 257], "number of points"),
    ] {
        assert!(named(&f, &mtf).contains(name), "{}", named(&f, &mtf));
    }
}
