//! Superpositions of kernels.

use std::sync::LazyLock;

use super::super::responses::Responses;
use super::super::rings::Rings;
use super::super::transport::{Pencil, Slab};
use super::super::{Beamline, Scatter, ScatterKernels};
use super::scattered;
use crate::effects::Plane;
use crate::physics::{Interactions, Spectrum};

static KERNELS: LazyLock<ScatterKernels> = LazyLock::new(|| {
    let stand = Beamline { source_centre_mm: 1000.0, source_detector_mm: 1500.0 };
    let source = Spectrum::monoenergetic(60.0).unwrap();
    ScatterKernels::new(&Scatter { histories: 4000, seed: 1 }, &source, &[vec![1.0]], stand).unwrap()
});

fn plane(size: [usize; 2], value: impl Fn(usize, usize) -> f64) -> Plane {
    let mut plane = Plane::filled(size, 0.0).unwrap();
    for (k, pixel) in plane.values_mut().iter_mut().enumerate() {
        *pixel = value(k % size[0], k / size[0]);
    }
    plane
}

#[test]
fn a_pencil_gives_what_was_counted_behind_the_slab() {
    // Followed with the same random numbers as the kernel of 20 g/cm², the eighth.
    let (water, rings) = (Interactions::named("water").unwrap(), Rings::up_to(1500.0));
    let source = Spectrum::monoenergetic(60.0).unwrap();
    let responses = Responses::new(*source.grid(), &[vec![1.0]]).unwrap();
    let pencil = Pencil { water: &water, source: &source, responses: &responses, rings: &rings };
    let slab = Slab { thickness_cm: 20.0, gap_cm: 40.0 };
    let counted = pencil.scattered(slab, 4000, 1, 8 << 16).signal;
    let per_ring = counted.len() / rings.count();
    let sums = rings.bounds().zip(counted.chunks(per_ring));
    let within: f64 = sums.filter(|(r, _)| r[1] < 700.0).map(|(_, ring)| ring.iter().sum::<f64>()).sum();
    let expected = within / pencil.primary(slab)[0];
    let (size, pitch) = ([121, 121], 12.0);
    let primary = plane(size, |i, j| if i == 60 && j == 60 { 1.0 / (pitch * pitch) } else { 0.0 });
    let image = scattered(&KERNELS, 0, &primary, &plane(size, |_, _| 20.0), [pitch; 2]).unwrap();
    let radius = rings.bounds().map(|r| r[1]).filter(|r| *r < 700.0).fold(0.0, f64::max);
    let inside = |k: usize| (k % 121).abs_diff(60).pow(2) + (k / 121).abs_diff(60).pow(2);
    let near = image.values().iter().enumerate().filter(|(k, _)| (inside(*k) as f64).sqrt() * pitch < radius);
    let sum = near.map(|(_, signal)| signal).sum::<f64>() * pitch * pitch;
    assert!((sum / expected - 1.0).abs() < 0.03, "{sum} for {expected}");
}

#[test]
fn nothing_scatters_nothing_and_twice_as_much_twice_as_much() {
    let size = [50, 40];
    let primary = plane(size, |i, j| (i + 2 * j) as f64);
    let none = scattered(&KERNELS, 0, &primary, &plane(size, |_, _| 0.0), [4.0; 2]).unwrap();
    assert!(none.values().iter().all(|signal| *signal == 0.0));
    let body = plane(size, |i, _| if i < 25 { 17.0 } else { 0.0 });
    let once = scattered(&KERNELS, 0, &primary, &body, [4.0; 2]).unwrap();
    let twice = plane(size, |i, j| 2.0 * (i + 2 * j) as f64);
    let twice = scattered(&KERNELS, 0, &twice, &body, [4.0; 2]).unwrap();
    for (once, twice) in once.values().iter().zip(twice.values()) {
        assert!(*once > 0.0 && (twice / once - 2.0).abs() < 1e-12);
    }
}

#[test]
fn an_even_slab_gives_an_even_image() {
    let size = [90, 61];
    let image =
        scattered(&KERNELS, 0, &plane(size, |_, _| 0.1), &plane(size, |_, _| 18.0), [3.0; 2]).unwrap();
    let at = |i: usize, j: usize| image.values()[j * 90 + i];
    for (i, j) in [(0, 0), (3, 7), (44, 30), (20, 60)] {
        let mirrored = [at(89 - i, j), at(i, 60 - j), at(89 - i, 60 - j)];
        assert!(mirrored.iter().all(|m| (m / at(i, j) - 1.0).abs() < 1e-9), "{i}, {j}");
    }
    assert!(at(44, 30) > 1.1 * at(0, 30) && at(44, 30) > 1.1 * at(44, 0));
}

#[test]
fn finer_pixels_see_the_same_scatter() {
    let image = |n: usize| {
        let x = move |i: usize| (i as f64 + 0.5) / n as f64;
        let areal = plane([n, n], move |i, j| 30.0 * (x(i) * (1.0 - x(i)) + 0.3 * x(j)));
        let primary = plane([n, n], move |i, j| (-0.2 * 30.0 * (x(i) * (1.0 - x(i)) + 0.3 * x(j))).exp());
        scattered(&KERNELS, 0, &primary, &areal, [300.0 / n as f64; 2]).unwrap()
    };
    let (coarse, fine) = (image(60), image(180));
    for k in 0..3600 {
        let (i, j) = (k % 60, k / 60);
        let block = (0..9).map(|b| fine.values()[(3 * j + b / 3) * 180 + 3 * i + b % 3]).sum::<f64>() / 9.0;
        assert!((block / coarse.values()[k] - 1.0).abs() < 2e-3, "{i}, {j}");
    }
}

#[test]
fn planes_that_do_not_fit_are_refused() {
    let (small, large) = (plane([5, 4], |_, _| 1.0), plane([4, 5], |_, _| 1.0));
    let message = |error: crate::Error| error.to_string();
    assert!(message(scattered(&KERNELS, 0, &small, &large, [1.0; 2]).unwrap_err()).contains("[5, 4]"));
    for pitch in [0.0, f64::NAN] {
        assert!(
            message(scattered(&KERNELS, 0, &small, &small, [1.0, pitch]).unwrap_err()).contains("pitch_mm")
        );
    }
    // A detector of one pixel has one cell.
    let one = plane([1, 1], |_, _| 1.0);
    let image = scattered(&KERNELS, 0, &one, &plane([1, 1], |_, _| 20.0), [300.0; 2]).unwrap();
    assert!(image.values()[0] > 0.2 && image.values()[0] < 3.0, "{image:?}");
}
