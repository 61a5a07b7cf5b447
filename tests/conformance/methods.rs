//! What a method trades beside the algorithm, on the engine that has it; the others say that they do not.

use std::sync::Arc;

use drr::engine::{Backend, Layers, SILENT};
use drr::physics::MassAttenuation;
use drr::volume::Volume;
use drr::{Accumulation, Algorithm, Context, Error, Method, Projector, Scene, Storage, ViewRequest};

use crate::Test;
use crate::support::{awkward_grid, chest_hu, classification, noise, poses, projector, requests, volume};
use crate::twin::{kinds, method_conforms};

pub(super) const TESTS: [Test; 4] = [
    ("with_every_sum", with_every_sum),
    ("sums_do_not_know_of_threads", sums_do_not_know_of_threads),
    ("with_early_exit_and_every_sum", with_early_exit_and_every_sum),
    ("with_bytes_where_they_suffice", with_bytes_where_they_suffice),
];

const SIZE: [usize; 2] = [40, 28];

const OTHER_SUMS: [Accumulation; 2] = [Accumulation::Naive, Accumulation::Compensated];

/// Every algorithm with every sum but the usual one, or nothing where the engine refuses them, as it must.
fn methods(backend: Backend, volume: &Arc<Volume>) -> Vec<Method> {
    let all = kinds(backend)
        .iter()
        .flat_map(|&algorithm| OTHER_SUMS.map(|accumulation| Method { accumulation, ..algorithm.into() }));
    if backend == Backend::Cpu {
        return all.collect();
    }
    let context = Context::new(backend, 1).expect("threads start");
    for method in all {
        let scene = Scene { method, ..Scene::new(SIZE).expect("valid") };
        let refused = Projector::new(&context, volume.clone(), scene).err();
        assert!(matches!(refused, Some(Error::Unsupported(_))), "{method}: {refused:?}");
    }
    Vec::new()
}

/// With one material, four and eight; rays are too short for even the naive sum to show.
fn with_every_sum(backend: Backend) {
    let grid = awkward_grid([40, 45, 38]);
    let views = requests([poses(&grid, SIZE)[4].1]);
    let eight = ["air", "lung", "soft_tissue", "bone_cortical", "adipose", "muscle", "blood", "titanium"];
    let hu = chest_hu(grid.dimensions());
    let halves: Vec<f32> = hu.iter().map(|&hu| f32::from(hu) + 0.5).collect();
    for count in [1, 4, 8] {
        let label = |i: usize| (noise(i as u64 / 50) * f64::from(count)) as u8;
        let labels: Vec<u8> = (0..hu.len()).map(label).collect();
        let scene = Scene::new(SIZE).expect("valid");
        let materials = MassAttenuation::named(&eight[..usize::from(count)], *scene.spectrum.grid());
        let scene = Scene { materials: materials.expect("tabulated"), bone: Some(count - 1), ..scene };
        let int16 = Volume::from_int16(grid, &hu, Some(&labels), &classification()).expect("valid");
        let float32 = Volume::from_float32(grid, &halves, Some(&labels), &classification()).expect("valid");
        for (storage, volume) in [("int16", Arc::new(int16)), ("float32", Arc::new(float32))] {
            let name = format!("{count} materials, {storage}");
            for method in methods(backend, &volume) {
                method_conforms(method, backend, &name, &volume, &scene, &views);
            }
        }
    }
}

fn sums_do_not_know_of_threads(backend: Backend) {
    let grid = awkward_grid([50, 41, 43]);
    let volume = volume(grid);
    let views = requests(poses(&grid, SIZE).into_iter().map(|(_, pose)| pose));
    for method in methods(backend, &volume) {
        let on = |threads: usize| {
            let context = Context::new(backend, threads).expect("threads start");
            let scene = Scene { method, ..Scene::new(SIZE).expect("valid") };
            let projector = Projector::new(&context, volume.clone(), scene).expect("valid");
            projector.project(&views, Layers::ALL, SILENT).expect("projects")
        };
        assert!(on(1) == on(3), "{method}: 3 threads differ");
    }
}

/// Through so much metal that rays stop.
fn with_early_exit_and_every_sum(backend: Backend) {
    let grid = awkward_grid([200, 60, 50]);
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| (2500.0 + 500.0 * noise(i as u64)) as i16).collect();
    let volume = Arc::new(Volume::from_int16(grid, &hu, None, &classification()).expect("valid"));
    let only = Layers { intensity: true, ..Layers::default() };
    let [whole, stopping] = [false, true].map(|early_exit| {
        let pose = |pose| ViewRequest { early_exit, ..requests([pose])[0].clone() };
        poses(&grid, SIZE).into_iter().map(|(_, each)| pose(each)).collect::<Vec<_>>()
    });
    for method in methods(backend, &volume) {
        let projector = projector(backend, &volume, Scene { method, ..Scene::new(SIZE).expect("valid") });
        let [whole, stopped] =
            [&whole, &stopping].map(|views| projector.project(views, only, SILENT).expect("projects"));
        let i0 = projector.scene().spectrum.total();
        let changes = whole.intensity.iter().zip(&stopped.intensity).map(|(a, b)| f64::from((a - b).abs()));
        let most = changes.fold(0.0, f64::max);
        assert!(most > 0.0, "{method}: no ray has stopped");
        assert!(most <= (-15.0_f64).exp() * i0, "{method}: {most:e}");
    }
}

/// 256 densities are exact where a volume has no more, down to the bits; where it has more, they are a fraction of a HU
/// off, and as much on any number of threads.
fn with_bytes_where_they_suffice(backend: Backend) {
    if backend != Backend::Cpu {
        return;
    }
    let grid = awkward_grid([50, 41, 43]);
    let views = requests(poses(&grid, SIZE).into_iter().map(|(_, pose)| pose));
    let hu = chest_hu(grid.dimensions());
    let few: Vec<i16> = hu.iter().map(|hu| hu / 16 * 16).collect();
    for (hu, exact) in [(&few, true), (&hu, false)] {
        let volume = || Arc::new(Volume::from_int16(grid, hu, None, &classification()).expect("valid"));
        let project = |algorithm: Algorithm, storage, threads| {
            let context = Context::new(backend, threads).expect("threads start");
            let method = Method { storage, ..algorithm.into() };
            let scene = Scene { method, ..Scene::new(SIZE).expect("valid") };
            let projector = Projector::new(&context, volume(), scene).expect("valid");
            projector.project(&views, Layers::ALL, SILENT).expect("projects")
        };
        for &algorithm in kinds(backend) {
            let [bytes, again] = [1, 3].map(|threads| project(algorithm, Storage::Byte, threads));
            assert!(bytes == again, "{algorithm:?}: 3 threads differ");
            let whole = project(algorithm, Storage::Exact, 2);
            assert!(bytes.bone_path == whole.bone_path, "{algorithm:?}: labels differ");
            // Rays through 16-bit voxels are swept, through bytes never: in other roundings.
            let swept = algorithm == Algorithm::Joseph;
            assert!((bytes == whole) == (exact && !swept), "{algorithm:?}");
            let largest = whole.line_integral.iter().copied().fold(0.0, f32::max);
            let pairs = bytes.line_integral.iter().zip(&whole.line_integral);
            let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let most = if exact { 2e-6 } else { 1e-3 };
            assert!(off < most * largest, "{algorithm:?}: {off} of {largest}");
        }
    }
}
