//! Every argument of every function, once not valid: refused by name, and the projector stays as it was.

use super::*;
use crate::parallel::MAX_STEPS;
use crate::scene::MAX_DETECTOR;

fn message<R>(result: Result<R>) -> String {
    result.err().expect("not valid").to_string()
}

#[test]
fn geometries_that_are_not_valid_are_refused() {
    let good = geometry();
    let context = Context::new(Backend::Cpu, 1).expect("threads");
    let values = volume(good.dimensions);
    let zero = DVec3::new(1.0, 0.0, 1.0);
    for (geometry, start) in [
        (ParallelGeometry { spacing: zero, ..good }, "spacing[1] is 0"),
        (ParallelGeometry { spacing: DVec3::new(1.0, 1.0, f64::NAN), ..good }, "spacing[2] is NaN"),
        (ParallelGeometry { spacing: -DVec3::ONE, ..good }, "spacing[0] is -1"),
        (ParallelGeometry { centre: DVec3::INFINITY, ..good }, "centre"),
        (ParallelGeometry { detector: [0, 13], ..good }, "detector columns is 0"),
        (ParallelGeometry { detector: [11, 0], ..good }, "detector rows is 0"),
        (ParallelGeometry { detector: [11, MAX_DETECTOR + 1], ..good }, "detector rows is "),
        (ParallelGeometry { pixel: [0.0, 1.0], ..good }, "pixel[0] is 0"),
        (ParallelGeometry { pixel: [1.0, f64::NAN], ..good }, "pixel[1] is NaN"),
        (ParallelGeometry { detector_centre: [f64::NAN, 0.0], ..good }, "detector_centre"),
        (ParallelGeometry { step: 0.0, ..good }, "step is 0"),
        (ParallelGeometry { step: f64::INFINITY, ..good }, "step is inf"),
        (ParallelGeometry { steps: 0, ..good }, "steps is 0"),
        (ParallelGeometry { steps: MAX_STEPS + 1, ..good }, "steps is "),
    ] {
        let refused = message(ParallelProjector::new(&context, geometry, Quadrature::Exact, &values));
        assert!(refused.starts_with(start), "{refused} | {start}");
    }
    let none = ParallelGeometry { dimensions: [0, 12, 10], ..good };
    assert!(ParallelProjector::<f64>::new(&context, none, Quadrature::Steps, &[]).is_err());
    let short = message(ParallelProjector::new(&context, good, Quadrature::Steps, &values[1..]));
    assert!(short.starts_with("volume's number of values is 1079"), "{short}");
    let mut bad = values;
    bad[9] = f64::NEG_INFINITY;
    let refused = message(ParallelProjector::new(&context, good, Quadrature::Steps, &bad));
    assert!(refused.starts_with("volume at voxel [0, 1, 0] is -inf"), "{refused}");
}

#[test]
fn parameters_that_are_not_finite_are_refused() {
    let projector = projector(Quadrature::Steps);
    let all = RaySelection::default();
    let measured = vec![1.0; 143];
    let before = projector.view_jacobian(&VIEW, all).expect("valid");
    for (k, name) in ["alpha", "beta", "phi", "dx", "dz"].into_iter().enumerate() {
        for value in [f64::NAN, f64::INFINITY] {
            let mut view = VIEW.to_array();
            view[k] = value;
            let view = ViewParameters::from_array(view);
            // A translation is refused as a whole.
            let start = if k < 3 { format!("{name} is {value}") } else { "translation is [".into() };
            for (refused, start) in [
                (message(projector.forward_project_view(&view, all)), start.clone()),
                (message(projector.view_jacobian(&view, all)), start.clone()),
                (message(projector.view_loss_value_and_grad(&view, &measured, all)), start.clone()),
                (message(projector.batch_forward_project(&[VIEW, view])), format!("views[1].{start}")),
                (message(projector.adjoint(&[view], &measured)), format!("views[0].{start}")),
            ] {
                assert!(refused.starts_with(&start), "{refused} | {start}");
            }
        }
    }
    assert_eq!(projector.view_jacobian(&VIEW, all).expect("valid"), before);
}

#[test]
fn rays_that_are_not_valid_are_refused() {
    let projector = projector(Quadrature::Steps);
    let measured = vec![1.0; 143];
    let before = projector.view_jacobian(&VIEW, RaySelection::default()).expect("valid");
    let lengths = |at: usize, length: [f64; 2]| {
        let mut lengths = vec![[-1.0, 1.0]; 143];
        lengths[at] = length;
        lengths
    };
    let [reversed, unknown] = [lengths(7, [1.0, 0.5]), lengths(8, [f64::NAN, 1.0])];
    let endless = lengths(9, [0.0, f64::INFINITY]);
    let (none, short) = (vec![false; 143], vec![true; 142]);
    for (mask, lengths, start) in [
        (Some(&none[..]), None, "mask is empty"),
        (Some(&short[..]), None, "mask's length is 142"),
        (None, Some(&reversed[1..]), "lengths' length is 142"),
        (None, Some(&reversed[..]), "lengths[7] is [1, 0.5]"),
        (None, Some(&unknown[..]), "lengths[8] is [NaN, 1]"),
        (None, Some(&endless[..]), "lengths[9] is [0, inf]"),
    ] {
        let rays = RaySelection { mask, lengths };
        for refused in [
            message(projector.forward_project_view(&VIEW, rays)),
            message(projector.view_jacobian(&VIEW, rays)),
            message(projector.view_loss_value_and_grad(&VIEW, &measured, rays)),
        ] {
            assert!(refused.starts_with(start), "{refused} | {start}");
        }
    }
    assert_eq!(projector.view_jacobian(&VIEW, RaySelection::default()).expect("valid"), before);
}

#[test]
fn measured_values_must_be_finite_where_rays_count() {
    let projector = projector(Quadrature::Steps);
    let mut measured = vec![1.0; 143];
    let loss = |measured: &[f64], mask: Option<&[bool]>| {
        projector.view_loss_value_and_grad(&VIEW, measured, RaySelection { mask, lengths: None })
    };
    let short = message(loss(&measured[1..], None));
    assert!(short.starts_with("measured's length is 142"), "{short}");
    let mut mask = vec![true; 143];
    mask[40] = false;
    let without = loss(&measured, Some(&mask)).expect("valid");
    measured[40] = f64::NAN;
    let refused = message(loss(&measured, None));
    assert!(refused.starts_with("measured[40] is NaN"), "{refused}");
    assert_eq!(loss(&measured, Some(&mask)).expect("masked"), without);
}

#[test]
fn images_to_project_back_must_be_as_many_as_the_views_and_finite() {
    let projector = projector(Quadrature::Steps);
    let mut images = vec![1.0; 2 * 143];
    let short = message(projector.adjoint(&[VIEW; 3], &images));
    assert!(short.starts_with("images' length is 286"), "{short}");
    images[150] = f64::NAN;
    let refused = message(projector.adjoint(&[VIEW; 2], &images));
    assert!(refused.starts_with("images[150] is NaN"), "{refused}");
    assert_eq!(projector.adjoint(&[], &[]).expect("no views"), vec![0.0; 1080]);
    assert_eq!(projector.batch_forward_project(&[]).expect("no views"), Vec::<f64>::new());
}
