//! Functions that make no handle, or that make a context.

use drr::capi::context::{DRR_BACKEND_REFERENCE, DrrContextOptions, drr_context_create, drr_context_destroy};
use drr::capi::geometry::{DrrDetectorPose, drr_pose_c_arm, drr_uniforms_cone};
use drr::capi::physics::{drr_physics_detector, drr_physics_mass_attenuation, drr_physics_spectrum};
use drr::shared::ProjectionUniforms;

use super::call::{made, succeeded};
use super::input::Input;
use super::memory::{How, Place};

/// Threads of a context that is accepted: starting more takes longer than all other calls.
const MOST_THREADS: u32 = 2;

/// A built-in table with any name, energies and place.
pub(super) fn tables(input: &mut Input<'_>) {
    let function = input.one_of(&[drr_physics_spectrum, drr_physics_mass_attenuation, drr_physics_detector]);
    let built_in = [c"W120_2p5Al", c"water", c"top_energy", c"", c"W120"];
    let mut name = input.one_of(&built_in).to_bytes_with_nul().to_vec();
    if input.seldom() {
        for byte in &mut name {
            *byte = input.byte();
        }
        name.push(0);
    }
    let count = input.count(136, 0..137);
    let (first, step) = (input.number(15.0), input.number(1.0));
    // Of a number that is refused no array can be made.
    let mut place = Place::<f32>::new(How::of(input), if count <= 4096 { count } else { 1 });
    let name = if input.byte() < 250 { name.as_ptr().cast() } else { std::ptr::null() };
    // SAFETY: the name ends in NUL or is NULL; the place is as long as is said, or the number is refused.
    if succeeded(unsafe { function(name, first, step, count, place.pointer()) }) {
        assert_eq!(place.written().len(), count);
        assert!(place.written().iter().all(|&value| value.is_finite() && value >= 0.0));
    } else {
        place.assert_untouched();
    }
}

/// A pose by six numbers, and its uniforms.
pub(super) fn geometry(input: &mut Input<'_>) {
    let centre = [0; 3].map(|_| input.number(0.0));
    let [width, height] = [0; 2].map(|_| input.count(64, 0..100));
    let number = [6.0, 1000.0, 1500.0, 1.0].map(|ordinary| input.number(ordinary));
    let untouched = DrrDetectorPose {
        source: [1.0; 3],
        first_pixel: [2.0; 3],
        column_step: [3.0; 3],
        row_step: [4.0; 3],
    };
    let mut pose = untouched;
    let (how_centre, how_pose) = (How::of(input), How::of(input));
    let place = how_pose.pass((&raw mut pose).cast_const()).cast_mut();
    let [angle, axis, detector, pixel] = number;
    let centre = how_centre.pass(centre.as_ptr());
    // SAFETY: three numbers and a place for one struct, or pointers that are refused.
    if !succeeded(unsafe { drr_pose_c_arm(centre, angle, axis, detector, pixel, width, height, place) }) {
        assert_eq!(pose, untouched, "written by a call that failed");
        return;
    }
    let vectors = [pose.source, pose.first_pixel, pose.column_step, pose.row_step];
    assert!(vectors.as_flattened().iter().all(|x| x.is_finite()), "{pose:?}");
    if input.seldom() {
        pose.row_step.iter_mut().for_each(|x| *x = input.number(*x));
    }
    let mut uniforms = std::mem::MaybeUninit::<ProjectionUniforms>::zeroed();
    // SAFETY: one struct to read, a place for the other; all zeros are a value.
    let uniforms = unsafe {
        let done = drr_uniforms_cone(
            &raw const pose,
            width,
            height,
            How::of(input).pass(uniforms.as_mut_ptr().cast_const()).cast_mut(),
        );
        (succeeded(done), uniforms.assume_init_mut())
    };
    let numbers = uniforms.1.modelViewProjectionMatrix.columns;
    assert!(numbers.as_flattened().iter().all(|x| x.is_finite() && (uniforms.0 || *x == 0.0)), "{numbers:?}");
}

/// A context with any options; few threads where they would be started.
pub(super) fn context(input: &mut Input<'_>) {
    let threads = input.code(u32::MAX);
    let mut options = DrrContextOptions {
        struct_size: input.count(size_of::<DrrContextOptions>(), 0..40),
        backend: input.code(DRR_BACKEND_REFERENCE),
        thread_count: if threads > 1024 { threads } else { threads.clamp(1, MOST_THREADS) },
        metal_device: std::ptr::null_mut(),
        device_index: 0,
        timings: std::ptr::null(),
    };
    let how = How::of(input);
    options.device_index = input.count(0, 0..4);
    if options.backend == DRR_BACKEND_REFERENCE && input.seldom() {
        // No device, which an engine of the CPU refuses without a look at it.
        options.metal_device = std::ptr::dangling_mut();
    }
    let given = how.pass(&raw const options);
    if given.is_null() {
        return; // one thread per core
    }
    // SAFETY: a struct of the right size or one that is refused, and a place for the handle.
    if let Some(context) = made(|context| unsafe { drr_context_create(given, context) }) {
        // SAFETY: live, and not used again.
        assert!(succeeded(unsafe { drr_context_destroy(context) }));
    }
}
