//! The C functions with any arguments that the header allows to be passed: pointers are good, NULL, misaligned, or
//! another type's handle; numbers are anything. A call succeeds with images that physics allows, or fails without a
//! trace.
#![allow(unsafe_code, reason = "calls the C ABI")]

mod call;
mod effects;
mod exposure;
mod images;
mod input;
mod memory;
mod parallel;
mod raycast;
mod scene;
mod small;
mod views;
mod volume;

use drr::capi::context::{
    DRR_BACKEND_CPU, DRR_BACKEND_REFERENCE, DrrContext, DrrContextOptions, drr_context_create,
    drr_context_options_init,
};
use drr::capi::projector::{drr_projector_describe, drr_projector_destroy};
use drr::capi::volume::drr_volume_destroy;

use call::{made, succeeded};
use input::Input;

thread_local! {
    /// One per engine, used for every input.
    static CONTEXTS: [*mut DrrContext; 2] = [DRR_BACKEND_CPU, DRR_BACKEND_REFERENCE].map(context);
}

fn context(backend: u32) -> *mut DrrContext {
    let mut options = DrrContextOptions {
        struct_size: 0,
        backend: 0,
        thread_count: 0,
        metal_device: std::ptr::null_mut(),
        device_index: 0,
        timings: std::ptr::null(),
    };
    // SAFETY: places for the structs and the handle are there.
    unsafe {
        assert!(succeeded(drr_context_options_init(&raw mut options)));
        (options.backend, options.thread_count) = (backend, 1);
        made(|context| drr_context_create(&raw const options, context)).expect("a context")
    }
}

/// Whether a volume and its projector were accepted, and images made.
pub(crate) fn check(bytes: &[u8]) -> bool {
    let mut input = Input::new(bytes);
    if let Some(mut end) = input.end(parallel::MARK, parallel::BYTES) {
        return parallel::check(&mut end, CONTEXTS.with(|contexts| contexts[0]));
    }
    if let Some(mut end) = input.end(raycast::MARK, raycast::BYTES) {
        return raycast::check(&mut end, CONTEXTS.with(|contexts| contexts[0]));
    }
    match input.byte() {
        ..224 => return pipeline(&mut input),
        224..240 => small::geometry(&mut input),
        240..250 => small::tables(&mut input),
        250.. => small::context(&mut input),
    }
    false
}

/// A volume, a projector, images.
fn pipeline(input: &mut Input<'_>) -> bool {
    let on_reference = input.seldom();
    let context = CONTEXTS.with(|contexts| contexts[usize::from(on_reference)]);
    let Some((volume, grid)) = volume::make(input, context) else { return false };
    let mut made_images = false;
    if let Some((projector, scene)) = scene::make(input, context, volume) {
        // SAFETY: the handle is live, and the string lives as long.
        let plan = unsafe { std::ffi::CStr::from_ptr(drr_projector_describe(projector)) };
        assert!(plan.to_str().is_ok_and(|plan| plan.starts_with('{')), "a plan in JSON");
        exposure::develop(input, projector, &scene, &grid);
        made_images = images::project(input, projector, &scene, &grid);
        // SAFETY: the handle is live and not used again.
        assert!(succeeded(unsafe { drr_projector_destroy(projector) }));
    }
    // SAFETY: as above.
    assert!(succeeded(unsafe { drr_volume_destroy(volume) }));
    made_images
}
