//! Opaque paths, spectra without a signal, spectra at their limits.

use std::sync::Arc;

use drr::physics::{EnergyGrid, MassAttenuation, Spectrum};
use drr::volume::Volume;
use drr::{Projector, Scene};
use glam::DVec3;

use crate::check::case::{Case, Set};
use crate::check::volumes::{uniform, unit_grid};

const GRID: EnergyGrid = EnergyGrid::SPECIFICATION;

pub(super) fn cases() -> Vec<Case> {
    [opaque(), without_signal(), limits()].into_iter().flatten().collect()
}

/// A rod of `length` mm of one material, seen from its end, a little inclined.
fn rod(length: usize) -> (Arc<Volume>, DVec3, DVec3) {
    let volume = uniform(unit_grid([4, length, 4]), 0);
    (volume, DVec3::new(1.2, -30.0, 1.4), DVec3::new(1.9, length as f64 + 40.0, 1.7))
}

/// A rod of 1 g/cm³ of a material; thickness stands for density.
pub(super) fn through(material: &str, length: usize, spectrum: Spectrum) -> Set {
    let (volume, from, to) = rod(length);
    Set::ray(volume, from, to).with_scene(|scene| {
        scene.materials = MassAttenuation::named(&[material], *spectrum.grid()).expect("built in");
        scene.spectrum = spectrum;
        scene.bone = Some(0);
    })
}

pub(super) fn tube() -> Spectrum {
    Spectrum::named(Spectrum::DEFAULT, GRID).expect("built in")
}

/// Weights on the built-in energies.
pub(super) fn spectrum(weight: impl Fn(f64) -> f64) -> Spectrum {
    Spectrum::new("of a case", GRID, GRID.energies().map(weight).collect()).expect("valid")
}

/// 1 at 20 keV and `faint` at 150 keV.
pub(super) fn two_lines(faint: f64) -> Spectrum {
    spectrum(|e| {
        if e == 20.0 {
            1.0
        } else if e == 150.0 {
            faint
        } else {
            0.0
        }
    })
}

/// exp(−τ) is 0 in float32 from τ = 104 on, in float64 from 746; p goes on.
fn opaque() -> Vec<Case> {
    let mut cases = Vec::new();
    for (material, mm) in
        [("bone_cortical", 300), ("titanium", 500), ("steel_316l", 800), ("tungsten", 1000), ("gd2o2s", 2000)]
    {
        for length in [mm / 10, mm] {
            let name = format!("{length} mm of {material} at 1 g/cm3");
            cases.push(Case::exact(17, name, through(material, length, tube())));
        }
    }
    let line = Spectrum::monoenergetic(20.0).expect("valid");
    cases.push(Case::exact(17, "2000 mm of tungsten at 20 keV", through("tungsten", 2000, line)));
    cases
}

fn without_signal() -> Vec<Case> {
    let refused = |name: &str, argument: &'static str, weight: fn(usize) -> f64| {
        let weights: Vec<_> = (0..GRID.count()).map(weight).collect();
        Case::refused(18, name, argument, move |_| Spectrum::new("of a case", GRID, weights.clone()))
    };
    vec![
        refused("a spectrum of zeros", "spectrum", |_| 0.0),
        refused("a negative weight", "spectrum[7]", |k| if k == 7 { -1.0 } else { 1.0 }),
        refused("NaN as a weight", "spectrum[8]", |k| if k == 8 { f64::NAN } else { 1.0 }),
        refused("an infinite weight", "spectrum[9]", |k| if k == 9 { f64::INFINITY } else { 1.0 }),
        Case::refused(18, "I0 beyond float32", "scene.spectrum's sum", |context| {
            let scene = Scene { spectrum: spectrum(|_| 1e38), ..Scene::new([1, 1])? };
            Projector::new(context, rod(4).0, scene)
        }),
    ]
}

fn limits() -> Vec<Case> {
    let lit = |spectrum| through("titanium", 80, spectrum);
    let line = |energy| spectrum(move |e| f64::from(u8::from(e == energy)));
    let mut cases = vec![
        Case::exact(26, "a single line", lit(line(60.0))),
        Case::exact(26, "all weight in the last bin", lit(line(150.0))),
        Case::exact(26, "all weight in the first bin", lit(line(15.0))),
        Case::exact(26, "weights of 1e-30", lit(spectrum(|_| 1e-30))),
        Case::exact(26, "weights of 1e30", lit(spectrum(|_| 1e30))),
    ];
    for faint in [1e-3, 1e-6, 1e-20, 1e-38, 1e-42, 1e-60] {
        // What is left of a thick path is the faint line alone.
        let set = through("titanium", 300, two_lines(faint));
        cases.push(Case::exact(26, format!("150 keV at {faint:.0e} of 20 keV"), set));
    }
    // Rounding each of thousands of equal terms the same way would show.
    let equal = EnergyGrid::new(1.0, 0.01, 3971).expect("valid");
    let flat = Spectrum::new("flat", equal, vec![1.0; equal.count()]).expect("valid");
    for (mu, name) in
        [(1e-3, "3971 equal energies"), (1e-6, "3971 equal energies, next to nothing in the way")]
    {
        let (volume, from, to) = rod(8);
        let set = Set::ray(volume, from, to).with_scene(|scene| {
            let names = vec!["of a case".to_owned()];
            scene.materials = MassAttenuation::new(equal, names, vec![mu; equal.count()]).expect("valid");
            scene.spectrum = flat.clone();
            scene.bone = Some(0);
        });
        cases.push(Case::exact(26, name, set));
    }
    let powers = |by: f64| lit(spectrum(|e| by * e));
    for exponent in [-60, 60] {
        // p does not know the unit of the spectrum.
        let pair = [powers(1.0), powers(2_f64.powi(exponent))].map(|mut set| {
            set.layers.intensity = false;
            set
        });
        let name = format!("p of a spectrum scaled by 2^{exponent}");
        cases.push(Case::same(26, name, pair));
    }
    cases
}
