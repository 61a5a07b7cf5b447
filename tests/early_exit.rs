//! Early exit: a ray may stop once every energy is attenuated below e⁻¹⁵. That bounds what is lost whatever the spectrum,
//! and no layer but the intensity may show it.
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::sync::Arc;

use drr::Algorithm::{self, Joseph, March, Siddon};
use drr::engine::{Backend, Images, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, Projection, View};
use drr::physics::{
    Calibration, DensitySegment, DetectorResponse, EnergyGrid, MassAttenuation, SpectralModel, Spectrum,
    Thresholds,
};
use drr::volume::{Classification, Volume};
use drr::{Projector, Scene, ViewRequest};
use glam::{DMat4, DVec3, DVec4};
use support::{noise, projector};

const GRID: EnergyGrid = EnergyGrid::SPECIFICATION;

const INTENSITY: Layers =
    Layers { intensity: true, line_integral: false, areal_density: false, bone_path: false };

/// Depths of rods in the least attenuated energy with weight, as parts of 15: well below, around and far above, and
/// with a part of the rod around.
const DEPTHS: [f64; 11] = [0.1, 0.5, 0.9, 0.999, 1.001, 1.142, 1.144, 1.5, 2.1, 4.0, 10.0];

/// From this depth on some ray must have stopped; else the test would mean nothing.
const DEEP: f64 = 2.0;

/// Voxels along a rod.
const LENGTH: usize = 512;

/// Parallel rods along x, one per row, and the rays along their axes. `voxel` says the density (at most 4 g/cm³) and
/// the label at a row and a slice; slices are `mm` thick.
fn rods(rows: usize, mm: f64, voxel: impl Fn(usize, usize) -> (f64, u8)) -> (Arc<Volume>, View) {
    let grid = Grid::axis_aligned([LENGTH, rows, 1], DVec3::new(mm, 1.0, 1.0), DVec3::ZERO).expect("valid");
    let voxels = (0..grid.voxel_count()).map(|i| voxel(i / LENGTH, i % LENGTH));
    let (hu, labels): (Vec<f32>, Vec<u8>) =
        voxels.map(|(density, label)| ((1000.0 * density - 1000.0) as f32, label)).unzip();
    let how = Classification::named("linear", Thresholds::DEFAULT).expect("built in");
    let volume = Volume::from_float32(grid, &hu, Some(&labels), &how).expect("valid");
    (Arc::new(volume), along_rods(rows))
}

/// Rays along x: of pixel (i, 0) through y = i.
fn along_rods(rows: usize) -> View {
    let n = rows as f64;
    let x = DVec4::new(0.0, 2.0 / n, 0.0, 1.0 / n - 1.0);
    let matrix = DMat4::from_cols(x, DVec4::Z, 1e-6 * DVec4::X, DVec4::W).transpose();
    View::Projection(Projection { matrix, source: DVec3::ZERO })
}

fn scene(rows: usize, spectrum: &Spectrum, materials: &[&str]) -> Scene {
    Scene {
        detector: [rows, 1],
        spectrum: spectrum.clone(),
        materials: MassAttenuation::named(materials, *spectrum.grid()).expect("tabulated"),
        bone: Some(0),
        ..Scene::new([1, 1]).expect("valid")
    }
}

/// (μ/ρ) of a material in the energies that have weight, cm²/g.
fn coefficients(spectrum: &Spectrum, material: &str) -> Vec<f64> {
    let table = MassAttenuation::named(&[material], *spectrum.grid()).expect("tabulated");
    let bins = table.coefficients(0).iter().zip(spectrum.weights());
    bins.filter(|(_, w)| **w > 0.0).map(|(c, _)| *c).collect()
}

fn least(spectrum: &Spectrum, material: &str) -> f64 {
    coefficients(spectrum, material).into_iter().fold(f64::INFINITY, f64::min)
}

/// A spectrum of some lines, (keV, weight).
fn lines(name: &str, lines: &[(f64, f64)]) -> Spectrum {
    let mut weights = vec![0.0; GRID.count()];
    for &(kev, weight) in lines {
        weights[GRID.index_of(kev).expect("a whole keV")] = weight;
    }
    Spectrum::new(name, GRID, weights).expect("valid")
}

/// With early exit and without.
fn both(
    projector: &Projector,
    view: View,
    spectral: Option<&Arc<SpectralModel>>,
    layers: Layers,
) -> [Images<f32>; 2] {
    [true, false].map(|early_exit| {
        let spectral = spectral.cloned();
        let view = ViewRequest { early_exit, spectral, ..view.into() };
        projector.project(&[view], layers, SILENT).expect("projects")
    })
}

/// Holds the intensity to its bound and returns in which pixels it changed.
fn changed(name: &str, [stopped, whole]: &[Images<f32>; 2], i0: f64) -> Vec<bool> {
    let pairs = stopped.intensity.iter().zip(&whole.intensity).enumerate();
    pairs
        .map(|(p, (a, b))| {
            let lost = f64::from((a - b).abs());
            assert!(lost <= (-15.0_f64).exp() * i0, "{name}, pixel {p}: {a:e} for {b:e}, I0 {i0:e}");
            a != b
        })
        .collect()
}

/// Rods of one material and all `DEPTHS`.
fn stops_in_time(spectrum: &Spectrum, material: &str, algorithm: Algorithm) {
    // At a quarter of a g/cm³ a rod has depth 15.
    let mm = 10.0 * 15.0 / least(spectrum, material) / (0.25 * LENGTH as f64);
    let (volume, view) = rods(DEPTHS.len(), mm, |row, _| (0.25 * DEPTHS[row], 0));
    let scene = Scene { method: algorithm.into(), ..scene(DEPTHS.len(), spectrum, &[material]) };
    let projector = projector(Backend::Cpu, &volume, scene);
    let name = format!("{}, {material}, {algorithm:?}", spectrum.name());
    let changed = changed(&name, &both(&projector, view, None, INTENSITY), spectrum.total());
    for (depth, changed) in DEPTHS.into_iter().zip(changed) {
        assert!(!changed || depth > 1.0, "{name}: stopped at a depth of {depth} times 15");
        assert!(changed || depth < DEEP, "{name}: never stopped at a depth of {depth} times 15");
    }
}

#[test]
fn every_material_in_every_tube_and_detector() {
    for response in DetectorResponse::names() {
        let response = DetectorResponse::named(response, GRID).expect("built in");
        for tube in Spectrum::names() {
            let tube = Spectrum::named(tube, GRID).expect("built in");
            let spectrum = tube.folded(&response).expect("the same energies");
            for material in MassAttenuation::material_names() {
                stops_in_time(&spectrum, material, Joseph);
            }
        }
    }
}

#[test]
fn every_material_in_spectra_made_to_deceive() {
    let spectra = [
        lines("15 keV", &[(15.0, 1.0)]),
        lines("70 keV", &[(70.0, 3.0)]),
        lines("150 keV", &[(150.0, 1e-30)]),
        lines("a line and a faint one", &[(20.0, 1.0), (150.0, 1e-3)]),
        lines("a line and a fainter one", &[(20.0, 1.0), (150.0, 1e-6)]),
        lines("a line and one below the bound", &[(20.0, 1.0), (150.0, 1e-9)]),
        lines("around tungsten's K edge", &[(69.0, 1.0), (70.0, 1.0)]),
        lines("mostly above tungsten's K edge", &[(69.0, 1e-4), (70.0, 1.0), (71.0, 1.0)]),
        lines("around iodine's K edge", &[(33.0, 1e-3), (34.0, 1.0)]),
        Spectrum::new("flat", GRID, vec![1e20; GRID.count()]).expect("valid"),
    ];
    for spectrum in &spectra {
        for material in MassAttenuation::material_names() {
            for algorithm in [Joseph, Siddon, March { step: 0.7 }] {
                stops_in_time(spectrum, material, algorithm);
            }
        }
    }
}

/// One material behind another, in both orders: what the first one leaves, the second one may still take.
#[test]
fn two_materials_in_a_row() {
    let spectra = [
        Spectrum::named(Spectrum::DEFAULT, GRID).expect("built in"),
        lines("a line and a faint one", &[(20.0, 1.0), (150.0, 1e-3)]),
        lines("around tungsten's K edge", &[(69.0, 1.0), (70.0, 1.0)]),
    ];
    // Depth of each, in parts of 15.
    let depths = [
        [0.2, 0.7],
        [0.7, 0.2],
        [0.99, 0.005],
        [0.99, 0.5],
        [0.99, 8.0],
        [1.3, 1.3],
        [8.0, 0.01],
        [8.0, 8.0],
    ];
    for spectrum in &spectra {
        for pair in
            [["titanium", "air"], ["lung", "tungsten"], ["iodine", "bone_cortical"], ["csi", "copper"]]
        {
            for [a, b] in [pair, [pair[1], pair[0]]] {
                let [areal_a, areal_b] = [a, b].map(|material| 15.0 / least(spectrum, material));
                // The same voxels for both, so the densities carry the ratio of the areal densities.
                let mm = 10.0 * 8.0 * areal_a.max(areal_b) / (4.0 * 0.5 * LENGTH as f64);
                let density = |areal: f64| areal * 10.0 / (0.5 * LENGTH as f64 * mm);
                let (volume, view) = rods(depths.len(), mm, |row, slice| {
                    if slice < LENGTH / 2 {
                        (density(depths[row][0] * areal_a), 0)
                    } else {
                        (density(depths[row][1] * areal_b), 1)
                    }
                });
                let projector = projector(Backend::Cpu, &volume, scene(depths.len(), spectrum, &[a, b]));
                let name = format!("{}, {a} then {b}", spectrum.name());
                let changed = changed(&name, &both(&projector, view, None, INTENSITY), spectrum.total());
                let (of_a, of_b) = (coefficients(spectrum, a), coefficients(spectrum, b));
                for ([depth_a, depth_b], changed) in depths.into_iter().zip(changed) {
                    let through = |(a, b): (&f64, &f64)| depth_a * areal_a * a + depth_b * areal_b * b;
                    let total = of_a.iter().zip(&of_b).map(through).fold(f64::INFINITY, f64::min);
                    let what = format!("{name}, depths {depth_a} and {depth_b} times 15");
                    assert!(!changed || total > 15.0, "{what}: stopped");
                    assert!(changed || depth_a + depth_b < 8.0 || depth_b < 0.1, "{what}: never stopped");
                }
            }
        }
    }
}

/// Depth only grows along a ray: no calibration gives a voxel a negative density, and a ray that stopped cannot have
/// become brighter.
#[test]
fn noise_below_air_gives_nothing_back() {
    let segment = DensitySegment { first_hu: -1000.0, end_hu: 4000.0, intercept: -3.0, slope: 0.004 };
    let how = Classification {
        calibration: Calibration::new("negative below 750 HU", vec![segment]).expect("valid"),
        thresholds: Thresholds::named(Thresholds::DEFAULT).expect("built in"),
    };
    let grid = Grid::axis_aligned([LENGTH, 4, 1], DVec3::ONE, DVec3::ZERO).expect("valid");
    // Steel, then noise about −1000 HU.
    let hu = |i: usize| match i % LENGTH {
        0..100 => 2500.0,
        _ => -1000.0 + 400.0 * (noise(i as u64) - 0.5),
    };
    let hu: Vec<f64> = (0..grid.voxel_count()).map(hu).collect();
    let labels = vec![0; hu.len()];
    let codes: Vec<i16> = hu.iter().map(|&hu| hu as i16).collect();
    let floats: Vec<f32> = hu.iter().map(|&hu| hu as f32).collect();
    let spectrum = Spectrum::named(Spectrum::DEFAULT, GRID).expect("built in");
    for volume in [
        Volume::from_int16(grid, &codes, Some(&labels), &how),
        Volume::from_float32(grid, &floats, Some(&labels), &how),
    ] {
        let volume = Arc::new(volume.expect("valid"));
        let projector = projector(Backend::Cpu, &volume, scene(4, &spectrum, &["steel_316l"]));
        let images = both(&projector, along_rods(4), None, INTENSITY);
        let [stopped, whole] = &images;
        changed("steel, then noise", &images, spectrum.total());
        assert!(stopped.intensity.iter().zip(&whole.intensity).all(|(a, b)| a >= b && *b > 0.0));
        // 10 cm of 7 g/cm³: nothing behind it adds to the depth or takes from it.
        let areal =
            projector.project(&[along_rods(4).into()], Layers::ALL, SILENT).expect("projects").areal_density;
        assert!(areal.iter().all(|a| (a - 70.0).abs() < 1e-3 * 70.0), "{areal:?}");
    }
}

/// A thick block of bone and titanium, seen obliquely: one, four or eight accumulators, several rays per pixel.
#[test]
fn no_other_layer_shows_it() {
    let grid = Grid::centred([200, 60, 40], DVec3::splat(5.0)).expect("valid");
    let names = ["bone_cortical", "titanium", "copper", "muscle", "blood", "lung", "water", "air"];
    let size = [24, 18];
    let pose = DetectorPose::c_arm(grid.centre(), 77.0, 2000.0, 3000.0, 12.0, size);
    let spectrum = Spectrum::named(Spectrum::DEFAULT, GRID).expect("built in");
    for (count, supersampling, algorithm) in [
        (1_u8, 1, March { step: 1.0 }),
        (4, 2, Siddon),
        (8, 1, March { step: 0.5 }),
        (8, 3, March { step: 2.0 }),
    ] {
        let label = |i: usize| (f64::from(count) * noise(i as u64 / 7)) as u8;
        let labels: Vec<u8> = (0..grid.voxel_count()).map(label).collect();
        let hu = vec![3000; labels.len()];
        let volume = Volume::from_int16(grid, &hu, Some(&labels), &support::classification());
        let scene = Scene {
            detector: size,
            supersampling,
            method: algorithm.into(),
            ..scene(1, &spectrum, &names[..usize::from(count)])
        };
        let projector = projector(Backend::Cpu, &Arc::new(volume.expect("valid")), scene);
        let with = |layers: Layers| both(&projector, View::Pose(pose), None, layers);
        let name = format!("{count} materials");

        let intensity = with(INTENSITY);
        let changed = changed(&name, &intensity, spectrum.total());
        assert!(changed.contains(&true), "{name}: no ray stopped");
        let [stopped, whole] = with(Layers { bone_path: true, ..INTENSITY });
        assert_eq!(
            [&stopped.intensity, &whole.intensity],
            [&intensity[0].intensity, &intensity[1].intensity]
        );
        assert_eq!(stopped.bone_path, whole.bone_path);
        assert!(whole.bone_path.iter().any(|&mm| mm > 50.0), "{name}: no bone");
        // The stop would show in these, so there is none.
        for also in [
            Layers { line_integral: true, ..INTENSITY },
            Layers { areal_density: true, ..INTENSITY },
            Layers { intensity: false, ..Layers::ALL },
            Layers::ALL,
        ] {
            let [stopped, whole] = with(also);
            assert_eq!(stopped, whole, "{name}, {also:?}");
        }
    }
}

#[test]
fn a_view_stops_by_its_own_tables() {
    let soft = lines("20 keV", &[(20.0, 1.0)]);
    let hard = lines("150 keV", &[(150.0, 100.0)]);
    let mixed = lines("20 and 150 keV", &[(20.0, 1.0), (150.0, 1e-3)]);
    let model = |spectrum: &Spectrum, material: &str| {
        let table = MassAttenuation::named(&[material], GRID).expect("tabulated");
        Arc::new(SpectralModel::new(spectrum, &table).expect("the same energies"))
    };
    for scenes_own in [&soft, &hard] {
        for own in [&soft, &hard, &mixed] {
            for material in ["water", "titanium", "tungsten"] {
                // The scene calls water what the view's tables call something else.
                let mm = 10.0 * 15.0 / least(own, material) / (0.25 * LENGTH as f64);
                let (volume, view) = rods(DEPTHS.len(), mm, |row, _| (0.25 * DEPTHS[row], 0));
                let projector = projector(Backend::Cpu, &volume, scene(DEPTHS.len(), scenes_own, &["water"]));
                let name = format!("{} {material} in a scene of {}", own.name(), scenes_own.name());
                let own = model(own, material);
                let alone = both(&projector, view, Some(&own), INTENSITY);
                for (depth, changed) in DEPTHS.into_iter().zip(changed(&name, &alone, own.i0())) {
                    assert!(!changed || depth > 1.0, "{name}: stopped at a depth of {depth} times 15");
                    assert!(changed || depth < DEEP, "{name}: never stopped at a depth of {depth} times 15");
                }
                // In one call with views by the scene's tables, and without early exit.
                let request = |early_exit, spectral| ViewRequest { early_exit, spectral, ..view.into() };
                let requests = [
                    request(true, None),
                    request(true, Some(own.clone())),
                    request(false, Some(own)),
                    view.into(),
                ];
                let together = projector.project(&requests, INTENSITY, SILENT).expect("projects");
                let [by_scene, by_scene_whole] = both(&projector, view, None, INTENSITY);
                for (v, expected) in
                    [&by_scene, &alone[0], &alone[1], &by_scene_whole].into_iter().enumerate()
                {
                    assert_eq!(together.view(&together.intensity, v), expected.intensity, "{name}, view {v}");
                }
            }
        }
    }
}

#[test]
fn the_reference_never_stops() {
    let spectrum = Spectrum::named(Spectrum::DEFAULT, GRID).expect("built in");
    let (volume, view) = rods(DEPTHS.len(), 10.0, |row, _| (0.25 * DEPTHS[row], 0));
    let reference = projector(Backend::Reference, &volume, scene(DEPTHS.len(), &spectrum, &["titanium"]));
    let [stopped, whole] = both(&reference, view, None, INTENSITY);
    assert_eq!(stopped, whole);
}
