//! ⟨A x, b⟩ = ⟨x, Aᵀ b⟩.

use glam::DVec3;

use super::*;
use crate::engine::Backend;

/// Nothing is cubic, rays start and end outside, rows are no multiple of any vector, and there are more slabs of x than few
/// threads hold at once, the last one thin.
fn geometry() -> ParallelGeometry {
    let geometry = ParallelGeometry::new([45, 17, 39], DVec3::new(0.5, 1.3, 0.8), [13, 43], [2.1, 0.8]);
    ParallelGeometry { centre: DVec3::new(0.4, -3.0, 0.2), steps: 31, ..geometry }
}

/// Runs of rows about every axis, rows across lines of voxels, and samples in faces.
const VIEWS: [[f64; 5]; 6] = [
    [0.0; 5],
    [0.01, -0.02, 0.3, 0.33, -0.41],
    [-0.03, 0.01, 1.5, -2.0, 7.0],
    [0.02, 0.03, 3.9, 0.1, 0.2],
    [0.5, -0.4, 0.8, 0.5, 0.5],
    [1.5, 0.1, -0.2, 0.0, 0.0],
];

fn noise<T: Real>(count: usize, seed: usize) -> Vec<T> {
    let value = |n: usize| ((n * 7919 + seed * 104_729) % 10_007) as f64 / 10_007.0 - 0.5;
    (0..count).map(|n| T::of(value(n))).collect()
}

fn operator<T: Real>(threads: usize, quadrature: Quadrature, views: &[[f64; 5]]) -> ParallelOperator<T> {
    let context = Context::new(Backend::Cpu, threads).expect("threads");
    let views: Vec<_> = views.iter().map(|view| ViewParameters::from_array(*view)).collect();
    ParallelOperator::new(&context, geometry(), quadrature, &views).expect("valid")
}

fn dot<T: Real>(a: &[T], b: &[T]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| Into::<f64>::into(a) * Into::<f64>::into(b)).sum()
}

/// |⟨A x, b⟩ − ⟨x, Aᵀ b⟩| / (‖A x‖ ‖b‖).
fn mismatch<T: Real>(quadrature: Quadrature, views: &[[f64; 5]]) -> f64 {
    let operator = operator::<T>(2, quadrature, views);
    let [x, b] = [noise::<T>(operator.domain(), 1), noise::<T>(operator.range(), 2)];
    let [ax, ab] = [operator.forward(&x).expect("valid"), operator.adjoint(&b).expect("valid")];
    assert_eq!([ax.len(), ab.len()], [operator.range(), operator.domain()]);
    (dot(&ax, &b) - dot(&x, &ab)).abs() / (dot(&ax, &ax) * dot(&b, &b)).sqrt()
}

#[test]
fn the_adjoint_is_the_transpose() {
    for view in &VIEWS {
        for quadrature in [Quadrature::Steps, Quadrature::Exact] {
            let wide = mismatch::<f64>(quadrature, std::slice::from_ref(view));
            assert!(wide < 1e-14, "{quadrature:?}, {view:?}: {wide:e}");
            let narrow = mismatch::<f32>(quadrature, std::slice::from_ref(view));
            assert!(narrow < 1e-6, "{quadrature:?}, {view:?}: {narrow:e} in float32");
        }
    }
    assert!(mismatch::<f64>(Quadrature::Steps, &VIEWS) < 1e-14);
    assert!(mismatch::<f32>(Quadrature::Steps, &VIEWS) < 1e-6);
}

#[test]
fn float32_is_float64_to_its_rounding_voxel_by_voxel() {
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let wide = operator::<f64>(2, quadrature, &VIEWS);
        let wide = wide.adjoint(&noise(wide.range(), 3)).expect("valid");
        let narrow = operator::<f32>(2, quadrature, &VIEWS);
        let narrow = narrow.adjoint(&noise(narrow.range(), 3)).expect("valid");
        let most = wide.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let off = wide.iter().zip(&narrow).fold(0.0_f64, |most, (a, &b)| most.max((a - f64::from(b)).abs()));
        assert!(off < 2e-6 * most, "{quadrature:?}: {off:e} of {most:e}");
    }
}

#[test]
fn any_number_of_threads_makes_the_same_bytes() {
    let made = |threads: usize| {
        let narrow = operator::<f32>(threads, Quadrature::Steps, &VIEWS);
        let wide = operator::<f64>(threads, Quadrature::Exact, &VIEWS[1..3]);
        let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect::<Vec<_>>();
        let wide_bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        (
            bits(narrow.forward(&noise(narrow.domain(), 4)).expect("valid")),
            bits(narrow.adjoint(&noise(narrow.range(), 5)).expect("valid")),
            wide_bits(wide.adjoint(&noise(wide.range(), 6)).expect("valid")),
        )
    };
    let one = made(1);
    assert_eq!(one, made(2));
    assert_eq!(one, made(3));
}

#[test]
fn what_is_not_valid_is_refused_and_leaves_the_operator_as_it_was() {
    let operator = operator::<f64>(1, Quadrature::Steps, &VIEWS[..1]);
    let (x, b) = (noise(operator.domain(), 7), noise(operator.range(), 8));
    let before = (operator.forward(&x), operator.adjoint(&b));
    let mut bad = x.clone();
    bad[5] = f64::NAN;
    let error = operator.forward(&bad).expect_err("NaN").to_string();
    assert_eq!(error, "volume at voxel [5, 0, 0] is NaN; valid: finite values");
    assert!(operator.forward(&x[1..]).is_err());
    let mut bad = b.clone();
    bad[3] = f64::INFINITY;
    assert_eq!(operator.adjoint(&bad).expect_err("∞").to_string(), "images[3] is inf; valid: finite numbers");
    let error = operator.adjoint(&b[1..]).expect_err("short").to_string();
    assert_eq!(error, "images' length is 558; valid: 559, one per pixel of each view");
    assert_eq!((operator.forward(&x), operator.adjoint(&b)), before);
    let context = Context::new(Backend::Cpu, 1).expect("threads");
    let view = ViewParameters { alpha: f64::NAN, ..ViewParameters::default() };
    let refused = ParallelOperator::<f32>::new(&context, geometry(), Quadrature::Steps, &[view]);
    let message = refused.err().expect("NaN").to_string();
    assert!(message.starts_with("views[0].alpha is NaN"), "{message}");
    let none = ParallelOperator::<f32>::new(&context, geometry(), Quadrature::Steps, &[]);
    assert_eq!(none.err().expect("none").to_string(), "number of views is 0; valid: at least 1");
}
