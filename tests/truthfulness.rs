//! Whether planned projectors keep what was promised: over all rays of random scenes, not over those they were chosen by.
//! `-- --nocapture` prints every case.
#![cfg(feature = "formats")]
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use drr::accuracy::{Sample, Truth};
use drr::engine::Backend;
use drr::formats::{Slice, VoxelKind, open_ct};
use drr::geometry::{DetectorPose, Grid, View};
use drr::phantom::Phantom;
use drr::physics::Spectrum;
use drr::volume::{Volume, VolumeBuilder};
use drr::{Context, Projector, Scene, Tolerance};
use glam::DVec3;
use support::{classification, noise};

/// Scenes per volume, and tolerances per scene.
const SCENES: usize = 3;
const TOLERANCES: usize = 8;
/// Smallest and largest tolerance, HU.
const RANGE: [f64; 2] = [0.05, 20.0];
/// Pixels a side: rays enough that the planner looks at a small part of them.
const SIDE: usize = 160;

/// The CT that the command carries, and those that developers have beside the project.
const CTS: [&str; 3] = [
    "src/bin/drr/default_ct/lidc_idri_0001_lowres.nii.gz",
    "../shared/ct/totalsegmentator/chest_crop_1p5mm.nii.gz",
    "../shared/ct/totalsegmentator/abdomen_3mm_int32.nii.gz",
];

fn ct(path: &Path) -> Arc<Volume> {
    let mut reader = open_ct(path, None).expect("a CT");
    let how = classification();
    let mut builder = match reader.header().voxels {
        VoxelKind::Int16 => VolumeBuilder::int16(reader.header().grid, &how, false),
        VoxelKind::Float32 => VolumeBuilder::float32(reader.header().grid, &how),
    }
    .expect("memory");
    let push = &mut |_: usize, slice: Slice<'_>| match slice {
        Slice::Int16(hu) => builder.push_int16(hu, None),
        Slice::Float32(hu) => builder.push_float32(hu, None),
    };
    reader.read(push).expect("readable");
    Arc::new(builder.finish().expect("complete"))
}

fn phantom(phantom: &Phantom, dimensions: [usize; 3]) -> Arc<Volume> {
    let grid = phantom.grid(dimensions).expect("valid");
    let mut builder = VolumeBuilder::int16(grid, &classification(), false).expect("memory");
    phantom.voxelise(&grid, |_, hu, _| builder.push_int16(hu, None)).expect("axis-aligned");
    Arc::new(builder.finish().expect("complete"))
}

/// Noise of all CT numbers: no scene is harder to sample.
fn static_noise() -> Arc<Volume> {
    let grid = Grid::centred([60, 50, 70], DVec3::new(2.0, 3.0, 2.5)).expect("valid");
    let hu: Vec<i16> = (0..grid.voxel_count() as u64).map(|n| (noise(n) * 3000.0) as i16 - 1000).collect();
    Arc::new(Volume::from_int16(grid, &hu, None, &classification()).expect("valid"))
}

fn volumes() -> Vec<(String, Arc<Volume>)> {
    let thorax = Phantom::thorax();
    let mut all = vec![
        ("thorax".to_owned(), phantom(&thorax, [120, 120, 110])),
        ("thorax with noise".to_owned(), phantom(&thorax.clone().with_noise(true), [100, 100, 80])),
        ("coarse thorax".to_owned(), phantom(&thorax, [48, 48, 40])),
        ("water cylinder".to_owned(), phantom(&Phantom::water_cylinder(), [80, 80, 60])),
        ("spheres".to_owned(), phantom(&Phantom::spheres(), [90, 90, 80])),
        ("noise".to_owned(), static_noise()),
    ];
    for path in CTS {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(path);
        if path.exists() {
            all.push((path.file_name().expect("a file").to_string_lossy().into_owned(), ct(&path)));
        } else {
            println!("not here: {}", path.display());
        }
    }
    all
}

/// Random numbers, 0 … 1, the same in every run.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 += 1;
        noise(self.0)
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// One or two C-arm views from anywhere around, near or far, of some part of the volume.
fn scene(volume: &Volume, random: &mut Random) -> Scene {
    let grid = volume.grid();
    let extent = grid.length_mm(DVec3::from_array(grid.dimensions().map(|n| n as f64)));
    let shift = DVec3::from_array([(); 3].map(|()| random.within(-0.1, 0.1) * extent));
    let (sad, width) = (extent * random.within(1.2, 4.0), extent * random.within(0.5, 1.6));
    let pose = |angle| {
        DetectorPose::c_arm(grid.centre() + shift, angle, sad, 1.5 * sad, width / SIDE as f64, [SIDE; 2])
    };
    let views = 1 + (random.unit() * 2.0) as usize;
    let views = (0..views).map(|_| View::Pose(pose(random.within(0.0, 360.0)))).collect();
    let mut scene = Scene { expected_views: views, ..Scene::new([SIDE; 2]).expect("valid") };
    let tubes = Spectrum::names();
    let tube = tubes[(random.unit() * tubes.len() as f64) as usize];
    scene.spectrum = Spectrum::named(tube, *scene.spectrum.grid()).expect("built in");
    scene
}

/// Planned by 1300 exact rays alone, 10 of 208 cases broke their tolerance here.
#[test]
fn the_error_over_all_rays_keeps_the_tolerance() {
    let context = Context::new(Backend::Cpu, 0).expect("threads start");
    let mut random = Random(7);
    let (mut cases, mut broken, mut scenes, mut beyond) = (0, Vec::new(), 0, Vec::new());
    for (name, volume) in volumes() {
        for _ in 0..SCENES {
            let scene = scene(&volume, &mut random);
            let all = Sample::even(&scene.expected_views, scene.detector, SIDE * SIDE);
            assert_eq!(all.rays(), scene.expected_views.len() * SIDE * SIDE);
            let truth = Truth::new(&context, &volume, &scene, all).expect("casts");
            let joseph = Projector::new(&context, volume.clone(), scene.clone()).expect("valid");
            let of_all = truth.compare(&truth.cast(&joseph).expect("casts")).hu.map_or(0.0, |hu| hu.rms);
            let certificate = joseph.certify(&scene.expected_views).expect("casts").total.hu;
            scenes += 1;
            if certificate.is_some_and(|hu| hu.rms_high < of_all) {
                beyond.push(format!("{name}: {of_all} HU, certified {certificate:?}"));
            }
            for n in 0..TOLERANCES {
                let part = (n as f64 + random.unit()) / TOLERANCES as f64;
                let hu = RANGE[0] * (RANGE[1] / RANGE[0]).powf(part);
                let planned = Scene { tolerance: Some(Tolerance::hu(hu)), ..scene.clone() };
                let projector = match Projector::new(&context, volume.clone(), planned) {
                    Ok(projector) => projector,
                    // Honest: it says that nothing it has keeps the tolerance.
                    Err(error) => {
                        println!("{name}: {hu:.3} HU refused: {error}");
                        continue;
                    }
                };
                let error = truth.compare(&truth.cast(&projector).expect("casts")).hu;
                let rms = error.map_or(0.0, |error| error.rms);
                cases += 1;
                println!("{name}: {hu:.3} HU allowed, {rms:.3} over all rays, {}", projector.plan().method);
                if rms > hu {
                    broken.push(format!("{name}: {rms} HU of {hu}, {}", projector.plan().method));
                }
            }
        }
    }
    println!("{} of {cases} cases keep their tolerance", cases - broken.len());
    println!("{} of {scenes} certificates hold", scenes - beyond.len());
    assert!(20 * beyond.len() <= scenes, "more than 5 % do not:\n{}", beyond.join("\n"));
    assert!(cases >= 120, "{cases} cases");
    assert!(100 * broken.len() <= cases, "more than 1 % do not:\n{}", broken.join("\n"));
}
