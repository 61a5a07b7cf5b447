//! Voxels and numbers that are not numbers, or hardly: NaN, infinities, denormals, padding, the ends of int16.

use std::sync::Arc;

use drr::engine::{Images, Layers, SILENT};
use drr::geometry::{DetectorPose, Projection, View};
use drr::physics::MassAttenuation;
use drr::volume::Volume;
use drr::{Algorithm, Context, Projector, Scene, ViewRequest};
use glam::DVec3;

use super::spectra::{spectrum, through};
use crate::check::case::{Case, Set, segment};
use crate::check::volumes::{SMALL, classification, grey, unit_grid, volume, water};

pub(super) fn cases() -> Vec<Case> {
    [not_numbers(), denormals(), extremes()].into_iter().flatten().collect()
}

/// An oblique ray through a small volume.
fn oblique(volume: Arc<Volume>) -> Set {
    Set::ray(volume, DVec3::new(-9.0, 1.2, 2.1), DVec3::new(15.0, 2.2, 3.3))
}

/// Projects one view of water.
fn project(context: &Context, view: View) -> drr::Result<Images<f32>> {
    let projector = Projector::new(context, water(unit_grid(SMALL)), Scene::new([1, 1])?)?;
    let layers = Layers { intensity: true, ..Layers::default() };
    projector.project(&[ViewRequest::from(view)], layers, SILENT)
}

fn not_numbers() -> Vec<Case> {
    let mut cases = Vec::new();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        cases.push(Case::refused(21, format!("a voxel that is {bad}"), "hu at voxel [2, 1, 0]", move |_| {
            let grid = unit_grid(SMALL);
            let mut hu = vec![0.0; grid.voxel_count()];
            hu[7] = bad;
            Volume::from_float32(grid, &hu, None, &classification())
        }));
        let bad = f64::from(bad);
        let pose = segment(DVec3::new(-9.0, 1.0, 2.0), DVec3::new(9.0, 1.0, 2.0));
        cases.push(Case::refused(21, format!("a source at {bad}"), "views[0].source", move |context| {
            project(context, View::Pose(DetectorPose { source: DVec3::new(0.0, bad, 0.0), ..pose }))
        }));
        cases.push(Case::refused(
            21,
            format!("{bad} in a matrix"),
            "views[0].modelViewProjectionMatrix",
            move |context| {
                let mut projection = Projection::from_pose(&pose, [1, 1])?;
                projection.matrix.y_axis.x = bad;
                project(context, View::Projection(projection))
            },
        ));
        cases.push(Case::refused(
            21,
            format!("an attenuation of {bad}"),
            "mass_attenuation[0][1]",
            move |_| {
                let grid = *Scene::new([1, 1])?.spectrum.grid();
                let mut values = vec![1.0; grid.count()];
                values[1] = bad;
                MassAttenuation::new(grid, vec!["of a case".into()], values)
            },
        ));
        cases.push(Case::refused(21, format!("a step of {bad}"), "scene.step_voxels", move |context| {
            let scene = Scene { method: Algorithm::March { step: bad }.into(), ..Scene::new([1, 1])? };
            Projector::new(context, water(unit_grid(SMALL)), scene)
        }));
    }
    cases
}

fn denormals() -> Vec<Case> {
    let grid = unit_grid(SMALL);
    // The least that float32 CT numbers can be above vacuum.
    let hu: Vec<f32> =
        (0..grid.voxel_count()).map(|i| if i % 2 == 0 { -1000.0 } else { (-1000.0_f32).next_up() }).collect();
    let nearly = Volume::from_float32(grid, &hu, None, &classification()).expect("valid");
    let attenuating = |mu: f64| {
        oblique(grey(grid)).with_scene(|scene| {
            let energies = *scene.spectrum.grid();
            let names = ["a", "b", "c", "d"].map(String::from).to_vec();
            scene.materials =
                MassAttenuation::new(energies, names, vec![mu; 4 * energies.count()]).expect("valid");
        })
    };
    vec![
        Case::exact(22, "densities of 6e-8 g/cm3", oblique(Arc::new(nearly))),
        Case::exact(22, "attenuation of 1e-40 cm2/g", attenuating(1e-40)),
        Case::exact(22, "attenuation of 1e-310 cm2/g", attenuating(1e-310)),
        Case::exact(22, "attenuation of 0", attenuating(0.0)),
        Case::exact(22, "attenuation of 1e9 cm2/g", attenuating(1e9)),
        Case::exact(22, "weights of 1e-40", through("soft_tissue", 80, spectrum(|_| 1e-40))),
        Case::exact(
            22,
            "a weight of 1e-44 beside 1",
            through("soft_tissue", 80, spectrum(|e| if e == 15.0 { 1.0 } else { 1e-44 })),
        ),
    ]
}

fn extremes() -> Vec<Case> {
    let grid = unit_grid(SMALL);
    let with =
        |hu: i16| oblique(volume(grid, move |[i, j, k]| (if (i + j + k) % 2 == 0 { hu } else { 40 }, 2)));
    let mut cases = Vec::new();
    for padding in [i16::MIN, -3024, -2048, -2000, -1025] {
        let name = format!("{padding} HU is vacuum beside tissue");
        cases.push(Case::same(23, name, [with(padding), with(-1000)]));
        let all = volume(grid, move |_| (padding, 2));
        cases.push(Case::vacuum(23, format!("nothing but {padding} HU"), oblique(all)));
    }
    for ceiling in [3072, 4095, i16::MAX] {
        let name = format!("{ceiling} HU is the scanner's ceiling");
        cases.push(Case::same(23, name, [with(ceiling), with(3071)]));
    }
    cases
}
