//! Scenes with effects: several detector layers, uneven sources, focal spots, noise. Engines that sum over energies themselves
//! are held to float64 as are those that leave it to the host.

use std::sync::Arc;

use drr::effects::{Effects, Filter, FocalSpot, Heel, Implant, ImplantShape, Noise, Profile, Scatter};
use drr::engine::{Backend, Images, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid};
use drr::physics::DetectorResponse;
use drr::volume::Volume;
use drr::{Algorithm, Scene, ViewRequest};
use glam::DVec3;

use crate::Test;
use crate::support::{
    awkward_grid, classification, max_relative, poses, projector, relative_l2, requests, volume,
};
use crate::twin::{kinds, worse};

pub(super) const TESTS: [Test; 9] = [
    ("with_two_detector_layers", with_two_detector_layers),
    ("with_an_uneven_source", with_an_uneven_source),
    ("with_a_focal_spot", with_a_focal_spot),
    ("with_effects_and_several_rays_per_pixel", with_effects_and_several_rays_per_pixel),
    ("with_scatter_and_every_layer", with_scatter_and_every_layer),
    ("with_signals_that_float32_does_not_hold", with_signals_that_float32_does_not_hold),
    ("with_more_filters_than_kernels_take", with_more_filters_than_kernels_take),
    ("with_an_implant", with_an_implant),
    ("with_noise", with_noise),
];

const SIZE: [usize; 2] = [40, 28];

/// Of a line integral p, relative and absolute, as without effects.
const LINE_INTEGRAL: [f64; 2] = [2e-6, 1e-6];

const SIGNALS: Layers =
    Layers { intensity: true, line_integral: true, areal_density: false, bone_path: false };

fn scene(detector_layers: &[&str], effects: Effects) -> Scene {
    let scene = Scene::new(SIZE).expect("valid");
    let response = |name: &&str| DetectorResponse::named(name, *scene.spectrum.grid()).expect("built in");
    Scene { detector_layers: detector_layers.iter().map(response).collect(), effects, ..scene }
}

/// Both layers of a detector that integrates energies.
const BOTH: [&str; 2] = ["top_energy", "bottom_energy"];

fn sheet(material: &str, mm: f64) -> Filter {
    let grid = *Scene::new(SIZE).expect("valid").spectrum.grid();
    Filter::named(material, grid, Profile::Flat { mm }).expect("built in")
}

/// Fall-off, anode, a sheet and a bow-tie.
fn uneven() -> Effects {
    let wedge = Profile::BowTie { degrees: vec![-4.0, 0.0, 4.0], mm: vec![30.0, 2.0, 25.0] };
    let bow_tie = Filter { profile: wedge, ..sheet("aluminium", 1.0) };
    let filters = vec![sheet("copper", 0.1), bow_tie];
    Effects { fall_off: true, heel: Some(Heel::TYPICAL), filters, ..Effects::default() }
}

/// Views from the front, obliquely and from inside.
fn views(grid: &Grid) -> Vec<ViewRequest> {
    let all = poses(grid, SIZE);
    requests([0, 4, 6].map(|n| all[n].1))
}

fn images(
    backend: Backend,
    volume: &Arc<Volume>,
    scene: &Scene,
    views: &[ViewRequest],
    layers: Layers,
) -> (Images<f32>, Images<f64>) {
    let algorithm = scene.method.algorithm;
    let projector = projector(backend, volume, scene.clone());
    let fast = projector.project(views, layers, SILENT).expect("projects");
    let truth = projector.reference(algorithm, views, layers, SILENT).expect("projects");
    assert_eq!(fast.detector_layers, scene.layers());
    assert!(truth.line_integral.iter().any(|&p| p > 0.1), "sees nothing");
    (fast, truth)
}

/// Holds the images of a scene to their twin's, of every algorithm.
fn conforms(backend: Backend, name: &str, volume: &Arc<Volume>, scene: &Scene, views: &[ViewRequest]) {
    for &algorithm in kinds(backend) {
        let scene = Scene { method: algorithm.into(), ..scene.clone() };
        let (fast, truth) = images(backend, volume, &scene, views, SIGNALS);
        holds(&format!("{algorithm:?}, {name}"), &fast, &truth);
    }
}

fn holds(name: &str, fast: &Images<f32>, truth: &Images<f64>) {
    let [relative, absolute] = LINE_INTEGRAL;
    let pairs = fast.line_integral.iter().zip(&truth.line_integral);
    // Two infinities are alike.
    let of_bound = pairs.map(|(&p, &exact)| match f64::from(p) {
        p if p == exact => 0.0,
        p => (p - exact).abs() / (relative * exact.abs() + absolute),
    });
    let most = of_bound.fold(0.0, worse);
    println!("    {name}: {most:.3} of the bound");
    assert!(most <= 1.0, "{name}: {most} of the bound");
    let l2 = relative_l2(&fast.intensity, &truth.intensity);
    assert!(l2 <= 2e-6, "{name}: intensity {l2:.2e}");
}

fn with_two_detector_layers(backend: Backend) {
    let grid = awkward_grid([70, 61, 53]);
    for layers in [["top_counting", "bottom_counting"], BOTH] {
        let scene = scene(&layers, Effects::default());
        conforms(backend, layers[0], &volume(grid), &scene, &views(&grid));
    }
}

/// Each part of the source alone, which kernels know as other definitions, and all together.
fn with_an_uneven_source(backend: Backend) {
    let grid = awkward_grid([40, 45, 38]);
    let all = uneven();
    let parts = [
        Effects { fall_off: true, ..Effects::default() },
        Effects { heel: all.heel, ..Effects::default() },
        Effects { filters: all.filters.clone(), ..Effects::default() },
        all,
    ];
    for (n, effects) in parts.into_iter().enumerate() {
        for layers in [&[][..], &BOTH] {
            let name = format!("part {n} of the source, {} layers", layers.len());
            conforms(backend, &name, &volume(grid), &scene(layers, effects.clone()), &views(&grid));
        }
    }
}

/// Of some points, whose signals are averaged.
fn with_a_focal_spot(backend: Backend) {
    let grid = awkward_grid([40, 45, 38]);
    let focal_spot = Some(FocalSpot { width_mm: 3.0, height_mm: 2.0 });
    for effects in [Effects { focal_spot, ..Effects::default() }, Effects { focal_spot, ..uneven() }] {
        // All of the volume is in front of the source.
        conforms(backend, "a focal spot", &volume(grid), &scene(&BOTH, effects), &views(&grid)[..2]);
    }
}

fn with_effects_and_several_rays_per_pixel(backend: Backend) {
    let grid = awkward_grid([40, 45, 38]);
    let scene = Scene { supersampling: 2, ..scene(&BOTH, uneven()) };
    conforms(backend, "2 rays a side", &volume(grid), &scene, &views(&grid));
}

/// What is asked for beside the signals, and what scatter needs of the rays.
fn with_scatter_and_every_layer(backend: Backend) {
    let grid = awkward_grid([40, 45, 38]);
    let scatter = Some(Scatter { histories: 1000, seed: 1 });
    let scene = scene(&BOTH, Effects { scatter, fall_off: true, ..Effects::default() });
    let (fast, truth) = images(backend, &volume(grid), &scene, &views(&grid)[..2], Layers::ALL);
    holds("scatter", &fast, &truth);
    let largest = truth.areal_density.iter().copied().fold(0.0, f64::max);
    let areal_density = max_relative(&fast.areal_density, &truth.areal_density, 0.05 * largest);
    assert!(areal_density <= 1e-5, "{areal_density:.2e}");
    assert!(relative_l2(&fast.bone_path, &truth.bone_path) <= 2e-6);
    // Without the layers the signals are the same.
    let alone = projector(backend, &volume(grid), scene).project(&views(&grid)[..2], SIGNALS, SILENT);
    let alone = alone.expect("projects");
    assert!(alone.intensity == fast.intensity && alone.line_integral == fast.line_integral);
}

/// Behind metres of matter, where e⁻¹⁵⁰ is left, and where the anode hides the detector, nothing.
fn with_signals_that_float32_does_not_hold(backend: Backend) {
    let grid = Grid::centred([40, 400, 30], DVec3::new(25.0, 10.0, 25.0)).expect("valid");
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| 3000 - (i % 40) as i16 * 60).collect();
    let volume = Arc::new(Volume::from_int16(grid, &hu, None, &classification()).expect("valid"));
    let far = DetectorPose::c_arm(DVec3::ZERO, 2.0, 9000.0, 12000.0, 1500.0 / SIZE[0] as f64, SIZE);
    let wide = DetectorPose::c_arm(DVec3::ZERO, 0.0, 2100.0, 4200.0, 60.0, SIZE);
    let views = requests([far, wide]);
    let scene = scene(&BOTH, uneven());
    let (fast, truth) = images(backend, &volume, &scene, &views, SIGNALS);
    let finite = truth.line_integral.iter().copied().filter(|p| p.is_finite());
    let (rays, most) = (finite.clone().count(), finite.fold(0.0, f64::max));
    assert!(rays < truth.line_integral.len() && most > 110.0, "{rays} finite, the largest {most}");
    holds("metres of matter", &fast, &truth);
}

/// Which the host sums instead.
fn with_more_filters_than_kernels_take(backend: Backend) {
    let grid = awkward_grid([40, 45, 38]);
    for count in [8, 9] {
        let filters = vec![sheet("aluminium", 0.2); count];
        let scene = scene(&[], Effects { filters, ..Effects::default() });
        let (fast, truth) = images(backend, &volume(grid), &scene, &views(&grid)[..1], SIGNALS);
        holds(&format!("{count} filters"), &fast, &truth);
    }
}

/// Which changes areal densities after the march.
fn with_an_implant(backend: Backend) {
    let grid = awkward_grid([40, 45, 38]);
    let shape = ImplantShape::Sphere { centre: grid.centre(), radius: 9.0 };
    let implants = vec![Implant { shape, material: 3, density: 4.5 }];
    let scene = scene(&BOTH, Effects { implants, ..uneven() });
    let (fast, truth) = images(backend, &volume(grid), &scene, &views(&grid)[..1], SIGNALS);
    holds("an implant", &fast, &truth);
}

/// The same seed gives the same noise: where rounding moves a signal across the edge of a Poisson number's cell, one photon is
/// counted more or less.
fn with_noise(backend: Backend) {
    let grid = awkward_grid([40, 45, 38]);
    let photons_per_pixel = 2000.0;
    let noise = Some(Noise { photons_per_pixel, quantum: true, electronic_photons: 0.0, seed: 7 });
    let scene = Scene {
        method: Algorithm::Joseph.into(),
        ..scene(&BOTH, Effects { noise, fall_off: true, ..Effects::default() })
    };
    let (fast, truth) = images(backend, &volume(grid), &scene, &views(&grid), SIGNALS);
    // The most that a photon may add: all of its energy, keV.
    let photon = 150.0 * scene.spectrum.total() / photons_per_pixel;
    let differences = fast.intensity.iter().zip(&truth.intensity).map(|(&a, b)| (f64::from(a) - b).abs());
    let differences: Vec<f64> = differences.collect();
    let most = differences.iter().copied().fold(0.0, worse);
    assert!(most <= 1.001 * photon, "{} photons", most / photon);
    let counted = differences.iter().filter(|&&difference| difference > 1e-3 * photon).count();
    println!("    noise: {counted} pixels of {} differ, by {} photons", differences.len(), most / photon);
    assert!(counted <= 3, "{counted} pixels of {}", differences.len());
    // And it is noise.
    let quiet = Scene { effects: Effects { noise: None, ..scene.effects.clone() }, ..scene.clone() };
    let (quiet, _) = images(backend, &volume(grid), &quiet, &views(&grid), SIGNALS);
    let changed = fast.intensity.iter().zip(&quiet.intensity).filter(|(a, b)| (*a - *b).abs() > 0.1);
    assert!(changed.count() > fast.intensity.len() / 2);
}
