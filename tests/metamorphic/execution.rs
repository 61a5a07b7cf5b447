//! What one call computes is what several calls compute, on any number of threads.

use drr::engine::{Backend, Images, Layers};
use drr::geometry::DetectorPose;
use drr::{Algorithm, Context, ViewRequest};
use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

use crate::case::{ANY, Case, calibration, cases, run, sized_cases};
use crate::pose::{Aim, aim};
use crate::scenes;
use crate::tolerance::{Tolerance, identical};

/// Of views of the same size, the one with number `view`.
fn view(images: &Images<f64>, view: usize) -> Images<f64> {
    let materials = images.materials;
    let areal = (0..materials).flat_map(|m| images.areal_density(view, m)).copied().collect();
    Images {
        views: 1,
        intensity: images.view(&images.intensity, view).to_vec(),
        line_integral: images.view(&images.line_integral, view).to_vec(),
        areal_density: areal,
        bone_path: images.view(&images.bone_path, view).to_vec(),
        ..images.clone()
    }
}

/// The pixels from `first` on of a detector of `size`, as a case of their own and cut out of `images`.
fn cut(case: &Case, first: [usize; 2], size: [usize; 2], images: &Images<f64>) -> (Case, Images<f64>) {
    let [width, height] = case.size;
    let window = |layer: &[f64]| -> Vec<f64> {
        let planes = layer.chunks(width * height);
        let row = |plane: &[f64], j: usize| plane[(first[1] + j) * width + first[0]..][..size[0]].to_vec();
        planes.flat_map(|plane| (0..size[1]).flat_map(|j| row(plane, j)).collect::<Vec<_>>()).collect()
    };
    let part = Images {
        size,
        intensity: window(&images.intensity),
        line_integral: window(&images.line_integral),
        areal_density: window(&images.areal_density),
        bone_path: window(&images.bone_path),
        ..images.clone()
    };
    let first_pixel = case.pose.pixel(first[0] as f64, first[1] as f64);
    (Case { size, pose: DetectorPose { first_pixel, ..case.pose }, ..case.clone() }, part)
}

proptest! {
    #![proptest_config(scenes(32))]

    #[test]
    fn views_do_not_know_of_each_other(case in cases(ANY), aims in prop::collection::vec(aim(), 1..4)) {
        let other = |aim: &Aim| Case { pose: aim.at(case.index_to_world, case.dimensions, case.size), ..case.clone() };
        let views: Vec<ViewRequest> =
            aims.iter().map(other).chain([case.clone()]).map(|case| case.view()).collect();
        for &engine in case.engines() {
            let together = case.project_views(engine, &views);
            for (v, alone) in views.iter().enumerate() {
                identical(&view(&together, v), &case.project_views(engine, std::slice::from_ref(alone)))?;
            }
        }
    }

    /// Detectors of several tiles.
    #[test]
    fn threads_do_not_show(case in sized_cases(ANY, [80, 20])) {
        for &engine in case.engines() {
            let project = |threads: usize| {
                let context = Context::new(engine, threads).expect("threads start");
                run(&case.projector(&context, case.volume(calibration(1.0))), &[case.view()], Layers::ALL)
            };
            let one = project(1);
            for threads in [2, 3, 8] {
                identical(&project(threads), &one)?;
            }
        }
    }

    #[test]
    fn a_part_of_a_detector_sees_what_the_whole_sees(
        case in sized_cases(ANY, [80, 20]),
        [left, top, right, bottom] in prop::array::uniform4(0.0..1.0),
    ) {
        let case = Case { matrix: false, ..case };
        let range = |a: f64, b: f64, n: usize| {
            let first = (a * n as f64) as usize;
            (first, 1 + (b * (n - first - 1) as f64) as usize)
        };
        let ((i, width), (j, height)) = (range(left, right, case.size[0]), range(top, bottom, case.size[1]));
        for &engine in case.engines() {
            let (part, expected) = cut(&case, [i, j], [width, height], &case.project(engine));
            Tolerance::of(&part, engine).check(&part.project(engine), &expected)?;
        }
    }

    /// Where no coordinate is rounded the rays are the same to the last bit: voxels of powers of two, coordinates
    /// that are multiples of 2⁻¹⁰, and a source that is farther from the volume than every detector.
    #[test]
    fn tiles_do_not_show(
        case in sized_cases(ANY, [80, 20]),
        exponents in prop::array::uniform3(-2..3),
        [left, top] in prop::array::uniform2(0.0..1.0),
    ) {
        let spacing = DVec3::from_array(exponents.map(|e| f64::from(e).exp2()));
        let dyadic = |v: DVec3| (v * 1024.0).round() / 1024.0;
        let index_to_world = DAffine3 { matrix3: DMat3::from_diagonal(spacing), translation: DVec3::ZERO };
        let target = dyadic(0.5 * spacing * DVec3::from_array(case.dimensions.map(|n| n as f64)));
        let source = target + dyadic(1e4 * (case.pose.source - case.pose.first_pixel).normalize());
        let [width, height] = case.size.map(|n| (n / 2) as f64);
        let step = |v: DVec3| dyadic(v.normalize() * 0.2 + 0.01);
        let pose = DetectorPose {
            source,
            first_pixel: target - width * step(case.pose.column_step) - height * step(case.pose.row_step),
            column_step: step(case.pose.column_step),
            row_step: step(case.pose.row_step),
        };
        prop_assume!(pose.validate().is_ok());
        let case = Case { index_to_world, pose, matrix: false, ..case };
        let [i, j] = [(left * case.size[0] as f64) as usize, (top * case.size[1] as f64) as usize];
        for &engine in case.engines() {
            let size = [case.size[0] - i, case.size[1] - j];
            let (part, expected) = cut(&case, [i, j], size, &case.project(engine));
            // Rays that are swept together are rounded as their place on the detector says.
            if engine == Backend::Cpu && case.algorithm == Algorithm::Joseph {
                Tolerance::of(&part, engine).check(&part.project(engine), &expected)?;
            } else {
                identical(&part.project(engine), &expected)?;
            }
        }
    }

    #[test]
    fn layers_do_not_know_of_each_other(case in cases(ANY)) {
        for &engine in case.engines() {
            let project = |layers: Layers| {
                case.project_volume(engine, case.volume(calibration(1.0)), &[case.view()], layers)
            };
            let none = Layers::default();
            let single = Images {
                intensity: project(Layers { intensity: true, ..none }).intensity,
                line_integral: project(Layers { line_integral: true, ..none }).line_integral,
                areal_density: project(Layers { areal_density: true, ..none }).areal_density,
                ..project(Layers { bone_path: true, ..none })
            };
            identical(&single, &project(Layers::ALL))?;
        }
    }
}

/// A relation holds for nothing between nothing.
#[test]
fn most_scenes_see_their_volume() {
    let mut runner = TestRunner::new(scenes(1));
    let mut next = || sized_cases(ANY, [7, 5]).new_tree(&mut runner).expect("no filters").current();
    let seeing = (0..100).filter(|_| {
        let areal = next().project(Backend::Reference).areal_density;
        areal.iter().any(|&a| a > 0.0)
    });
    let seeing = seeing.count();
    assert!(seeing >= 80, "only {seeing} of 100");
}
