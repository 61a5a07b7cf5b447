//! What a call asks for: supersampling, early exit, spectral tables of a view's own, views of different directions.

use std::sync::Arc;

use drr::engine::{Backend, Images, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, View};
use drr::physics::{EnergyGrid, SpectralModel, Spectrum};
use drr::volume::Volume;
use drr::{Algorithm, Projector, Scene, ViewRequest};
use glam::DVec3;

use crate::Test;
use crate::support::{awkward_grid, chest_hu, classification, poses, projector, requests, volume};
use crate::twin::{conforms, conforms_with, kinds, worse};

pub(super) const TESTS: [Test; 5] = [
    ("with_several_rays_per_pixel", with_several_rays_per_pixel),
    ("with_the_box_s_edge_in_a_pixel", with_the_box_s_edge_in_a_pixel),
    ("of_different_and_of_equal_driving_axes", of_different_and_of_equal_driving_axes),
    ("with_spectral_tables_of_their_own", with_spectral_tables_of_their_own),
    ("with_early_exit", with_early_exit),
];

const SIZE: [usize; 2] = [40, 28];

fn with_several_rays_per_pixel(backend: Backend) {
    let grid = awkward_grid([40, 45, 38]);
    let hu = chest_hu(grid.dimensions());
    let halves: Vec<f32> = hu.iter().map(|&hu| f32::from(hu) + 0.5).collect();
    let float32 = Volume::from_float32(grid, &halves, None, &classification()).expect("valid");
    let views = requests([poses(&grid, SIZE)[4].1]);
    for supersampling in [2, 3] {
        let scene = Scene { supersampling, ..Scene::new(SIZE).expect("valid") };
        let name = format!("{supersampling} rays a side");
        conforms_with(kinds(backend), backend, &name, &volume(grid), &scene, &views);
    }
    let scene = Scene { supersampling: 2, ..Scene::new(SIZE).expect("valid") };
    conforms_with(kinds(backend), backend, "2 rays a side, float32", &Arc::new(float32), &scene, &views);
}

/// Of 256 rays a few miss: equal terms by the hundred, which must not be rounded all the same way.
fn with_the_box_s_edge_in_a_pixel(backend: Backend) {
    let grid = Grid::centred([100, 7, 100], DVec3::splat(2.0)).expect("valid");
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| if i % 100 == 0 { -2000 } else { 37 }).collect();
    let volume = Arc::new(Volume::from_int16(grid, &hu, None, &classification()).expect("valid"));
    let scene = Scene { supersampling: 16, ..Scene::new([1, 1]).expect("valid") };
    for missing in [1.0, 4.0, 15.0] {
        let x = -90.0 - missing;
        let pose = DetectorPose {
            source: DVec3::new(x, -1e6, 0.3),
            first_pixel: DVec3::new(x, 1e3, 0.3),
            column_step: 16.0 * DVec3::X,
            row_step: 16.0 * DVec3::Z,
        };
        let name = format!("{missing} columns of rays beside the matter");
        conforms_with(kinds(backend), backend, &name, &volume, &scene, &requests([pose]));
    }
}

/// One launch for all: its rays have one driving axis, or each has its own.
fn of_different_and_of_equal_driving_axes(backend: Backend) {
    let grid = awkward_grid([70, 61, 53]);
    let volume = volume(grid);
    let scene = Scene::new(SIZE).expect("valid");
    let all = poses(&grid, SIZE).into_iter().map(|(_, pose)| pose);
    conforms(backend, "every view in one call", &volume, &scene, &requests(all));
    let pair = DetectorPose::stereo_pair(&grid, 1000.0, 1500.0, 8.0, SIZE);
    conforms(backend, "a stereo pair", &volume, &scene, &requests(pair));
}

/// Views of one scene with its own tube, with others, and with a tube that two of them share.
pub(super) fn of_several_tubes(grid: &Grid, scene: &Scene, size: [usize; 2]) -> Vec<ViewRequest> {
    let tube = |name: &str| {
        let spectrum = Spectrum::named(name, EnergyGrid::SPECIFICATION).expect("built in");
        Arc::new(SpectralModel::new(&spectrum, &scene.materials).expect("on one grid"))
    };
    let (soft, hard) = (tube("W60_2p5Al"), tube("W140_2p5Al"));
    let tubes = [None, Some(soft.clone()), Some(hard), Some(soft)];
    let arm = |angle| DetectorPose::c_arm(grid.centre(), angle, 1000.0, 1500.0, 8.0, size);
    let views = tubes.into_iter().zip([-6.0, 6.0, 84.0, 0.0]);
    let request = |(spectral, angle)| ViewRequest { spectral, ..View::Pose(arm(angle)).into() };
    views.map(request).collect()
}

fn with_spectral_tables_of_their_own(backend: Backend) {
    let grid = awkward_grid([70, 61, 53]);
    let scene = Scene::new(SIZE).expect("valid");
    let views = of_several_tubes(&grid, &scene, SIZE);
    conforms_with(kinds(backend), backend, "several tubes", &volume(grid), &scene, &views);
}

/// A chest four metres deep, behind which nothing is left, of many blocks of slices.
fn giant(size: [usize; 2]) -> (Arc<Volume>, View) {
    let grid = Grid::centred([40, 400, 30], DVec3::new(25.0, 10.0, 25.0)).expect("valid");
    let pose = DetectorPose::c_arm(DVec3::ZERO, 2.0, 9000.0, 12000.0, 1500.0 / size[0] as f64, size);
    (volume(grid), View::Pose(pose))
}

/// May lose e⁻¹⁵ of I0 in the intensity. Where another layer would show it, no ray stops.
fn with_early_exit(backend: Backend) {
    let (volume, view) = giant(SIZE);
    for &algorithm in kinds(backend) {
        let projector = projector(
            backend,
            &volume,
            Scene { method: algorithm.into(), ..Scene::new(SIZE).expect("valid") },
        );
        for bone_path in [false, true] {
            let layers = Layers { intensity: true, bone_path, ..Layers::default() };
            let [stopped, whole] = with_and_without(&projector, view, layers);
            let truth = projector.reference(algorithm, &[view.into()], layers, SILENT).expect("projects");
            let i0 = projector.scene().spectrum.total();
            let lost = stopped.intensity.iter().zip(&truth.intensity);
            let lost = lost.map(|(&x, t)| (f64::from(x) - t).abs() - 1e-4 * t).fold(0.0, worse);
            assert!(lost <= (-15.0_f64).exp() * i0, "{algorithm:?}: {lost:e} of {i0:e}");
            // Rays that are swept together never stop.
            let may_stop = (backend, algorithm) != (Backend::Cpu, Algorithm::Joseph);
            assert_eq!(stopped.intensity != whole.intensity, may_stop, "{algorithm:?}: whether a ray stops");
            assert!(stopped.bone_path == whole.bone_path, "{algorithm:?}: the bone path shows it");
            // A view that may not stop, beside one that may.
            let pair = [true, false].map(|early_exit| ViewRequest { early_exit, ..view.into() });
            let pair = projector.project(&pair, layers, SILENT).expect("projects");
            let parts = [&stopped.intensity[..], &whole.intensity].concat();
            assert!(pair.intensity == parts, "{algorithm:?}: another view's early exit shows");
        }
        for (line_integral, areal_density) in [(true, false), (false, true)] {
            let layers = Layers { intensity: true, line_integral, areal_density, bone_path: true };
            let [stopped, whole] = with_and_without(&projector, view, layers);
            assert!(stopped == whole, "{algorithm:?}: another layer was asked for");
        }
    }
}

fn with_and_without(projector: &Projector, view: View, layers: Layers) -> [Images<f32>; 2] {
    [true, false].map(|early_exit| {
        let view = ViewRequest { early_exit, ..view.into() };
        projector.project(&[view], layers, SILENT).expect("projects")
    })
}
