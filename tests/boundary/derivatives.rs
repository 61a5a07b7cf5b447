//! The differentiable projectors and the ray transform.

use std::ptr::{null, null_mut};

use drr::capi::context::*;
use drr::capi::parallel::*;
use drr::capi::parallel_f64::*;
use drr::capi::parallel_geometry::*;
use drr::capi::pose_gradient::*;
use drr::capi::ray_transform::*;
use drr::capi::scene::*;

use crate::given::*;

#[test]
fn a_parallel_view_fills_image_derivatives_and_sums() {
    let context = context(DRR_BACKEND_CPU, 2);
    let geometry = DrrParallelGeometry {
        dimensions: DIMENSIONS,
        detector_columns: SIZE[0],
        detector_rows: SIZE[1],
        ..initialised(drr_parallel_geometry_init)
    };
    let (field, parameters) = (HU.map(f32::from), [0.1, -0.2, 0.3, 0.25, -0.5]);
    let (mask, lengths) = ([0_u8, 7, 255, 1], [-0.5, 10.0].repeat(4));
    let (mut image, mut jacobian) = ([f32::NAN; 4], [f32::NAN; 20]);
    let (mut loss, mut gradient, mut hessian) = (f64::NAN, [f64::NAN; 5], [f64::NAN; 25]);
    let mut parallel = null_mut();
    // SAFETY: live handles, arrays of the sizes that the geometry says, places of the sizes that are documented.
    unsafe {
        ok(drr_parallel_create(context, &raw const geometry, field.as_ptr(), &raw mut parallel));
        let views = (parameters.as_ptr(), mask.as_ptr(), lengths.as_ptr());
        let (image_place, jacobian_place) = (image.as_mut_ptr(), jacobian.as_mut_ptr());
        ok(drr_parallel_view_jacobian(parallel, views.0, views.1, views.2, image_place, jacobian_place));
        let dark = [0.0_f32; 4];
        let measured = dark.as_ptr();
        let places = (&raw mut loss, gradient.as_mut_ptr(), hessian.as_mut_ptr());
        ok(drr_parallel_view_loss_value_and_grad(
            parallel, views.0, measured, views.1, views.2, places.0, places.1, places.2,
        ));
        let twin = parallel.cast::<DrrParallelF64>();
        refused(drr_parallel_destroy_f64(twin), "parallel is no such handle");
        ok(drr_parallel_destroy(parallel));
    }
    assert!(image[0] == 0.0 && image[1..].iter().all(|&value| value != 0.0), "{image:?}");
    let half: f64 = image.iter().map(|&value| 0.5 * f64::from(value).powi(2)).sum();
    assert!((loss - half).abs() <= 1e-6 * half, "{loss} and {half}");
    for n in 0..5 {
        let sum: f64 = (0..4).map(|i| f64::from(jacobian[4 * n + i]) * f64::from(image[i])).sum();
        assert!(
            (gradient[n] - sum).abs() <= 1e-5 * (1.0 + hessian[6 * n].sqrt() * (2.0 * half).sqrt()),
            "{n}"
        );
    }
    destroy(null_mut(), null_mut(), context);
}

#[test]
fn a_ray_transform_and_its_adjoint_fill_their_places() {
    let context = context(DRR_BACKEND_CPU, 2);
    let (descriptor, poses, field) = (descriptor(), poses(), HU.map(f32::from));
    let (mut images, mut back) = ([f32::NAN; PIXELS], [f32::NAN; VOXELS]);
    let mut transform = null_mut();
    // SAFETY: live handles, as many poses, voxels and pixels as are said.
    unsafe {
        ok(drr_ray_transform_create(
            context,
            &raw const descriptor,
            poses.as_ptr(),
            VIEWS,
            SIZE[0],
            SIZE[1],
            DRR_ALGORITHM_SIDDON,
            0.0,
            &raw mut transform,
        ));
        destroy(null_mut(), null_mut(), context);
        ok(drr_ray_transform_forward(transform, field.as_ptr(), images.as_mut_ptr()));
        ok(drr_ray_transform_adjoint(transform, images.as_ptr(), back.as_mut_ptr()));
        ok(drr_ray_transform_destroy(transform));
    }
    let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
    let (one, other) = (dot(&images, &images), dot(&field, &back));
    assert!(one > 0.0 && (one - other).abs() <= 1e-5 * one, "{one} and {other}");
}

#[test]
fn a_pose_gradient_fills_six_planes() {
    let context = context(DRR_BACKEND_CPU, 1);
    let volume = float32_labelled(context);
    let (scene, poses, parameters) = (scene(DRR_ALGORITHM_JOSEPH), poses(), [0.0_f64; 6]);
    let (mut image, mut jacobian) = ([f32::NAN; PIXELS / VIEWS], [f32::NAN; 6 * PIXELS / VIEWS]);
    let mut pose_gradient = null_mut();
    // SAFETY: live handles, one pose, six parameters, places for one image and six planes.
    unsafe {
        ok(drr_pose_gradient_create(volume, &raw const scene, null(), &raw mut pose_gradient));
        destroy(null_mut(), volume, context);
        let (pose, signal) = (poses.as_ptr(), DRR_SIGNAL_LINE_INTEGRAL);
        let places = (image.as_mut_ptr(), jacobian.as_mut_ptr());
        ok(drr_pose_gradient_jacobian(pose_gradient, pose, parameters.as_ptr(), signal, places.0, places.1));
        ok(drr_pose_gradient_destroy(pose_gradient));
    }
    assert!(image.iter().any(|&value| value > 0.0) && jacobian.iter().all(|value| value.is_finite()));
    assert!(jacobian.iter().any(|&value| value != 0.0), "{jacobian:?}");
}
