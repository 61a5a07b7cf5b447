//! The specification's accuracy, against closed forms and against the exact integral of the interpolated field.
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::sync::Arc;

use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid};
use drr::phantom::Phantom;
use drr::volume::{Volume, VolumeBuilder};
use drr::{Algorithm, Scene};
use support::{classification, projector, relative_l2, requests};

const LINE_INTEGRAL: Layers =
    Layers { intensity: false, line_integral: true, areal_density: false, bone_path: false };

/// The phantom as a labelled int16 volume.
fn voxels(phantom: &Phantom, grid: Grid) -> Arc<Volume> {
    let mut builder = VolumeBuilder::int16(grid, &classification(), true).expect("memory");
    phantom.voxelise(&grid, |_, hu, labels| builder.push_int16(hu, Some(labels))).expect("axis-aligned");
    Arc::new(builder.finish().expect("complete"))
}

/// RMSE in HU, `1000 (p − p_exact)/p_exact`, over the stereo pair's rays whose chord is 100 mm or more and which keep
/// 10 mm from the cylinder's edges, spectrum on.
fn water_cylinder_rmse_hu(dimensions: [usize; 3], algorithm: Algorithm) -> f64 {
    let phantom = Phantom::water_cylinder();
    let grid = phantom.grid(dimensions).expect("valid");
    let size = [dimensions[0], dimensions[0]];
    let pair = DetectorPose::stereo_pair(&grid, 1000.0, 1500.0, 648.0 / size[0] as f64, size);
    let scene = Scene { method: algorithm.into(), ..Scene::new(size).expect("valid") };
    let spectral = scene.spectral_model().expect("valid");
    let images = projector(Backend::Cpu, &voxels(&phantom, grid), scene)
        .project(&requests(pair), LINE_INTEGRAL, SILENT)
        .expect("projects");
    let (mut squares, mut rays) = (0.0, 0);
    for (v, pose) in pair.iter().enumerate() {
        for (p, &got) in images.view(&images.line_integral, v).iter().enumerate() {
            let pixel = pose.pixel((p % size[0]) as f64, (p / size[0]) as f64);
            let direction = (pixel - pose.source).normalize();
            let across =
                direction.truncate().perp_dot(pose.source.truncate()).abs() / direction.truncate().length();
            let at_axis = pose.source + direction * 1000.0;
            let areal = phantom.areal_densities(pose.source, pixel, &|hu| 1.0 + f64::from(hu) / 1000.0, 4);
            let areal = areal.expect("four materials");
            if areal[2] >= 10.0 && across <= 90.0 && at_axis.z.abs() <= 110.0 {
                let exact = spectral.line_integral(&areal);
                squares += (1000.0 * (f64::from(got) / exact - 1.0)).powi(2);
                rays += 1;
            }
        }
    }
    assert!(rays > size[0] * size[0] / 10, "only {rays} rays");
    (squares / f64::from(rays as u32)).sqrt()
}

#[test]
fn the_water_cylinder_is_right_at_1_mm() {
    // Most of it is the voxel grid itself, in the outermost rays: 0.34 HU interpolating, 1.7 HU by Siddon.
    for (algorithm, bound) in
        [(Algorithm::Joseph, 0.4), (Algorithm::March { step: 0.5 }, 0.4), (Algorithm::Siddon, 2.2)]
    {
        let rmse = water_cylinder_rmse_hu([360, 360, 333], algorithm);
        println!("{algorithm:?}: {rmse:.3} HU");
        assert!(rmse <= bound, "{algorithm:?}: {rmse} HU");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; cargo test --release runs it")]
fn the_full_size_water_cylinder_is_within_half_a_hu() {
    for (algorithm, bound) in [(Algorithm::Joseph, 0.5), (Algorithm::Siddon, 2.0)] {
        let rmse = water_cylinder_rmse_hu([720, 720, 665], algorithm);
        println!("{algorithm:?}: {rmse:.3} HU");
        assert!(rmse <= bound, "{algorithm:?}: {rmse} HU");
    }
}

#[test]
fn finer_steps_converge_to_the_exact_integral() {
    let grid = support::awkward_grid([60, 52, 47]);
    let volume = support::volume(grid);
    let size = [36, 30];
    let views = requests(support::poses(&grid, size).into_iter().map(|(_, pose)| pose));
    let reference = projector(Backend::Reference, &volume, Scene::new(size).expect("valid"));
    let line_integrals = |algorithm| {
        reference.reference(algorithm, &views, LINE_INTEGRAL, SILENT).expect("projects").line_integral
    };
    let exact = line_integrals(Algorithm::Exact);
    let error = |algorithm| {
        let image: Vec<f32> = line_integrals(algorithm).iter().map(|&p| p as f32).collect();
        relative_l2(&image, &exact)
    };
    let errors: Vec<f64> =
        [1.0, 0.5, 0.25, 0.125].into_iter().map(|step| error(Algorithm::March { step })).collect();
    println!(
        "march {errors:?}, Joseph {:.1e}, Siddon {:.1e}",
        error(Algorithm::Joseph),
        error(Algorithm::Siddon)
    );
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.5 * pair[0], "halving the step gains too little: {errors:?}");
    }
    assert!(error(Algorithm::Joseph) < 2.0 * errors[0]);
}
