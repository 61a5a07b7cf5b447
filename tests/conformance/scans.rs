//! The CT that the command carries, and the phantoms, from where the main job looks.

use std::path::Path;
use std::sync::Arc;

use drr::Scene;
use drr::engine::Backend;
use drr::formats::{CtReader as _, Slice, StoredCt};
use drr::geometry::DetectorPose;
use drr::phantom::Phantom;
use drr::volume::{Volume, VolumeBuilder};

use crate::Test;
use crate::support::{classification, requests};
use crate::twin::{conforms_with, kinds};

pub(super) const TESTS: [Test; 2] =
    [("of_a_real_chest", of_a_real_chest), ("of_the_phantoms", of_the_phantoms)];

/// An eighth of the main job's pixels a side, each eight times as large.
const SIZE: [usize; 2] = [90, 90];
const PIXEL_MM: f64 = 7.2;

/// Holds the stereo pair of the main job to its twin.
fn stereo_pair(backend: Backend, name: &str, volume: &Arc<Volume>) {
    let pair = DetectorPose::stereo_pair(volume.grid(), 1000.0, 1500.0, PIXEL_MM, SIZE);
    conforms_with(kinds(backend), backend, name, volume, &Scene::new(SIZE).expect("valid"), &requests(pair));
}

fn of_a_real_chest(backend: Backend) {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("src/bin/drr/default_ct/lidc_idri_0001_lowres.nii.gz");
    let mut ct = StoredCt::open(&path).expect("the CT is there");
    let mut builder = VolumeBuilder::int16(ct.header().grid, &classification(), false).expect("memory");
    let read = ct.read(&mut |_, slice| match slice {
        Slice::Int16(hu) => builder.push_int16(hu, None),
        Slice::Float32(_) => unreachable!("its voxels are integers"),
    });
    read.expect("reads");
    stereo_pair(backend, "LIDC-IDRI-0001", &Arc::new(builder.finish().expect("complete")));
}

fn of_the_phantoms(backend: Backend) {
    for name in ["water_cylinder", "rods", "spheres", "thorax"] {
        let phantom = Phantom::named(name).expect("built in").with_noise(name == "thorax");
        let grid = phantom.grid([180, 180, 166]).expect("valid");
        let mut builder = VolumeBuilder::int16(grid, &classification(), true).expect("memory");
        phantom.voxelise(&grid, |_, hu, labels| builder.push_int16(hu, Some(labels))).expect("axis-aligned");
        stereo_pair(backend, name, &Arc::new(builder.finish().expect("complete")));
    }
}
