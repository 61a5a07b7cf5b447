use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::error::Error;
use crate::geometry::{DetectorPose, Grid, View};
use crate::method::Algorithm;
use crate::physics::{Calibration, Thresholds};
use crate::volume::Classification;

/// Blocks of tissue, bone and air, eight voxels a side.
fn blocks(dimensions: [usize; 3]) -> Arc<Volume> {
    let grid = Grid::centred(dimensions, DVec3::splat(2.0)).expect("valid");
    let hu = |n: usize| {
        let at = [n % dimensions[0], n / dimensions[0] % dimensions[1], n / dimensions[0] / dimensions[1]];
        [40, 900, -1000, -700, 60][at.map(|i| i / 8).iter().sum::<usize>() % 5]
    };
    let hu: Vec<i16> = (0..grid.voxel_count()).map(hu).collect();
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    Arc::new(Volume::from_int16(grid, &hu, None, &how).expect("valid"))
}

fn context() -> Context {
    Context::new(Backend::Cpu, 2).expect("threads start")
}

fn scene(hu: f64) -> Scene {
    Scene { tolerance: Some(Tolerance::hu(hu)), ..Scene::new([24, 20]).expect("valid") }
}

fn plan_of(hu: f64) -> Plan {
    plan(&context(), &blocks([40, 32, 24]), &scene(hu)).expect("planned")
}

#[test]
fn what_is_cheaper_misses_the_tolerance_and_what_is_dearer_is_not_measured() {
    for hu in [1.0, 10.0, 100.0] {
        let plan = plan_of(hu);
        let choice = plan.choice.as_ref().expect("a tolerance leads to a choice");
        let chosen = choice.candidates.iter().position(|c| c.verdict == Verdict::Chosen).expect("one");
        let (cheaper, dearer) = (&choice.candidates[..chosen], &choice.candidates[chosen + 1..]);
        assert!(choice.candidates.is_sorted_by(|a, b| a.seconds <= b.seconds));
        assert!(cheaper.iter().all(|c| c.hu.is_some_and(|error| error.rms_high > hu)), "{choice}");
        assert!(dearer.iter().all(|c| c.verdict == Verdict::NotMeasured && c.hu.is_none()), "{choice}");
        assert!(choice.candidates[chosen].hu.is_some_and(|error| error.rms_high <= hu), "{choice}");
        assert_eq!(plan.method, choice.candidates[chosen].method);
    }
}

#[test]
fn more_tolerance_never_costs_more() {
    let seconds = |hu| plan_of(hu).choice.and_then(|choice| choice.chosen().map(|c| c.seconds));
    let all: Vec<_> = [0.5, 2.0, 8.0, 32.0, 128.0].map(seconds).into_iter().collect();
    assert!(all.is_sorted_by(|less, more| less >= more), "{all:?}");
}

/// Where one march is cheaper than anything else.
fn with_cheap_march(step: f64) -> Context {
    let kind = Method::from(Algorithm::March { step }).to_string();
    let rates = Rates {
        sample_ns: [(kind, 0.0), ("joseph".into(), 1.0)].into(),
        ray_ns: 0.0,
        energy_ns: 0.0,
        stage_ns: [].into(),
    };
    context().with_costs(Costs::new("a joke", Backend::Cpu, rates))
}

#[test]
fn edges_are_kept_in_place_where_that_is_asked_for() {
    let (context, volume) = (with_cheap_march(8.0), blocks([40, 32, 24]));
    let coarse = plan(&context, &volume, &scene(1000.0)).expect("planned");
    let mm = |plan: &Plan| plan.choice.as_ref().and_then(|c| c.chosen()?.mm).expect("measured").rms_high;
    let tolerance = Tolerance { hu: 1000.0, mm: 0.2 * mm(&coarse) };
    let strict = Scene { tolerance: Some(tolerance), ..scene(1.0) };
    let strict = plan(&context, &volume, &strict).expect("planned");
    assert!(mm(&strict) <= tolerance.mm && strict.method != coarse.method, "{:?}", strict.choice);
}

#[test]
fn what_cannot_be_had_is_refused_with_what_can() {
    for volume in [blocks([40, 32, 24]), blocks([4, 3, 2])] {
        let error = plan(&context(), &volume, &scene(1e-9)).expect_err("nothing is that good");
        let Error::InvalidArgument { argument, valid, .. } = error else { panic!("{error}") };
        assert_eq!(argument, "scene.tolerance");
        let reached: f64 = valid.split_whitespace().nth(2).and_then(|hu| hu.parse().ok()).expect("a number");
        assert!(reached > 1e-9 && plan(&context(), &volume, &scene(reached)).is_ok(), "{valid}");
    }
}

#[test]
fn the_same_scene_is_planned_once() {
    let (context, volume) = (context(), blocks([40, 32, 24]));
    let first = plan(&context, &volume, &scene(5.0)).expect("planned");
    let made = std::cell::Cell::new(0);
    let again = |volume: &Arc<Volume>, scene: &Scene| {
        let make = || {
            made.set(made.get() + 1);
            Ok(first.clone())
        };
        context.plans().get_or_make(volume, scene, make).expect("planned")
    };
    assert_eq!(again(&volume, &scene(5.0)), first);
    assert_eq!(made.get(), 0, "it is remembered");
    again(&blocks([40, 32, 24]), &scene(5.0));
    again(&volume, &scene(6.0));
    assert_eq!(made.get(), 2, "another volume and another scene are not the same");
}

#[test]
fn plans_do_not_change_from_time_to_time_or_with_threads() {
    let volume = blocks([40, 32, 24]);
    let plans = [1, 2, 5].map(|threads| {
        let context = Context::new(Backend::Cpu, threads).expect("threads start");
        let plan = plan(&context, &volume, &scene(3.0)).expect("planned");
        (plan.method, plan.quadrature, plan.choice.and_then(|choice| choice.chosen().and_then(|c| c.hu)))
    });
    assert_eq!(plans[0], plans[1]);
    assert_eq!(plans[0], plans[2]);
}

#[test]
fn the_costs_decide_which_is_cheapest() {
    let volume = blocks([40, 32, 24]);
    let free =
        |step: f64| plan(&with_cheap_march(step), &volume, &scene(500.0)).expect("planned").method.algorithm;
    for step in [1.0, 0.25] {
        assert_eq!(free(step), Algorithm::March { step });
    }
}

#[test]
fn a_method_beside_a_tolerance_is_not_looked_at() {
    let stated = Scene { method: Algorithm::Exact.into(), ..scene(5.0) };
    let planned = plan(&context(), &blocks([40, 32, 24]), &stated).expect("planned");
    assert_eq!(planned.method, plan_of(5.0).method);
}

#[test]
fn where_nothing_is_met_nothing_is_said_to_be_kept() {
    let far = DetectorPose::c_arm(DVec3::new(1e4, 0.0, 0.0), 0.0, 1000.0, 1500.0, 1.0, [24, 20]);
    let scene = Scene { expected_views: vec![View::Pose(far)], ..scene(0.1) };
    let choice = plan(&context(), &blocks([40, 32, 24]), &scene).expect("planned").choice.expect("a choice");
    assert!(choice.candidates.iter().all(|c| c.verdict != Verdict::Chosen && c.hu.is_none()), "{choice}");
    assert_eq!(choice.chosen().map(|c| c.method.algorithm), Some(Algorithm::Joseph));
}

#[test]
fn one_view_of_many_that_sees_the_most_error_is_not_overlooked() {
    let volume = blocks([40, 32, 24]);
    let at = |angle| View::Pose(DetectorPose::c_arm(DVec3::ZERO, angle, 1000.0, 1500.0, 6.0, [24, 20]));
    let far = View::Pose(DetectorPose::c_arm(DVec3::new(1e4, 0.0, 0.0), 0.0, 1000.0, 1500.0, 1.0, [24, 20]));
    let mut views = vec![far; 40];
    views.push(at(45.0));
    let seen = |views: Vec<View>| {
        let plan =
            plan(&context(), &volume, &Scene { expected_views: views, ..scene(3.0) }).expect("planned");
        plan.choice.and_then(|choice| choice.chosen()?.hu).expect("measured").rms
    };
    let (among_many, alone) = (seen(views), seen(vec![at(45.0)]));
    assert!((among_many / alone - 1.0).abs() < 0.5, "{among_many} and {alone}");
}

#[test]
fn few_energies_are_planned_for_the_expected_views() {
    let volume = blocks([40, 32, 24]);
    let far = DetectorPose::c_arm(DVec3::new(1e4, 0.0, 0.0), 0.0, 1000.0, 1500.0, 1.0, [24, 20]);
    let method = Method { energies: Energies::Few { hu: 0.1 }, ..Algorithm::Joseph.into() };
    let scene = Scene { method, ..Scene::new([24, 20]).expect("valid") };
    let around = plan(&context(), &volume, &scene).expect("planned");
    assert!(around.quadrature.is_some_and(|few| few.nodes().len() < 15 && few.bound() <= 1e-4));
    let beside = Scene { expected_views: vec![View::Pose(far)], ..scene };
    let beside = plan(&context(), &volume, &beside).expect("planned");
    assert!(beside.quadrature.is_none(), "rays that meet nothing need no energies");
}
