//! An engine's images beside those of the same algorithm in float64.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use drr::engine::{Backend, Images, Layers, SILENT};
use drr::volume::Volume;
use drr::{Algorithm, Method, Scene, ViewRequest};

use crate::support::{max_relative, projector, relative_l2};

const ALGORITHMS: [Algorithm; 7] = [
    Algorithm::Joseph,
    Algorithm::March { step: 1.0 },
    Algorithm::March { step: 0.5 },
    Algorithm::March { step: 0.37 },
    Algorithm::March { step: 2.7 },
    Algorithm::Siddon,
    Algorithm::DistanceDriven,
];

const KINDS: [Algorithm; 4] =
    [Algorithm::Joseph, Algorithm::March { step: 0.5 }, Algorithm::Siddon, Algorithm::DistanceDriven];

/// One of each kind that the engine has: without distance-driven means on GPUs.
pub(super) fn kinds(backend: Backend) -> &'static [Algorithm] {
    of_engine(backend, &KINDS)
}

/// Those that the engine has: the last one of the list is of the CPU only.
fn of_engine(backend: Backend, all: &[Algorithm]) -> &[Algorithm] {
    if backend == Backend::Cpu { all } else { &all[..all.len() - 1] }
}

/// What an engine may be off by.
struct Bounds {
    /// Relative L2 of a layer.
    l2: f64,
    /// Root mean square of the line integrals' errors beyond that: transmissions near 1 are rounded to 2⁻²⁴.
    floor: f64,
    /// Of a line integral p, relative and absolute.
    line_integral: [f64; 2],
    /// Relative error of areal densities above a twentieth of the largest.
    areal_density: f64,
}

impl Bounds {
    /// GPUs have no float64 to set rays up in.
    fn of(backend: Backend) -> Self {
        let l2 = if backend == Backend::Cpu { 4e-7 } else { 2e-6 };
        Self { l2, floor: 1e-7, line_integral: [2e-6, 1e-6], areal_density: 1e-5 }
    }
}

/// Holds every layer of `algorithms` to their twins.
pub(super) fn conforms_with(
    algorithms: &[Algorithm],
    backend: Backend,
    name: &str,
    volume: &Arc<Volume>,
    scene: &Scene,
    views: &[ViewRequest],
) {
    for &algorithm in algorithms {
        method_conforms(algorithm.into(), backend, name, volume, scene, views);
    }
}

/// Holds every layer to the twin of the method's algorithm.
pub(super) fn method_conforms(
    method: Method,
    backend: Backend,
    name: &str,
    volume: &Arc<Volume>,
    scene: &Scene,
    views: &[ViewRequest],
) {
    let layers = Layers { bone_path: scene.bone.is_some(), ..Layers::ALL };
    let projector = projector(backend, volume, Scene { method, ..scene.clone() });
    let fast = projector.project(views, layers, SILENT).expect("projects");
    let truth = projector.reference(method.algorithm, views, layers, SILENT).expect("projects");
    let name = format!("{method}, {name}");
    assert!(truth.areal_density.iter().any(|&areal| areal > 1e-3), "{name} sees nothing");
    compare(backend, method.algorithm, &name, &fast, &truth);
}

/// Holds every layer of every algorithm to its twin.
pub(super) fn conforms(
    backend: Backend,
    name: &str,
    volume: &Arc<Volume>,
    scene: &Scene,
    views: &[ViewRequest],
) {
    conforms_with(of_engine(backend, &ALGORITHMS), backend, name, volume, scene, views);
}

fn compare(backend: Backend, algorithm: Algorithm, name: &str, fast: &Images<f32>, truth: &Images<f64>) {
    let bounds = Bounds::of(backend);
    let hold = |what: usize, error: f64, bound: f64| {
        note(backend, algorithm, what, error / bound);
        assert!(error <= bound, "{name}: {}: {error:.2e} for {bound:.1e}", MEASURES[what]);
    };
    hold(0, relative_l2(&fast.intensity, &truth.intensity), bounds.l2);
    let size = truth.line_integral.iter().map(|p| p * p).sum::<f64>() / truth.line_integral.len() as f64;
    let floor = bounds.floor / size.sqrt();
    hold(1, relative_l2(&fast.line_integral, &truth.line_integral), bounds.l2 + floor);
    hold(2, relative_l2(&fast.areal_density, &truth.areal_density), bounds.l2);
    hold(3, relative_l2(&fast.bone_path, &truth.bone_path), bounds.l2);
    let [relative, absolute] = bounds.line_integral;
    let of_bound = |(&p, exact): (&f32, &f64)| (f64::from(p) - exact).abs() / (relative * exact + absolute);
    let each = fast.line_integral.iter().zip(&truth.line_integral).map(of_bound);
    hold(4, each.fold(0.0, worse), 1.0);
    let largest = truth.areal_density.iter().copied().fold(0.0, f64::max);
    let each = max_relative(&fast.areal_density, &truth.areal_density, 0.05 * largest);
    hold(5, each, bounds.areal_density);
}

/// The larger one; what is not a number is larger than any.
pub(super) fn worse(a: f64, b: f64) -> f64 {
    if a >= b { a } else { b }
}

/// What is measured: the first four are relative L2.
const MEASURES: [&str; 6] =
    ["intensity", "line integral", "areal density", "bone path", "each line integral", "each areal density"];

/// The largest part of each bound that was used, by engine and algorithm.
static USED: Mutex<BTreeMap<[&str; 2], [f64; MEASURES.len()]>> = Mutex::new(BTreeMap::new());

fn note(backend: Backend, algorithm: Algorithm, what: usize, part: f64) {
    let mut used = USED.lock().unwrap_or_else(PoisonError::into_inner);
    let most = used.entry([backend.name(), algorithm.name()]).or_default();
    most[what] = worse(most[what], part);
}

/// How much of the bounds was used, over all tests.
pub(super) fn print_used() {
    println!("most of a bound that was used");
    println!("engine  algorithm  {}", MEASURES.map(|measure| format!("{measure:>20}")).concat());
    for ([engine, algorithm], most) in USED.lock().unwrap_or_else(PoisonError::into_inner).iter() {
        println!("{engine:<7} {algorithm:<10} {}", most.map(|part| format!("{part:>20.3}")).concat());
    }
}
