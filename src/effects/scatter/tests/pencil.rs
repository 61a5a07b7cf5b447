//! Pencil beams in slabs against closed forms.

use super::super::responses::Responses;
use super::super::rings::Rings;
use super::super::transport::{Pencil, Slab};
use super::super::{Beamline, Scatter, ScatterKernels};
use crate::physics::{EnergyGrid, Incoherent, Interactions, Spectrum};

const STAND: Beamline = Beamline { source_centre_mm: 1000.0, source_detector_mm: 1500.0 };

/// Part of the directions with a cosine above `least`, by the midpoints of √(1 − cosine).
fn part(density: impl Fn(f64) -> f64, least: f64) -> f64 {
    let step = (1.0 - least).sqrt() / 2000.0;
    let term = |k: i32| {
        let root = (f64::from(k) + 0.5) * step;
        density(1.0 - root * root) * 2.0 * root
    };
    (0..2000).map(term).sum::<f64>() * step * std::f64::consts::TAU
}

#[test]
fn a_thin_slab_scatters_once() {
    let (water, rings) = (Interactions::named("water").unwrap(), Rings::up_to(1000.0));
    let slab = Slab { thickness_cm: 1e-3, gap_cm: 50.0 };
    for kev in [20.0, 60.0, 140.0] {
        let source = Spectrum::monoenergetic(kev).unwrap();
        let responses = Responses::new(*source.grid(), &[vec![2.0]]).unwrap();
        let pencil = Pencil { water: &water, source: &source, responses: &responses, rings: &rings };
        let scattered = pencil.scattered(slab, 200_000, 3, 0);
        let (of, atoms, electrons) = (water.at(kev), water.coherent(kev), Incoherent::new(kev));
        for radius in [50.0, 150.0, 400.0, rings.outermost()] {
            let within: f64 = rings
                .bounds()
                .zip(scattered.signal.chunks(scattered.signal.len() / rings.count()))
                .filter(|([_, outer], _)| *outer <= radius)
                .map(|(_, signal)| signal.iter().sum::<f64>())
                .sum();
            let outer =
                rings.bounds().map(|bound| bound[1]).filter(|outer| *outer <= radius).fold(0.0, f64::max);
            let least = 500.0 / outer.hypot(500.0);
            let expected = of.coherent * part(|cosine| atoms.density(cosine), least)
                + of.incoherent * part(|cosine| electrons.density(cosine), least);
            let ratio = within / (2.0 * 1e-3 * expected);
            // Some 1500 of 200 000 photons come within 50 mm at 140 keV.
            assert!((ratio - 1.0).abs() < 0.005 + 3.0 / radius, "{kev} keV, {radius} mm: {ratio}");
        }
    }
}

#[test]
fn primary_signal_is_attenuated_exponentially() {
    let (water, rings) = (Interactions::named("water").unwrap(), Rings::up_to(10.0));
    let grid = EnergyGrid::new(40.0, 40.0, 2).unwrap();
    let source = Spectrum::new("two", grid, vec![1.0, 3.0]).unwrap();
    let responses = Responses::new(grid, &[vec![5.0, 7.0], vec![0.0, 1.0]]).unwrap();
    let pencil = Pencil { water: &water, source: &source, responses: &responses, rings: &rings };
    let have = pencil.primary(Slab { thickness_cm: 10.0, gap_cm: 1.0 });
    // μ/ρ of water at 40 and 80 keV: 0.2683 and 0.1837 cm²/g (NIST SRD 126).
    let [low, high] = [0.2683_f64, 0.1837].map(|mu| (-10.0 * mu).exp());
    for (have, expected) in have.iter().zip([0.25 * 5.0 * low + 0.75 * 7.0 * high, 0.75 * high]) {
        assert!((have / expected - 1.0).abs() < 1e-3, "{have} for {expected}");
    }
}

#[test]
fn kernels_do_not_depend_on_the_number_of_threads() {
    let source = Spectrum::monoenergetic(60.0).unwrap();
    let made = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let scatter = Scatter { histories: 1000, seed };
        pool.install(|| ScatterKernels::new(&scatter, &source, &[vec![1.0]], STAND).unwrap())
    };
    assert_eq!(made(1, 5), made(3, 5));
    assert_ne!(made(2, 5), made(2, 6));
}

#[test]
fn refusals_name_what_is_wrong() {
    let grid = EnergyGrid::new(10.0, 5.0, 3).unwrap();
    let spectrum = |weights: [f64; 3]| Spectrum::new("own", grid, weights.to_vec()).unwrap();
    let made = |scatter: Scatter, source: &Spectrum, geometry: Beamline| {
        ScatterKernels::new(&scatter, source, &[vec![1.0; 3]], geometry).map(|_| ()).unwrap_err().to_string()
    };
    let (few, low) = (Scatter { histories: 999, seed: 0 }, spectrum([1.0, 1.0, 1.0]));
    assert!(made(few, &low, STAND).contains("scene.effects.scatter.histories is 999"));
    let scatter = Scatter { histories: 1000, seed: 0 };
    assert!(made(scatter, &low, STAND).contains("10 keV; valid: 15 … 150 keV"));
    for mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = made(scatter, &low, Beamline { source_detector_mm: mm, ..STAND });
        assert!(message.contains("scene.effects.scatter.source_detector_mm"), "{message}");
    }
    // Nothing of 15 and 20 keV comes through 50 g/cm²: 1e-17 of it is still scattered somewhere, and is a kernel.
    let soft = spectrum([0.0, 1.0, 1.0]);
    assert!(ScatterKernels::new(&scatter, &soft, &[vec![1.0; 3]], STAND).is_ok());
    assert!(made_blind(&soft).contains("scatter-to-primary ratio"));
}

fn made_blind(source: &Spectrum) -> String {
    let scatter = Scatter { histories: 1000, seed: 0 };
    ScatterKernels::new(&scatter, source, &[vec![0.0; 3]], STAND).map(|_| ()).unwrap_err().to_string()
}
