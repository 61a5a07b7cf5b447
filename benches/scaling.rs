//! What surrounds the rays on the CPU: making voxels of the target case's HU beside a copy of as many bytes to memory
//! as fresh, which is the floor; and what a call takes of a projector of 128³ voxels, with rays and without. Ratios to
//! the copy carry over to other machines; seconds do not.
#![allow(missing_docs, reason = "criterion makes public functions")]
#![allow(unsafe_code, reason = "calls the C ABI")]

use std::hint::black_box;
use std::mem::MaybeUninit;
use std::ptr::null;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use drr::capi::context::drr_context_create;
use drr::capi::geometry::drr_pose_c_arm;
use drr::capi::outputs::drr_outputs_init;
use drr::capi::projector::{drr_projector_create, drr_projector_project_poses};
use drr::capi::scene::drr_scene_init;
use drr::capi::status::{DRR_STATUS_OK, DrrStatus};
use drr::capi::volume::{drr_volume_create, drr_volume_descriptor_init};
use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, View};
use drr::phantom::Phantom;
use drr::physics::{Calibration, Thresholds};
use drr::volume::{Classification, Volume, VolumeBuilder};
use drr::{Context, Projector, Scene, ViewRequest};
use glam::DVec3;
use rayon::prelude::*;

/// HU and labels of the thorax phantom with noise.
fn thorax(dimensions: [usize; 3]) -> (Grid, Vec<i16>, Vec<u8>) {
    let phantom = Phantom::thorax().with_noise(true);
    let grid = phantom.grid(dimensions).expect("valid");
    let (mut hu, mut labels) = (Vec::with_capacity(grid.voxel_count()), Vec::new());
    let keep = |_: usize, slice: &[i16], of_slice: &[u8]| {
        hu.extend_from_slice(slice);
        labels.extend_from_slice(of_slice);
        Ok(())
    };
    phantom.voxelise(&grid, keep).expect("axis-aligned");
    (grid, hu, labels)
}

fn classification() -> Classification {
    Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in")
}

fn upload(criterion: &mut Criterion) {
    let how = classification();
    let (grid, hu, labels) = thorax([720, 720, 665]);
    let mut group = criterion.benchmark_group("upload");
    group.sample_size(10);
    for threads in [1, 0] {
        let context = Context::new(Backend::Cpu, threads).expect("threads start");
        let on = format!("{} thread(s)", context.threads());
        let copy = || {
            let mut copy: Vec<i16> = Vec::with_capacity(hu.len());
            copy.par_extend(&hu);
            copy
        };
        group.bench_function(format!("floor: a copy to fresh memory, {on}"), |bencher| {
            bencher.iter(|| context.install(copy));
        });
        let mut upload = |name: &str, pieces: usize, labels: Option<&[u8]>| {
            let make = || {
                let mut builder = VolumeBuilder::int16(grid, &how, labels.is_some()).expect("memory");
                for (n, hu) in hu.chunks(pieces).enumerate() {
                    let labels = labels.map(|labels: &[u8]| &labels[n * pieces..][..hu.len()]);
                    builder.push_int16(hu, labels).expect("valid");
                }
                builder.finish().expect("complete")
            };
            group.bench_function(format!("{name}, {on}"), |bencher| {
                bencher.iter(|| context.install(make));
            });
        };
        upload("HU", hu.len(), None);
        upload("HU, slice by slice", 720 * 720, None);
        upload("HU and labels", hu.len(), Some(&labels));
    }
    group.finish();
}

const SIDE: usize = 128;

fn small(criterion: &mut Criterion) {
    let (grid, hu, _) = thorax([SIDE; 3]);
    let context = Context::new(Backend::Cpu, 0).expect("threads start");
    let volume = Volume::from_int16(grid, &hu, None, &classification()).expect("valid");
    let volume = Arc::new(volume);
    let only = Layers { intensity: true, ..Layers::default() };
    let mut group = criterion.benchmark_group("small projections");
    for (name, size, aside) in [
        ("256×256 pixels", 256, 0.0),
        ("256×256 pixels whose rays miss", 256, 1e4),
        ("8×8 pixels", 8, 0.0),
        ("8×8 pixels whose rays miss: what a call costs", 8, 1e4),
    ] {
        let scene = Scene::new([size; 2]).expect("valid");
        let projector = Projector::new(&context, volume.clone(), scene).expect("valid");
        let mut pose =
            DetectorPose::c_arm(grid.centre(), 0.0, 1000.0, 1500.0, 540.0 / size as f64, [size; 2]);
        pose.source += DVec3::new(0.0, 0.0, aside);
        pose.first_pixel += DVec3::new(0.0, 0.0, aside);
        let view: [ViewRequest; 1] = [View::Pose(pose).into()];
        group.bench_function(name, |bencher| {
            bencher.iter(|| projector.project(&view, only, SILENT).expect("projects"));
        });
    }
    group.bench_function("the hop to the context's threads and back", |bencher| {
        bencher.iter(|| context.install(|| black_box(0)));
    });
    group.finish();
}

/// What a function of the C ABI fills.
fn made<T>(make: impl FnOnce(*mut T) -> DrrStatus) -> T {
    let mut place = MaybeUninit::uninit();
    assert_eq!(make(place.as_mut_ptr()), DRR_STATUS_OK);
    // SAFETY: a call that succeeds has written its result.
    unsafe { place.assume_init() }
}

fn small_by_c(criterion: &mut Criterion) {
    let (_, hu, _) = thorax([SIDE; 3]);
    let mut image = [0.0_f32; 64];
    // SAFETY: pointers to one value of the right type each, or to as many as descriptor and scene say.
    unsafe {
        let context = made(|place| drr_context_create(null(), place));
        let mut descriptor = made(|place| drr_volume_descriptor_init(place));
        descriptor.dimensions = [SIDE; 3];
        let volume =
            made(|place| drr_volume_create(context, &raw const descriptor, hu.as_ptr(), null(), place));
        let mut scene = made(|place| drr_scene_init(place));
        (scene.detector_width, scene.detector_height) = (8, 8);
        let projector = made(|place| drr_projector_create(volume, &raw const scene, place));
        let mut outputs = made(|place| drr_outputs_init(place));
        outputs.intensity = image.as_mut_ptr();
        let aside = [63.5, 63.5, 1e4];
        let pose = made(|place| drr_pose_c_arm(aside.as_ptr(), 0.0, 1000.0, 1500.0, 1.0, 8, 8, place));
        let project = || {
            let status = drr_projector_project_poses(projector, &raw const pose, 1, &raw const outputs);
            assert_eq!(status, DRR_STATUS_OK);
        };
        criterion.bench_function("small projections/8×8 pixels whose rays miss, C ABI", |bencher| {
            bencher.iter(project);
        });
    }
}

criterion_group!(benches, small, small_by_c, upload);
criterion_main!(benches);
