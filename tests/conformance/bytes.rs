//! What must not show in a single bit: how often a call is made, on how many threads, with which other views, and for
//! which other layers. On GPUs each of these may be another kernel.

use std::sync::Arc;

use drr::engine::{Backend, Images, Layers, SILENT};
use drr::volume::Volume;
use drr::{Algorithm, Context, Projector, Scene, ViewRequest};

use crate::Test;
use crate::support::{awkward_grid, poses, projector, requests, volume};
use crate::twin::kinds;
use crate::views::of_several_tubes;

pub(super) const TESTS: [Test; 4] = [
    ("calls_and_threads_do_not_show", calls_and_threads_do_not_show),
    ("views_do_not_know_of_each_other", views_do_not_know_of_each_other),
    ("layers_do_not_know_of_each_other", layers_do_not_know_of_each_other),
    ("layers_of_several_rays_do_not_know_of_each_other", layers_of_several_rays_do_not_know_of_each_other),
];

/// Not a multiple of any tile.
const SIZE: [usize; 2] = [37, 23];

fn scene(algorithm: Algorithm) -> Scene {
    Scene { method: algorithm.into(), ..Scene::new(SIZE).expect("valid") }
}

/// The bits of every layer; an empty one is as long as none.
fn bits(images: &Images<f32>) -> [Vec<u32>; 4] {
    [&images.intensity, &images.line_integral, &images.areal_density, &images.bone_path]
        .map(|layer| layer.iter().map(|x| x.to_bits()).collect())
}

fn project(projector: &Projector, views: &[ViewRequest], layers: Layers) -> [Vec<u32>; 4] {
    bits(&projector.project(views, layers, SILENT).expect("projects"))
}

fn calls_and_threads_do_not_show(backend: Backend) {
    let grid = awkward_grid([50, 41, 43]);
    let volume = volume(grid);
    let views = requests(poses(&grid, SIZE).into_iter().map(|(_, pose)| pose));
    for &algorithm in kinds(backend) {
        let on = |threads: usize| {
            let context = Context::new(backend, threads).expect("threads start");
            Projector::new(&context, volume.clone(), scene(algorithm)).expect("valid")
        };
        let one = on(1);
        let first = project(&one, &views, Layers::ALL);
        assert!(first == project(&one, &views, Layers::ALL), "{algorithm:?}: a second call differs");
        for threads in [2, 3, 8] {
            let again = project(&on(threads), &views, Layers::ALL);
            assert!(first == again, "{algorithm:?}: {threads} threads differ");
        }
    }
}

/// Views of all driving axes, alone, in two batches and together; with tubes of their own, too.
fn views_do_not_know_of_each_other(backend: Backend) {
    let grid = awkward_grid([50, 41, 43]);
    let volume = volume(grid);
    for &algorithm in kinds(backend) {
        let projector = projector(backend, &volume, scene(algorithm));
        let mut views = requests(poses(&grid, SIZE).into_iter().map(|(_, pose)| pose));
        views.extend(of_several_tubes(&grid, projector.scene(), SIZE));
        let together = project(&projector, &views, Layers::ALL);
        for batch in [1, 3, 8] {
            let parts: Vec<_> =
                views.chunks(batch).map(|views| project(&projector, views, Layers::ALL)).collect();
            let joined: [Vec<u32>; 4] =
                [0, 1, 2, 3].map(|layer| parts.iter().flat_map(|part| part[layer].clone()).collect());
            assert!(together == joined, "{algorithm:?}: {batch} views at a time differ");
        }
    }
}

/// Every choice of layers.
fn choices() -> impl Iterator<Item = Layers> {
    (1..16).map(|bits| Layers {
        intensity: bits & 1 != 0,
        line_integral: bits & 2 != 0,
        areal_density: bits & 4 != 0,
        bone_path: bits & 8 != 0,
    })
}

/// Holds the layers of every choice to those of all of them.
fn same_whatever_is_asked(
    projector: &Projector,
    views: &[ViewRequest],
    choices: impl Iterator<Item = Layers>,
) {
    let all = project(projector, views, Layers::ALL);
    for layers in choices {
        let some = project(projector, views, layers);
        let Layers { intensity, line_integral, areal_density, bone_path } = layers;
        let asked = [intensity, line_integral, areal_density, bone_path];
        for layer in 0..4 {
            let expected = if asked[layer] { &all[layer][..] } else { &[] };
            assert!(
                some[layer] == expected,
                "{:?}, {layers:?}: layer {layer}",
                projector.plan().method.algorithm
            );
        }
    }
}

fn small() -> (Arc<Volume>, Vec<ViewRequest>) {
    let grid = awkward_grid([50, 41, 43]);
    (volume(grid), requests([poses(&grid, SIZE)[0].1, poses(&grid, SIZE)[6].1]))
}

fn layers_do_not_know_of_each_other(backend: Backend) {
    let (volume, views) = small();
    for &algorithm in kinds(backend) {
        same_whatever_is_asked(&projector(backend, &volume, scene(algorithm)), &views, choices());
    }
}

fn layers_of_several_rays_do_not_know_of_each_other(backend: Backend) {
    let (volume, views) = small();
    let scene = Scene { supersampling: 2, ..scene(Algorithm::Joseph) };
    let single = [1, 2, 4, 8].into_iter().map(|bits| choices().nth(bits - 1).expect("one of 15"));
    same_whatever_is_asked(&projector(backend, &volume, scene), &views, single);
}
