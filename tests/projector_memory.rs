//! What a volume, its projector and a projection ask for, in bytes that they hold at once.
#![allow(missing_docs, reason = "a test program")]
#![allow(unsafe_code, reason = "an allocator that counts")]

#[path = "support/held.rs"]
mod held;

use std::sync::Arc;

use drr::engine::{Backend, Images, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, View};
use drr::phantom::Phantom;
use drr::physics::{Calibration, Thresholds};
use drr::volume::{Classification, Volume, VolumeBuilder};
use drr::{Algorithm, Context, Projector, Scene, ViewRequest};
use held::held;

const DIMENSIONS: [usize; 3] = [400, 400, 320];
/// Pixels of a side of the detector: what is held beside images does not grow with it.
const SIDE: usize = 128;

/// HU and labels of a chest with noise.
fn chest() -> (Grid, Vec<i16>, Vec<u8>) {
    let phantom = Phantom::thorax().with_noise(true);
    let grid = phantom.grid(DIMENSIONS).expect("valid");
    let (mut hu, mut labels) = (Vec::new(), Vec::new());
    let keep = |_: usize, slice: &[i16], of_slice: &[u8]| {
        hu.extend_from_slice(slice);
        labels.extend_from_slice(of_slice);
        Ok(())
    };
    phantom.voxelise(&grid, keep).expect("axis-aligned");
    (grid, hu, labels)
}

/// Bytes of the images.
fn bytes(images: &Images<f32>) -> usize {
    let layers = [&images.intensity, &images.line_integral, &images.areal_density, &images.bone_path];
    layers.map(|layer| size_of_val(&layer[..])).iter().sum()
}

#[test]
fn a_projection_holds_little_beside_voxels_and_images() {
    let context = Context::new(Backend::Cpu, 2).expect("threads start");
    let (grid, hu, labels) = chest();
    let input = size_of_val(&hu[..]);
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    let views = DetectorPose::stereo_pair(&grid, 1000.0, 1500.0, 5.0, [SIDE; 2]);
    let views: Vec<ViewRequest> = views.into_iter().map(|pose| View::Pose(pose).into()).collect();
    let at_once = |labels| context.install(|| Volume::from_int16(grid, &hu, labels, &how)).expect("valid");
    let by_slices = || {
        let mut builder = VolumeBuilder::int16(grid, &how, false).expect("memory");
        let slices = hu.chunks(DIMENSIONS[0] * DIMENSIONS[1]);
        slices.for_each(|slice| builder.push_int16(slice, None).expect("valid"));
        builder.finish().expect("complete")
    };
    let makers: [(&str, &dyn Fn() -> Volume); 3] =
        [("HU", &|| at_once(None)), ("HU by slices", &by_slices), ("labels", &|| at_once(Some(&labels[..])))];
    for (name, make) in makers {
        for algorithm in [Algorithm::Joseph, Algorithm::Siddon] {
            let (images, most) = held(|| {
                let scene = Scene { method: algorithm.into(), ..Scene::new([SIDE; 2]).expect("valid") };
                let projector = Projector::new(&context, Arc::new(make()), scene).expect("valid");
                projector.project(&views, Layers::ALL, SILENT).expect("projects")
            });
            let beside = most - bytes(&images);
            let part = beside as f64 / input as f64;
            // Measured: 1.124 to 1.129, of which tables of 65536 entries are 0.09, whatever the number of voxels.
            assert!((1.0..1.15).contains(&part), "{name}, {}: {part} of the input's bytes", algorithm.name());
        }
    }
}
