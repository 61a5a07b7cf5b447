//! How error grows with a ray's length, by how its samples are added: the CPU engine against its float64 twin. The numbers
//! are printed: `cargo test --release --test accumulation -- --nocapture`.
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::sync::Arc;

use drr::Accumulation::{Blocked, Compensated, Naive};
use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid};
use drr::physics::{MassAttenuation, Thresholds};
use drr::volume::{Classification, Volume};
use drr::{Algorithm, Method, Scene};
use glam::DVec3;
use support::{noise, projector, relative_l2, requests};

const SIZE: [usize; 2] = [8, 8];

const AREAL_DENSITY: Layers =
    Layers { intensity: false, line_integral: false, areal_density: true, bone_path: false };

/// What conformance allows the engine, whatever the length.
const BOUND: f64 = 4e-7;

/// g/cm³ of each label.
const DENSITIES: [f64; 4] = [1.0, 0.0012, 0.26, 1.6];

const MATERIALS: [&str; 4] = ["soft_tissue", "air", "lung", "bone_cortical"];

/// A beam of `length` voxels of 1 mm, 3×3 across, every voxel within 10 % of its material's density. Materials come in
/// runs of some 20 voxels.
fn beam(length: usize, materials: usize) -> Arc<Volume> {
    let grid = Grid::axis_aligned([length, 3, 3], DVec3::ONE, DVec3::ZERO).expect("valid");
    let label = |i: usize| (noise(i as u64 / 20) * materials as f64) as u8;
    let labels: Vec<u8> = (0..grid.voxel_count()).map(label).collect();
    let hu = |(i, &label): (usize, &u8)| {
        let density = DENSITIES[usize::from(label)] * (0.9 + 0.2 * noise(!(i as u64)));
        (1000.0 * density - 1000.0) as f32
    };
    let hu: Vec<f32> = labels.iter().enumerate().map(hu).collect();
    let how = Classification::named("linear", Thresholds::DEFAULT).expect("built in");
    Arc::new(Volume::from_float32(grid, &hu, Some(&labels), &how).expect("valid"))
}

/// Rays from end to end, each a little different.
fn pose(length: usize) -> DetectorPose {
    DetectorPose {
        source: DVec3::new(-10.0, 1.13, 0.87),
        first_pixel: DVec3::new(length as f64 + 10.0, 0.11, 0.23),
        column_step: DVec3::Y * (1.8 / SIZE[0] as f64),
        row_step: DVec3::Z * (1.7 / SIZE[1] as f64),
    }
}

/// Relative L2 of the areal densities, by sum.
fn errors(length: usize, materials: usize, algorithm: Algorithm) -> [f64; 3] {
    let volume = beam(length, materials);
    let scene = Scene { bone: None, ..Scene::new(SIZE).expect("valid") };
    let table = MassAttenuation::named(&MATERIALS[..materials], *scene.spectrum.grid()).expect("tabulated");
    let scene = |accumulation| {
        let method = Method { accumulation, ..algorithm.into() };
        Scene { materials: table.clone(), method, ..scene.clone() }
    };
    let views = requests([pose(length)]);
    let truth = projector(Backend::Cpu, &volume, scene(Blocked))
        .reference(algorithm, &views, AREAL_DENSITY, SILENT)
        .expect("projects");
    [Naive, Blocked, Compensated].map(|accumulation| {
        let projector = projector(Backend::Cpu, &volume, scene(accumulation));
        let fast = projector.project(&views, AREAL_DENSITY, SILENT).expect("projects");
        relative_l2(&fast.areal_density, &truth.areal_density)
    })
}

#[test]
fn only_the_naive_sum_s_error_grows_with_the_ray() {
    let fine = Algorithm::March { step: 0.25 };
    let paths = [
        (100, 100, Algorithm::Joseph),
        (1000, 1000, Algorithm::Joseph),
        (10_000, 10_000, Algorithm::Joseph),
        (100_000, 25_000, fine),
    ];
    for materials in [1, 4] {
        let mut shorter = 0.0;
        for (samples, length, algorithm) in paths {
            let [naive, blocked, compensated] = errors(length, materials, algorithm);
            println!(
                "{samples:>6} samples, {materials} material(s): naive {naive:.1e}, blocked {blocked:.1e}, \
                 compensated {compensated:.1e}"
            );
            assert!(blocked < BOUND && compensated < BOUND, "{samples} samples: {blocked}, {compensated}");
            assert!(naive > shorter, "{samples} samples: {naive} after {shorter}");
            assert!(samples < 10_000 || naive > 4.0 * blocked.max(compensated), "{samples} samples: {naive}");
            shorter = naive;
        }
    }
}
