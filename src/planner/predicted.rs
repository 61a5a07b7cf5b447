//! How long each stage of a plan takes, by rates and what there is to do.

use crate::context::Context;
use crate::effects::{DetectorBlur, FocalSpot};
use crate::error::Result;
use crate::exposure::{Focus, Source, beamline, pose_of};
use crate::geometry::View;
use crate::plan::Plan;
use crate::planner::{Effort, StageRate, expected};
use crate::scene::Scene;
use crate::volume::Volume;

/// Most views that are looked at.
const MOST_VIEWS: usize = 4;

/// The plan with the predicted seconds of its stages, per view, a mean over some of the expected views. The path through
/// bone, and scatter's kernels, made once, are not predicted, and nothing is of views that do not suit the scene's effects.
pub(super) fn with_seconds(plan: Plan, context: &Context, volume: &Volume, scene: &Scene) -> Plan {
    let seconds = seconds(&plan, context, volume, scene).unwrap_or_default();
    let mut plan = plan;
    for (stage, seconds) in plan.stages.iter_mut().zip(seconds) {
        stage.seconds = seconds;
    }
    plan
}

fn seconds(plan: &Plan, context: &Context, volume: &Volume, scene: &Scene) -> Result<Vec<Option<f64>>> {
    let views = expected::views(scene, volume);
    let few: Vec<View> = views.iter().step_by(views.len().div_ceil(MOST_VIEWS)).copied().collect();
    let effort = Effort::new(&few, volume.grid(), scene)?;
    let of_one = |sum: f64| sum / few.len() as f64;
    let effort =
        Effort { rays: of_one(effort.rays), slices: of_one(effort.slices), voxels: of_one(effort.voxels) };
    let scene = Scene { effects: plan.effects.clone(), ..scene.clone() };
    let work = Work::new(plan, &scene, volume, context, &few[0], effort)?;
    plan.stages.iter().map(|stage| work.seconds(stage.name)).collect()
}

/// What there is to do for one view.
struct Work<'a> {
    plan: &'a Plan,
    scene: &'a Scene,
    context: &'a Context,
    effort: Effort,
    view: &'a View,
    volume: &'a Volume,
    /// Points of the focal spot that rays are cast from.
    points: f64,
    /// Sums over energies of one ray.
    sums: f64,
    /// 2 where the open field is summed as well, because pixels differ in it.
    fields: f64,
}

impl<'a> Work<'a> {
    fn new(
        plan: &'a Plan,
        scene: &'a Scene,
        volume: &'a Volume,
        context: &'a Context,
        view: &'a View,
        effort: Effort,
    ) -> Result<Self> {
        let points = plan.focal_points() as f64;
        let (mut sums, mut fields) = (1.0, 1.0);
        if scene.has_effects() {
            let source = Source::new(scene, view, scene.detector)?;
            let noisy = scene.effects.noise.as_ref().is_some_and(|noise| noise.quantum);
            sums = source.channels(scene, noisy)?.count() as f64;
            fields = if source.is_even() { 1.0 } else { 2.0 };
        }
        Ok(Self { plan, scene, context, effort, view, volume, points, sums, fields })
    }

    /// Predicted seconds of a stage; `None` where nothing is known of it.
    fn seconds(&self, stage: &str) -> Result<Option<f64>> {
        let (rays, effects) = (self.effort.rays, &self.scene.effects);
        let planes = rays * self.sums * self.fields;
        Ok(Some(match stage {
            "ray march" => self.points * self.of_method(0),
            "spectrum" | "attenuate" if !self.scene.has_effects() => {
                let few = self.plan.quadrature.as_ref().map(|few| few.nodes().len());
                self.of_method(few.unwrap_or(self.plan.energy_bins)) - self.of_method(0)
            }
            "spectrum" | "attenuate" => {
                // In an open field of one spectrum nothing is in the way.
                let before = effects.filters.len() + effects.heel.iter().count();
                let rays = rays * (self.points + if before > 0 { 1.0 } else { 0.0 });
                let materials = (self.plan.materials.len() + before) as f64;
                let of_energy = self.of(StageRate::Energy)
                    + materials * self.of(StageRate::Material)
                    + self.sums * self.of(StageRate::Sum);
                rays * self.plan.energy_bins as f64 * of_energy
            }
            "source" => {
                let parts =
                    usize::from(effects.fall_off) + effects.heel.iter().count() + effects.filters.len();
                rays * parts as f64 * self.of(StageRate::Source)
            }
            "implants" => self.points * rays * effects.implants.len() as f64 * self.of(StageRate::Implant),
            "focal spot" => {
                let weights = effects.focal_spot.as_ref().filter(|_| self.is_convolved());
                let weights = weights.map_or(Ok(None), |spot| self.spot_weights(spot).map(Some))?;
                let Some(weights) = weights else { return Ok(None) };
                rays * self.sums * weights * self.of(StageRate::Weight)
            }
            "scatter" => self.sums * (rays * self.of(StageRate::Scatter) + self.of(StageRate::ScatterCells)),
            "detector blur" => {
                let weights =
                    effects.detector_blur.as_ref().map_or(Ok(0.0), |blur| self.blur_weights(blur))?;
                planes * weights * self.of(StageRate::Weight)
            }
            "pixels" | "supersampling" if self.scene.has_effects() => planes * self.of(StageRate::Pixel),
            "noise" => {
                let pixels = self.scene.detector.into_iter().product::<usize>() * self.scene.layers();
                pixels as f64 * self.of(StageRate::Noise)
            }
            _ => return Ok(None),
        }))
    }

    /// Seconds of the engine's rays with a sum over so many energies.
    fn of_method(&self, energies: usize) -> f64 {
        self.context.costs().seconds(self.context, self.plan.method, &self.effort, energies)
    }

    /// Seconds of one of a stage's things, on the threads there are.
    fn of(&self, rate: StageRate) -> f64 {
        let ns = self.context.costs().stage_ns(self.context.backend(), rate);
        1e-9 * ns / self.context.threads() as f64
    }

    fn is_convolved(&self) -> bool {
        self.plan.focus.as_ref().is_some_and(|choice| choice.focus == Focus::Convolved)
    }

    /// Distances of neighbouring rays on the detector, mm.
    fn pitch(&self, effect: &str) -> Result<[f64; 2]> {
        let pose = pose_of(self.view, effect)?;
        let n = self.scene.supersampling as f64;
        Ok([pose.column_step, pose.row_step].map(|step| step.length() / n))
    }

    fn spot_weights(&self, spot: &FocalSpot) -> Result<f64> {
        let effect = "scene.effects.focal_spot";
        let at = beamline(pose_of(self.view, effect)?, self.volume.grid());
        let taps = spot.taps(at.source_detector_mm, at.source_centre_mm, self.pitch(effect)?)?;
        Ok(taps.iter().map(|taps| 1.0 + taps.side().len() as f64).sum())
    }

    fn blur_weights(&self, blur: &DetectorBlur) -> Result<f64> {
        let kernels = blur.kernels(self.pitch("scene.effects.detector_blur")?)?;
        Ok(kernels.iter().flat_map(|(_, taps)| taps).map(|taps| 1.0 + taps.side().len() as f64).sum())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::effects::Effects;
    use crate::engine::Backend;
    use crate::geometry::{DetectorPose, Grid};
    use crate::physics::{Calibration, Thresholds};
    use crate::planner;
    use crate::volume::Classification;

    fn volume() -> Arc<Volume> {
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
        let grid = Grid::centred([4, 4, 4], DVec3::splat(10.0)).expect("valid");
        Arc::new(Volume::from_int16(grid, &[40; 64], None, &how).expect("valid"))
    }

    fn scene(side: usize, pixel: f64) -> Scene {
        let pose = DetectorPose::c_arm(DVec3::ZERO, 0.0, 500.0, 800.0, pixel, [side; 2]);
        Scene { expected_views: vec![View::Pose(pose)], ..Scene::new([side; 2]).expect("valid") }
    }

    fn seconds(threads: usize, scene: &Scene, stage: &str) -> Option<f64> {
        let context = Context::new(Backend::Cpu, threads).expect("valid");
        let plan = planner::plan(&context, &volume(), scene).expect("valid");
        plan.stages.iter().find(|s| s.name == stage).expect(stage).seconds
    }

    #[test]
    fn four_times_the_rays_take_four_times_as_long_and_two_threads_half_of_it() {
        let blur = DetectorBlur::gaussians(&[(1.0, 4.0)]).expect("valid");
        let effects = Effects { fall_off: true, detector_blur: Some(blur), ..Effects::default() };
        let [one, four] = [(40, 2.0), (80, 1.0)]
            .map(|(side, pixel)| Scene { effects: effects.clone(), ..scene(side, pixel) });
        for stage in ["ray march", "spectrum", "source"] {
            let [t1, t4] = [&one, &four].map(|scene| seconds(1, scene, stage).expect(stage));
            assert!((t4 / t1 - 4.0).abs() < 0.1, "{stage}: {t1} {t4}");
            assert!((seconds(2, &one, stage).expect(stage) / t1 - 0.5).abs() < 1e-9, "{stage}");
        }
        // Twice the weights as well: 12 and 23 along each axis.
        let [t1, t4] = [&one, &four].map(|scene| seconds(1, scene, "detector blur").expect("known"));
        assert!((t4 / t1 - 4.0 * 23.0 / 12.0).abs() < 1e-6, "{t1} {t4}");
    }

    #[test]
    fn a_timings_file_decides_and_what_it_lacks_is_built_in() {
        let fall_off = Scene { effects: Effects { fall_off: true, ..Effects::default() }, ..scene(40, 2.0) };
        let built_in = seconds(1, &fall_off, "source").expect("known");
        let costs = crate::planner::Costs::default().to_json();
        let slow = costs.replace("\"part before the volume\": 45.0", "\"part before the volume\": 90.0");
        assert_ne!(slow, costs);
        let none = r#"{"name": "n", "engines": {"cpu": {"sample_ns": {}, "ray_ns": 1, "energy_ns": 1}}}"#;
        for (text, factor) in [(slow.as_str(), 2.0), (none, 1.0)] {
            let context = Context::new(Backend::Cpu, 1).expect("valid");
            let context = context.with_costs(crate::planner::Costs::from_json(text).expect("valid"));
            let plan = planner::plan(&context, &volume(), &fall_off).expect("valid");
            let source = plan.stages.iter().find(|s| s.name == "source").and_then(|s| s.seconds);
            assert!((source.expect("known") / built_in - factor).abs() < 1e-9, "{factor}");
        }
        let known = crate::planner::Costs::default();
        for rate in StageRate::ALL {
            assert!(known.stage_ns(Backend::Metal, rate) > 0.0, "{}", rate.name());
        }
    }

    #[test]
    fn what_the_views_do_not_suit_has_no_time() {
        let blur = DetectorBlur::gaussians(&[(1.0, 4.0)]).expect("valid");
        let effects = Effects { detector_blur: Some(blur), ..Effects::default() };
        let scene = Scene { effects, ..scene(40, 2.0) };
        let View::Pose(pose) = scene.expected_views[0] else { panic!("a pose") };
        let matrix = crate::geometry::Projection::from_pose(&pose, [40; 2]).expect("valid");
        let scene = Scene { expected_views: vec![View::Projection(matrix)], ..scene };
        assert_eq!(seconds(1, &scene, "detector blur"), None);
    }
}
