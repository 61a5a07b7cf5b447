use std::sync::{Arc, Mutex};

use glam::DVec3;

use super::*;
use crate::context::Context;
use crate::effects::{Effects, Filter, FocalSpot, Implant, ImplantShape, Profile, Scatter};
use crate::engine::{Backend, Images, Job, Layers, SILENT, SignalsJob};
use crate::exposure::{Focus, March, RayCaster};
use crate::geometry::{DetectorPose, Grid, View};
use crate::method::Algorithm;
use crate::physics::{Calibration, Thresholds};
use crate::projector::ViewRequest;
use crate::scene::Scene;
use crate::volume::{Classification, Volume};

const SIZE: [usize; 2] = [5, 4];

const SIGNALS: Layers =
    Layers { intensity: true, line_integral: true, areal_density: false, bone_path: false };

/// What was asked of an engine: rays alone, or signals beside layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asked {
    Rays,
    Signals { layers: Layers, points: usize },
}

/// An engine for which a number passes from each point of the focal spot, and another without the volume.
struct Engine {
    from_point: fn(usize) -> f32,
    open: f32,
    asked: Mutex<Vec<Asked>>,
}

impl Engine {
    fn note(&self, asked: Asked) {
        self.asked.lock().expect("no test panics").push(asked);
    }
}

impl RayCaster<f32> for Engine {
    fn has_signals(&self) -> bool {
        true
    }

    fn cast(&self, job: &Job<'_>) -> Result<Images<f32>> {
        self.note(Asked::Rays);
        Images::of_layers(SIZE, job.views.len(), 4, 1, job.layers)
    }

    fn signals(&self, job: &SignalsJob<'_>) -> Result<Option<(Images<f32>, Passed)>> {
        self.note(Asked::Signals { layers: job.layers, points: job.views.len() });
        let (pixels, rows) = (SIZE[0] * SIZE[1], job.rows.len());
        let from = |point| vec![(self.from_point)(point); rows * pixels];
        let passing = (0..job.views.len()).flat_map(from).collect();
        let open = vec![self.open; if job.open { rows * pixels } else { 0 }];
        let images = Images::of_layers(SIZE, job.views.len(), 4, 1, job.layers)?;
        Ok(Some((images, Passed { passing, open })))
    }
}

fn scene(effects: Effects) -> Scene {
    Scene { effects, ..Scene::new(SIZE).expect("valid") }
}

fn pose() -> DetectorPose {
    DetectorPose::c_arm(DVec3::ZERO, 0.0, 500.0, 1000.0, 4.0, SIZE)
}

/// The images of a scene, and what was asked of the engine; `kept`: the rays are kept.
fn develop(scene: &Scene, engine: Engine, layers: Layers, kept: bool) -> (Images<f32>, Vec<Asked>) {
    let context = Context::new(Backend::Cpu, 1).expect("threads start");
    let grid = Grid::centred([6, 6, 6], DVec3::splat(20.0)).expect("valid");
    let classification = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT);
    let volume = Volume::from_int16(grid, &[0; 216], None, &classification.expect("built in"));
    let march = March {
        context: &context,
        volume: &Arc::new(volume.expect("valid")),
        asked: scene,
        scene,
        focus: Focus::Points,
        algorithm: Algorithm::Joseph,
        bone_path: layers.bone_path,
        developed: (!kept).then_some(layers),
        progress: SILENT,
    };
    let views: [ViewRequest; 1] = [View::Pose(pose()).into()];
    let exposure = march.expose_nth(&views, 0, &engine).expect("casts");
    let (images, _) = exposure.developed(scene, layers).expect("develops");
    (images, engine.asked.into_inner().expect("no test panics"))
}

fn sheet(scene: &Scene) -> Filter {
    Filter::named("copper", *scene.spectrum.grid(), Profile::Flat { mm: 0.1 }).expect("built in")
}

fn engine(from_point: fn(usize) -> f32, open: f32) -> Engine {
    Engine { from_point, open, asked: Mutex::default() }
}

/// By hand: the mean of what passes from the points, times all photons and the source's factor.
#[test]
fn points_are_averaged_and_the_source_s_factor_counts() {
    let plain = scene(Effects::default());
    let effects = Effects {
        fall_off: true,
        filters: vec![sheet(&plain)],
        focal_spot: Some(FocalSpot { width_mm: 10.0, height_mm: 0.0 }),
        ..Effects::default()
    };
    let scene = scene(effects);
    // A quarter from the first point, half from the others.
    let engine = engine(|point| if point == 0 { 0.25 } else { 0.5 }, 0.75);
    let (images, asked) = develop(&scene, engine, SIGNALS, false);
    let [Asked::Signals { points, .. }] = asked[..] else { panic!("{asked:?}") };
    assert!(points > 1);
    let mean = 0.5 - 0.25 / points as f64;
    let pose = pose();
    let normal = pose.column_step.cross(pose.row_step).normalize();
    for (n, &intensity) in images.intensity.iter().enumerate() {
        let [i, j] = [n % SIZE[0], n / SIZE[0]].map(|n| n as f64);
        let ray = pose.first_pixel + i * pose.column_step + j * pose.row_step - pose.source;
        let factor = (normal.dot(ray).abs() / ray.length()).powi(3);
        let expected = factor * scene.spectrum.total() * mean;
        assert!((f64::from(intensity) / expected - 1.0).abs() < 1e-6, "pixel {n}: {intensity}, {expected}");
    }
    let expected = -(mean / 0.75).ln() as f32;
    assert!(images.line_integral.iter().all(|p| (p - expected).abs() < 1e-6), "{:?}", images.line_integral);
}

#[test]
fn what_float32_does_not_hold_comes_as_its_logarithm() {
    let effects = Effects { fall_off: true, ..Effects::default() };
    let (images, _) = develop(&scene(effects), engine(|_| -250.0, f32::NAN), SIGNALS, false);
    assert!(images.line_integral.iter().all(|p| (p - 250.0).abs() < 1e-4), "{:?}", images.line_integral);
    assert!(images.intensity.iter().all(|&intensity| intensity == 0.0));
}

#[test]
fn an_engine_sums_unless_areal_densities_are_to_be_kept_or_changed() {
    let ask = |effects: Effects, layers, kept| {
        let (_, asked) = develop(&scene(effects), engine(|_| 1.0, 1.0), layers, kept);
        asked
    };
    let signals = |layers| Asked::Signals { layers, points: 1 };
    let even = || Effects { fall_off: true, ..Effects::default() };
    let silent = Layers::default();
    assert_eq!(ask(even(), SIGNALS, false), [signals(silent)]);
    assert_eq!(ask(even(), SIGNALS, true), [Asked::Rays]);
    let areal_density = Layers { areal_density: true, ..silent };
    assert_eq!(ask(even(), areal_density, false), [Asked::Rays]);
    let both = Layers { areal_density: true, bone_path: true, ..silent };
    assert_eq!(ask(even(), Layers { bone_path: true, ..both }, false), [Asked::Rays]);
    assert_eq!(ask(even(), Layers::ALL, false), [signals(both)]);
    let scatter = Some(Scatter { histories: 1000, seed: 1 });
    assert_eq!(ask(Effects { scatter, ..even() }, SIGNALS, false), [signals(areal_density)]);
    let shape = ImplantShape::Sphere { centre: DVec3::ZERO, radius: 5.0 };
    let implants = vec![Implant { shape, material: 3, density: 4.5 }];
    assert_eq!(ask(Effects { implants, ..even() }, SIGNALS, false), [Asked::Rays]);
}
