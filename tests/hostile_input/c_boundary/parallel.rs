//! Parallel beams: geometry, volume, one view of it and the view's loss by any numbers.

use drr::capi::context::DrrContext;
use drr::capi::parallel::{
    DrrParallel, drr_parallel_adjoint, drr_parallel_create, drr_parallel_destroy,
    drr_parallel_forward_project_view, drr_parallel_view_loss_value_and_grad,
};
use drr::capi::parallel_geometry::DrrParallelGeometry;

use super::call::{made, succeeded};
use super::input::Input;
use super::memory::{How, Place};

/// By which an input says that its end is about a parallel beam.
pub(super) const MARK: u8 = 0xda;
/// How many bytes of it.
pub(super) const BYTES: usize = 256;
/// Most voxels, and samples of an image, so that an input takes milliseconds.
const MOST_WORK: usize = 1 << 14;

fn geometry(input: &mut Input<'_>) -> DrrParallelGeometry {
    DrrParallelGeometry {
        struct_size: input.count(size_of::<DrrParallelGeometry>(), 0..160),
        dimensions: [4, 3, 5].map(|n| input.count(n, 1..8)),
        spacing: [1.0, 2.0, 0.5].map(|mm| input.number(mm)),
        centre: [0; 3].map(|_| input.number(0.0)),
        detector_columns: input.count(3, 1..8),
        detector_rows: input.count(4, 1..8),
        pixel: [1.0, 0.75].map(|mm| input.number(mm)),
        detector_centre: [0; 2].map(|_| input.number(0.0)),
        step: input.number(0.0),
        steps: input.code(0),
        quadrature: input.code(0),
    }
}

/// Number of voxels, if it and the samples of an image are few, or such as are refused before anything is read.
fn few(geometry: &DrrParallelGeometry) -> Option<usize> {
    let product = |numbers: &[usize]| numbers.iter().fold(1_usize, |product, &n| product.saturating_mul(n));
    let voxels = product(&geometry.dimensions);
    let height = geometry.dimensions[1] as f64 * geometry.spacing[1];
    let steps = match (geometry.steps, geometry.step) {
        (0, 0.0) => geometry.dimensions[1],
        (0, step) => (height / step).min(1e9) as usize,
        (steps, _) => steps as usize,
    };
    let samples = product(&[geometry.detector_columns, geometry.detector_rows, steps]);
    (voxels <= MOST_WORK && samples <= MOST_WORK).then_some(voxels)
}

/// Whether an image was made.
pub(super) fn check(input: &mut Input<'_>, context: *const DrrContext) -> bool {
    let geometry = geometry(input);
    let Some(voxels) = few(&geometry) else { return false };
    let mut volume: Vec<_> = (0..voxels).map(|n| n as f32 * 0.25).collect();
    if input.seldom() {
        volume.iter_mut().take(1).for_each(|value| *value = input.number(1.0).clamp(-1e6, 1e6) as f32);
    }
    let (how_geometry, how_volume) = (How::of(input), How::of(input));
    let (geometry_place, values) = (how_geometry.pass(&raw const geometry), how_volume.pass(volume.as_ptr()));
    // SAFETY: a live context; a struct and as many voxels as it says, or pointers that are refused.
    let parallel = made(|place| unsafe { drr_parallel_create(context, geometry_place, values, place) });
    let Some(parallel) = parallel else { return false };
    let passed = view(input, parallel, &geometry);
    // SAFETY: live, and not used again.
    assert!(succeeded(unsafe { drr_parallel_destroy(parallel) }));
    passed
}

/// An image, its loss beside itself, which is 0, and its back-projection.
fn view(input: &mut Input<'_>, parallel: *const DrrParallel, geometry: &DrrParallelGeometry) -> bool {
    let pixels = geometry.detector_columns * geometry.detector_rows;
    let parameters = [0.1, -0.2, 0.3, 0.5, -0.5].map(|value| input.number(value));
    let mask: Vec<_> = (0..pixels).map(|_| 255 - input.byte()).collect();
    let lengths: Vec<_> = (0..pixels).flat_map(|_| [input.number(-100.0), input.number(100.0)]).collect();
    let hows = [0; 3].map(|_| How::of(input));
    let mut image = Place::<f32>::new(How::of(input), pixels);
    let (values, bytes) = (hows[0].pass(parameters.as_ptr()), mask.as_ptr());
    let ends = hows[2].pass(lengths.as_ptr());
    // SAFETY: a live handle; as many numbers as are said, or pointers that are refused.
    if !succeeded(unsafe {
        drr_parallel_forward_project_view(parallel, values, bytes, ends, image.pointer())
    }) {
        image.assert_untouched();
        return false;
    }
    assert!(image.written().iter().all(|value| value.is_finite()), "{:?}", image.written());
    let mut sums =
        [Place::<f64>::new(How::Good, 1), Place::new(How::Good, 5), Place::new(How::of(input), 25)];
    let [loss, gradient, hessian] = sums.each_mut().map(Place::pointer);
    let measured = image.written().as_ptr();
    // SAFETY: as above.
    let done = succeeded(unsafe {
        drr_parallel_view_loss_value_and_grad(
            parallel, values, measured, bytes, ends, loss, gradient, hessian,
        )
    });
    if done {
        assert!(sums.iter().flat_map(Place::written).all(|value| value.is_finite()), "{parameters:?}");
    } else {
        sums.iter().for_each(Place::assert_untouched);
    }
    let mut back = Place::<f32>::new(How::of(input), geometry.dimensions.iter().product());
    let count = usize::from(!input.seldom());
    // SAFETY: as above; one image, or none that is looked at.
    if !succeeded(unsafe { drr_parallel_adjoint(parallel, values, count, measured, back.pointer()) }) {
        back.assert_untouched();
    }
    back.written().iter().all(|value| value.is_finite())
}
