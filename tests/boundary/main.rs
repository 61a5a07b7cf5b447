//! The C ABI called as a C program calls it, but from Rust: small enough that Miri, which sees every wrong access, can
//! interpret it: `cargo +nightly miri test --no-default-features --test boundary`, with the `MIRIFLAGS` that rayon's
//! queues need, which `.ci/run` has.
#![allow(missing_docs, reason = "a test program")]
#![allow(unsafe_code, reason = "calls the C ABI")]

mod derivatives;
mod given;

use std::ptr::{null, null_mut};

use drr::capi::context::*;
use drr::capi::effects::*;
use drr::capi::exposure::*;
use drr::capi::filter::*;
use drr::capi::implant::*;
use drr::capi::outputs::*;
use drr::capi::physics::*;
use drr::capi::projector::*;
use drr::capi::scene::*;
use drr::capi::version::*;
use drr::capi::volume::*;
use drr::capi::volume_file::*;
use drr::shared::{DrrBool, ProjectionUniforms};
use given::*;

#[test]
fn every_algorithm_writes_every_image_on_one_thread_and_on_two() {
    let [one, two] = [1, 2].map(|threads| {
        let context = context(DRR_BACKEND_CPU, threads);
        let volume = float32_labelled(context);
        let images = [DRR_ALGORITHM_JOSEPH, DRR_ALGORITHM_MARCH, DRR_ALGORITHM_SIDDON].map(|algorithm| {
            let projector = projector(volume, &scene(algorithm));
            let images = Images::of_poses(projector);
            if threads == 1 {
                let reference = Images::of_reference(projector, algorithm);
                assert_close(&images.intensity, &reference.intensity);
                assert_close(&images.line_integral, &reference.line_integral);
                assert_close(&images.areal_density, &reference.areal_density);
                assert_close(&images.bone_path_mm, &reference.bone_path_mm);
            }
            assert!(images.bone_path_mm.iter().any(|&mm| mm > 0.5));
            destroy(projector, null_mut(), null_mut());
            images
        });
        destroy(null_mut(), volume, context);
        images
    });
    assert_eq!(one, two);
}

/// Miri's one volume of int16: tables of 65536 entries take Miri as long as all other tests together.
#[test]
fn voxels_of_int16_are_those_of_float32() {
    let context = context(DRR_BACKEND_CPU, 1);
    // Without the bone path, whose table is another of the size.
    let scene = DrrScene { effects: DRR_EFFECT_POLYENERGETIC, ..scene(DRR_ALGORITHM_SIDDON) };
    let [coded, dense] = [int16_labelled, float32_labelled].map(|make| {
        let volume = make(context);
        let projector = projector(volume, &scene);
        let mut images = Images::filled(f32::NAN);
        let (poses, outputs) = (poses(), DrrOutputs { bone_path_mm: null_mut(), ..images.places() });
        // SAFETY: a live projector, poses and images of its size.
        ok(unsafe { drr_projector_project_poses(projector, poses.as_ptr(), VIEWS, &raw const outputs) });
        destroy(projector, volume, null_mut());
        images
    });
    let densities = coded.areal_density.iter().zip(dense.areal_density);
    assert!(densities.clone().all(|(a, b)| (a - b).abs() <= 1e-6 * b), "{coded:?} {dense:?}");
    assert!(densities.clone().any(|(a, _)| *a > 0.1));
    assert!(coded.bone_path_mm.iter().all(|mm| mm.is_nan()), "not asked for");
    destroy(null_mut(), null_mut(), context);
}

#[test]
fn views_bring_their_own_tables_and_exit_early() {
    let context = context(DRR_BACKEND_AUTO, 2);
    let volume = float32_labelled(context);
    let projector = projector(volume, &scene(DRR_ALGORITHM_JOSEPH));
    let plain = Images::of_uniforms(projector, &uniforms());

    let spectrum = SPECTRUM.map(|weight| 2.0 * weight).to_vec();
    let opaque = ATTENUATION.map(|mu| 1e4 * mu).to_vec();
    let own = uniforms().map(|view| ProjectionUniforms {
        spectrumLutAddress: spectrum.as_ptr().expose_provenance() as u64,
        muLutAddress: opaque.as_ptr().expose_provenance() as u64,
        // What C may leave in a bool.
        enableEarlyExit: DrrBool(2),
        ..view
    });
    let dark = Images::of_uniforms(projector, &own);
    assert_eq!(dark.areal_density, plain.areal_density, "the layer forbids the exit");

    let mut intensity = [f32::NAN; PIXELS];
    let outputs = DrrOutputs { intensity: intensity.as_mut_ptr(), ..initialised(drr_outputs_init) };
    // SAFETY: a live projector, views whose tables live, one image of its size.
    ok(unsafe { drr_projector_project(projector, own.as_ptr(), VIEWS, &raw const outputs) });
    for (stopped, full) in intensity.iter().zip(dark.intensity) {
        assert!((stopped - full).abs() <= 2.0 * (-15.0_f32).exp(), "{stopped} and {full}");
    }
    assert!(plain.intensity.iter().zip(intensity).any(|(bright, dark)| dark < 0.5 * bright));
    drop((spectrum, opaque));
    destroy(projector, volume, context);
}

#[test]
fn the_reference_engine_integrates_exactly() {
    let context = context(DRR_BACKEND_REFERENCE, 1);
    let volume = float32_labelled(context);
    let projector = projector(volume, &scene(DRR_ALGORITHM_EXACT));
    let images = Images::of_poses(projector);
    assert_close(&images.areal_density, &Images::of_reference(projector, DRR_ALGORITHM_EXACT).areal_density);
    // SAFETY: the string lives as long as the projector.
    let plan = text(unsafe { drr_projector_describe(projector) });
    assert!(plan.contains("exact"), "{plan}");
    destroy(projector, volume, context);
}

#[test]
fn a_failing_call_writes_nothing_and_says_why() {
    let context = context(DRR_BACKEND_CPU, 1);
    let volume = float32_labelled(context);
    let projector = projector(volume, &scene(DRR_ALGORITHM_SIDDON));
    let mut images = Images::filled(42.0_f32);
    let (good, views, outputs) = (poses(), uniforms(), images.places());
    let mut bad = good;
    bad[1].source[2] = f64::NAN;
    let lut = [1.0_f32, f32::NAN];
    let mut bad_views = views;
    bad_views[1].spectrumLutAddress = lut.as_ptr().expose_provenance() as u64;
    let mut askew_views = views;
    askew_views[0].muLutAddress = lut.as_ptr().expose_provenance() as u64 + 1;
    let odd = outputs.intensity.wrapping_byte_add(1);
    let misaligned = DrrOutputs { intensity: odd, ..outputs };
    let older = DrrOutputs { struct_size: 8, ..outputs };
    let mut place = null_mut();
    let (hu, mut labels, mut descriptor) = (HU.map(f32::from), LABELS, descriptor());
    labels[11] = 8;
    // SAFETY: live handles, or pointers that are refused before anything is read behind them.
    unsafe {
        let project = |poses, count, outputs| drr_projector_project_poses(projector, poses, count, outputs);
        refused(project(null(), VIEWS, &raw const outputs), "poses is NULL");
        refused(project(good.as_ptr(), 0, &raw const outputs), "view_count is 0");
        refused(project(good.as_ptr(), usize::MAX, &raw const outputs), "view_count is");
        refused(project(bad.as_ptr(), VIEWS, &raw const outputs), "poses[1].source is");
        refused(project(good.as_ptr(), VIEWS, null()), "outputs is NULL");
        refused(project(good.as_ptr(), VIEWS, &raw const misaligned), "outputs.intensity is 0x");
        refused(project(good.as_ptr(), VIEWS, &raw const older), "outputs.struct_size is 8");
        let project = |views| drr_projector_project(projector, views, VIEWS, &raw const outputs);
        refused(project(bad_views.as_ptr()), "views[1].spectrumLutAddress[1] is NaN");
        refused(project(askew_views.as_ptr()), "views[0].muLutAddress is 0x");
        refused(project(views.as_ptr().wrapping_byte_add(4)), "views is 0x");
        let of_volume = volume.cast_const().cast::<DrrProjector>();
        let status = drr_projector_project_poses(of_volume, good.as_ptr(), VIEWS, &raw const outputs);
        refused(status, "projector is no such handle");
        assert!(drr_projector_describe(null()).is_null());
        let mut create = |hu, labels| {
            drr_volume_create_float32(context, &raw const descriptor, hu, labels, &raw mut place)
        };
        refused(create(hu.as_ptr(), labels.as_ptr()), "labels at voxel [2, 1, 1] is 8");
        let load = drr_volume_load(context, null(), &raw mut descriptor, &raw mut place);
        refused(load, "path is NULL");
        refused(drr_context_destroy(volume.cast()), "context is no such handle");
        refused(drr_context_options_init(null_mut()), "options is NULL");
    }
    assert!(place.is_null());
    assert_eq!(images, Images::filled(42.0));
    let other = std::thread::spawn(message).join().expect("does not panic");
    assert_eq!(other, "", "each thread has its own");
    Images::of_poses(projector);
    assert!(message().contains("options is NULL"), "a success leaves the message: {}", message());
    destroy(projector, volume, context);
}

#[test]
fn handles_go_in_any_order() {
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        let context = context(DRR_BACKEND_CPU, 1);
        let volume = float32_labelled(context);
        let projector = projector(volume, &scene(DRR_ALGORITHM_JOSEPH));
        for handle in order {
            match handle {
                0 => destroy(null_mut(), null_mut(), context),
                1 => destroy(null_mut(), volume, null_mut()),
                _ => {
                    // Alive though what it was made from may be gone.
                    if order[2] == 2 {
                        Images::of_poses(projector);
                    }
                    destroy(projector, null_mut(), null_mut());
                }
            }
        }
    }
}

#[test]
fn one_projector_serves_two_threads() {
    struct Shared(*const DrrProjector);
    // SAFETY: a projector is immutable, and the header lets any number of threads use one.
    unsafe impl Sync for Shared {}

    let context = context(DRR_BACKEND_CPU, 2);
    let volume = float32_labelled(context);
    let projector = projector(volume, &scene(DRR_ALGORITHM_SIDDON));
    let shared = &Shared(projector);
    let expected = Images::of_poses(shared.0);
    std::thread::scope(|threads| {
        for _ in 0..2 {
            threads.spawn(|| assert_eq!(Images::of_poses({ shared }.0), expected));
        }
    });
    destroy(projector, volume, context);
}

/// Every array that a scene points to, and a handle that outlives what it was made from. Built-in tables stay out of it.
#[test]
fn a_scene_with_effects_is_exposed_and_developed() {
    let ones = [1.0_f32; ENERGIES];
    let (angles, thicknesses) = ([-20.0, 20.0], [1.0, 2.0]);
    let bow_tie = DrrFilter {
        material: null(),
        mass_attenuation: ones.as_ptr(),
        density: 1.0,
        thickness_mm: f64::NAN,
        angles_degrees: angles.as_ptr(),
        thicknesses_mm: thicknesses.as_ptr(),
        point_count: 2,
    };
    let sections = [DrrScrewSection { length_mm: 0.5, radius_mm: 0.25 }; 2];
    let screw = DrrImplant {
        shape: DRR_IMPLANT_SCREW,
        material: 3,
        density: 4.5,
        position: [1.0, 0.5, 0.5],
        axes: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        radius_mm: f64::NAN,
        sections: sections.as_ptr(),
        section_count: 2,
    };
    let (frequencies, mtf) = ([0.0, 0.1, 0.2], [1.0, 0.9, 0.7]);
    let scene = DrrScene {
        second_detector_response: ones.as_ptr(),
        second_detector_efficiency: ones.as_ptr(),
        filters: &raw const bow_tie,
        filter_count: 1,
        implants: &raw const screw,
        implant_count: 1,
        mtf_frequencies_per_mm: frequencies.as_ptr(),
        mtf: mtf.as_ptr(),
        mtf_count: 3,
        photons_per_pixel: 100.0,
        effects: DRR_EFFECT_POLYENERGETIC | DRR_EFFECT_FALL_OFF | DRR_EFFECT_QUANTUM_NOISE,
        ..scene(DRR_ALGORITHM_SIDDON)
    };
    let context = context(DRR_BACKEND_CPU, 2);
    let volume = float32_labelled(context);
    let projector = projector(volume, &scene);
    let (poses, mut exposure) = (poses(), null_mut());
    let mut images = [[f32::NAN; 2 * PIXELS]; 3];
    let outputs = images
        .each_mut()
        .map(|image| DrrOutputs { intensity: image.as_mut_ptr(), ..initialised(drr_outputs_init) });
    // SAFETY: live handles, as many poses and places for images as are said, a scene whose arrays live.
    unsafe {
        ok(drr_projector_project_poses(projector, poses.as_ptr(), VIEWS, &raw const outputs[0]));
        let silent = (None, null_mut());
        ok(drr_exposure_create_poses(
            projector,
            poses.as_ptr(),
            VIEWS,
            silent.0,
            silent.1,
            &raw mut exposure,
        ));
        destroy(projector, volume, context);
        ok(drr_exposure_develop(exposure, null(), &raw const outputs[1]));
        ok(drr_exposure_develop(exposure, &raw const scene, &raw const outputs[2]));
        let other = DrrScene { implant_count: 0, ..scene };
        refused(
            drr_exposure_develop(exposure, &raw const other, &raw const outputs[2]),
            "scene.implant_count is 0",
        );
        let other = DrrScene { implants: null(), ..scene };
        refused(
            drr_exposure_develop(exposure, &raw const other, &raw const outputs[2]),
            "scene.implants is another",
        );
        ok(drr_exposure_destroy(exposure));
        ok(drr_exposure_destroy(null_mut()));
    }
    assert_eq!(images[0], images[1]);
    assert_eq!(images[0], images[2]);
    assert!(images[0].iter().all(|value| value.is_finite()), "{images:?}");
}

/// Of a table that is not parsed, which Miri would take long for.
#[test]
fn a_built_in_table_is_copied_to_the_caller() {
    let mut factors = [f32::NAN; 3];
    let place = (&raw mut factors).cast::<f32>();
    // SAFETY: names that end in NUL or are null, a place for more numbers than are asked for.
    unsafe {
        refused(drr_physics_detector(c"\xff".as_ptr(), 60.0, 10.0, 2, place), "name is");
        refused(drr_physics_spectrum(null(), 60.0, 10.0, 2, place), "name is NULL");
        refused(drr_physics_mass_attenuation(c"".as_ptr(), 60.0, 10.0, 0, place), "energy_count is 0");
        assert!(factors.iter().all(|factor| factor.is_nan()));
        ok(drr_physics_detector(c"ideal".as_ptr(), 60.0, 10.0, 2, place));
    }
    assert!(factors[..2] == [1.0, 1.0] && factors[2].is_nan(), "{factors:?}");
    assert!(!text(drr_version()).is_empty() && drr_version_number() > 0);
}
