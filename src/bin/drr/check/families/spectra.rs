//! Opaque paths, spectra without a signal, spectra at their limits.

use std::sync::Arc;

use drr::physics::{EnergyGrid, MassAttenuation, Spectrum};
use drr::volume::Volume;
use drr::{Projector, Scene};
use glam::DVec3;

use crate::check::case::{Case, Demand, Set};
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

/// exp(−τ) leaves float32 at τ = 87 and float64 at 745; p goes on.
fn opaque() -> Vec<Case> {
    let mut cases = Vec::new();
    for (material, mm) in
        [("bone_cortical", 300), ("titanium", 500), ("steel_316l", 800), ("tungsten", 1000), ("gd2o2s", 2000)]
    {
        for length in [mm / 10, mm] {
            let name = format!("{length} mm of {material} at 1 g/cm3");
            cases.push(Case { family: 17, name, demand: Demand::Exact(through(material, length, tube())) });
        }
    }
    let line = Spectrum::monoenergetic(20.0).expect("valid");
    let demand = Demand::Exact(through("tungsten", 2000, line));
    cases.push(Case { family: 17, name: "2000 mm of tungsten at 20 keV".into(), demand });
    cases
}

fn without_signal() -> Vec<Case> {
    let refused = |name: &str, argument: &'static str, weight: fn(usize) -> f64| {
        let attempt = move |_: &_| {
            let weights = (0..GRID.count()).map(weight).collect();
            Spectrum::new("of a case", GRID, weights).map(|_| ())
        };
        Case { family: 18, name: name.into(), demand: Demand::Refused(argument, Box::new(attempt)) }
    };
    vec![
        refused("refused: a spectrum of zeros", "spectrum", |_| 0.0),
        refused("refused: a negative weight", "spectrum[7]", |k| if k == 7 { -1.0 } else { 1.0 }),
        refused("refused: NaN as a weight", "spectrum[8]", |k| if k == 8 { f64::NAN } else { 1.0 }),
        refused("refused: an infinite weight", "spectrum[9]", |k| if k == 9 { f64::INFINITY } else { 1.0 }),
        Case {
            family: 18,
            name: "refused: I0 beyond float32".into(),
            demand: Demand::Refused(
                "scene.spectrum's sum",
                Box::new(|context| {
                    let scene = Scene { spectrum: spectrum(|_| 1e38), ..Scene::new([1, 1])? };
                    Projector::new(context, rod(4).0, scene).map(|_| ())
                }),
            ),
        },
    ]
}

fn limits() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |name: &str, length: usize, spectrum: Spectrum| {
        let demand = Demand::Exact(through("titanium", length, spectrum));
        cases.push(Case { family: 26, name: name.into(), demand });
    };
    add("a single line", 80, spectrum(|e| f64::from(u8::from(e == 60.0))));
    add("all weight in the last bin", 80, spectrum(|e| f64::from(u8::from(e == 150.0))));
    add("all weight in the first bin", 80, spectrum(|e| f64::from(u8::from(e == 15.0))));
    add("weights of 1e-30", 80, spectrum(|_| 1e-30));
    add("weights of 1e30", 80, spectrum(|_| 1e30));
    for faint in [1e-3, 1e-6, 1e-20, 1e-38, 1e-42, 1e-60] {
        // What is left of a thick path is the faint line alone.
        let name = format!("150 keV at {faint:.0e} of 20 keV");
        add(
            &name,
            300,
            spectrum(|e| {
                if e == 20.0 {
                    1.0
                } else if e == 150.0 {
                    faint
                } else {
                    0.0
                }
            }),
        );
    }
    let powers = |by: f64| through("titanium", 80, spectrum(|e| by * e));
    for exponent in [-60, 60] {
        // p does not know the unit of the spectrum.
        let pair = [powers(1.0), powers(2_f64.powi(exponent))].map(|mut set| {
            set.layers.intensity = false;
            set
        });
        let name = format!("p of a spectrum scaled by 2^{exponent}");
        cases.push(Case { family: 26, name, demand: Demand::Same(Box::new(pair)) });
    }
    cases
}
