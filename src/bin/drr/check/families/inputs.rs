//! Voxels and numbers that are not numbers, or hardly: NaN, infinities, denormals, padding, the ends of int16.

use std::ops::ControlFlow;
use std::sync::Arc;

use drr::geometry::{DetectorPose, Projection, View};
use drr::physics::MassAttenuation;
use drr::volume::Volume;
use drr::{Algorithm, Context, Projector, Scene, ViewRequest};
use glam::DVec3;

use super::spectra::{spectrum, through};
use crate::check::case::{Case, Demand, Set, segment};
use crate::check::volumes::{SMALL, classification, grey, unit_grid, volume, water};

pub(super) fn cases() -> Vec<Case> {
    [not_numbers(), denormals(), extremes()].into_iter().flatten().collect()
}

fn refusal(
    name: &str,
    argument: &'static str,
    attempt: impl Fn(&Context) -> drr::Result<()> + Send + Sync + 'static,
) -> Case {
    Case {
        family: 21,
        name: format!("refused: {name}"),
        demand: Demand::Refused(argument, Box::new(attempt)),
    }
}

/// Projects one view of water.
fn project(context: &Context, view: View) -> drr::Result<()> {
    let projector = Projector::new(context, water(unit_grid(SMALL)), Scene::new([1, 1])?)?;
    let layers = drr::engine::Layers { intensity: true, ..Default::default() };
    projector.project(&[ViewRequest::from(view)], layers, &|_| ControlFlow::Continue(())).map(|_| ())
}

fn not_numbers() -> Vec<Case> {
    let mut cases = Vec::new();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        cases.push(refusal(&format!("a voxel that is {bad}"), "hu at voxel [2, 1, 0]", move |_| {
            let grid = unit_grid(SMALL);
            let mut hu = vec![0.0; grid.voxel_count()];
            hu[7] = bad;
            Volume::from_float32(grid, &hu, None, &classification()).map(|_| ())
        }));
        let bad = f64::from(bad);
        let pose = segment(DVec3::new(-9.0, 1.0, 2.0), DVec3::new(9.0, 1.0, 2.0));
        cases.push(refusal(&format!("a source at {bad}"), "views[0].source", move |context| {
            project(context, View::Pose(DetectorPose { source: DVec3::new(0.0, bad, 0.0), ..pose }))
        }));
        cases.push(refusal(
            &format!("{bad} in a matrix"),
            "views[0].modelViewProjectionMatrix",
            move |context| {
                let mut projection = Projection::from_pose(&pose, [1, 1])?;
                projection.matrix.y_axis.x = bad;
                project(context, View::Projection(projection))
            },
        ));
        cases.push(refusal(&format!("an attenuation of {bad}"), "mass_attenuation[0][1]", move |_| {
            let grid = *Scene::new([1, 1])?.spectrum.grid();
            let mut values = vec![1.0; grid.count()];
            values[1] = bad;
            MassAttenuation::new(grid, vec!["of a case".into()], values).map(|_| ())
        }));
        cases.push(refusal(&format!("a step of {bad}"), "scene.step_voxels", move |context| {
            let scene = Scene { algorithm: Algorithm::March { step: bad }, ..Scene::new([1, 1])? };
            Projector::new(context, water(unit_grid(SMALL)), scene).map(|_| ())
        }));
    }
    cases
}

fn denormals() -> Vec<Case> {
    let (from, to) = (DVec3::new(-9.0, 1.2, 2.1), DVec3::new(15.0, 2.2, 3.3));
    let case = |name: &str, set| Case { family: 22, name: name.into(), demand: Demand::Exact(set) };
    let grid = unit_grid(SMALL);
    // The least that float32 CT numbers can be above vacuum.
    let hu: Vec<f32> =
        (0..grid.voxel_count()).map(|i| if i % 2 == 0 { -1000.0 } else { (-1000.0_f32).next_up() }).collect();
    let nearly = Volume::from_float32(grid, &hu, None, &classification()).expect("valid");
    let attenuating = |mu: f64| {
        Set::ray(grey(grid), from, to).with_scene(|scene| {
            let energies = *scene.spectrum.grid();
            let names = ["a", "b", "c", "d"].map(String::from).to_vec();
            scene.materials =
                MassAttenuation::new(energies, names, vec![mu; 4 * energies.count()]).expect("valid");
        })
    };
    vec![
        case("densities of 6e-8 g/cm3", Set::ray(Arc::new(nearly), from, to)),
        case("attenuation of 1e-40 cm2/g", attenuating(1e-40)),
        case("attenuation of 1e-310 cm2/g", attenuating(1e-310)),
        case("attenuation of 0", attenuating(0.0)),
        case("attenuation of 1e9 cm2/g", attenuating(1e9)),
        case("weights of 1e-40", through("soft_tissue", 80, spectrum(|_| 1e-40))),
        case(
            "a weight of 1e-44 beside 1",
            through("soft_tissue", 80, spectrum(|e| if e == 15.0 { 1.0 } else { 1e-44 })),
        ),
    ]
}

fn extremes() -> Vec<Case> {
    let (from, to) = (DVec3::new(-9.0, 1.2, 2.1), DVec3::new(15.0, 2.2, 3.3));
    let grid = unit_grid(SMALL);
    let with = |hu: i16| {
        let checkered = volume(grid, move |[i, j, k]| if (i + j + k) % 2 == 0 { (hu, 2) } else { (40, 2) });
        Set::ray(checkered, from, to)
    };
    let same =
        |name: String, a: Set, b: Set| Case { family: 23, name, demand: Demand::Same(Box::new([a, b])) };
    let mut cases = Vec::new();
    for padding in [i16::MIN, -3024, -2048, -2000, -1025] {
        cases.push(same(format!("{padding} HU is vacuum beside tissue"), with(padding), with(-1000)));
        let all = volume(grid, move |_| (padding, 2));
        cases.push(Case {
            family: 23,
            name: format!("nothing but {padding} HU"),
            demand: Demand::Vacuum(Set::ray(all, from, to)),
        });
    }
    for ceiling in [3072, 4095, i16::MAX] {
        cases.push(same(format!("{ceiling} HU is the scanner's ceiling"), with(ceiling), with(3071)));
    }
    cases
}
