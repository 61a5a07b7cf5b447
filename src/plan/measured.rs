//! A plan beside what its stages took.

use crate::exposure::StageTimes;
use crate::plan::{Plan, Stage};

impl Plan {
    /// The plan with what a projection of `views` views took, s, in all and stage by stage. Without stage times, as of a
    /// scene without effects, whose rays are summed where they are cast, all of it is the ray march's.
    #[must_use]
    pub fn with_measured(&self, times: &StageTimes, seconds: f64, views: usize) -> Self {
        let views = views.max(1) as f64;
        let mut plan = Self { measured_seconds: Some(seconds / views), ..self.clone() };
        let times = times.seconds();
        for stage in &mut plan.stages {
            let own = times.iter().filter(|(name, _)| stage_of(name).contains(&stage.name));
            let own: Vec<f64> = own.map(|(_, seconds)| seconds / views).collect();
            stage.measured_seconds = match stage.name {
                "ray march" if times.is_empty() => plan.measured_seconds,
                _ if own.is_empty() => None,
                _ => Some(own.iter().sum()),
            };
        }
        plan
    }
}

/// The plan's stage, by one of its names, that a stage of a development belongs to.
fn stage_of(development: &str) -> &'static [&'static str] {
    match development {
        "ray march" => &["ray march"],
        "energies" => &["spectrum", "attenuate"],
        "focal spot" => &["focal spot"],
        "scatter kernels" | "scatter" => &["scatter"],
        "detector blur" => &["detector blur"],
        "pixels" => &["pixels", "supersampling"],
        "noise" => &["noise"],
        _ => &[],
    }
}

impl Stage {
    /// Its times in words.
    pub(super) fn time(&self) -> String {
        let predicted = self.seconds.map(|s| format!(", about {}", seconds(s)));
        let measured = self.measured_seconds.map(|s| format!(", measured {}", seconds(s)));
        predicted.into_iter().chain(measured).collect()
    }
}

/// Three digits.
fn seconds(seconds: f64) -> String {
    match seconds {
        ..1e-3 => format!("{:.3} ms", 1e3 * seconds),
        ..1.0 => format!("{:.1} ms", 1e3 * seconds),
        _ => format!("{seconds:.2} s"),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::effects::{DetectorBlur, Effects};
    use crate::engine::Backend;
    use crate::scene::Scene;
    use crate::volume::{Classification, Volume};

    #[test]
    fn every_time_stands_beside_its_stage() {
        let grid = crate::geometry::Grid::centred([3, 1, 1], glam::DVec3::ONE).expect("valid");
        let how =
            Classification::named(crate::physics::Calibration::DEFAULT, crate::physics::Thresholds::DEFAULT);
        let volume = Volume::from_int16(grid, &[0, 40, 900], None, &how.expect("built in")).expect("valid");
        let blur = DetectorBlur::gaussians(&[(1.0, 0.3)]).expect("valid");
        let effects = Effects { detector_blur: Some(blur), ..Effects::default() };
        let scene = Scene { effects, ..Scene::new([8, 8]).expect("valid") };
        let plan = Plan::new(&scene, &volume, Backend::Cpu, None).expect("valid");
        let times = StageTimes::default();
        for (name, ms) in [("ray march", 400), ("energies", 80), ("detector blur", 20)] {
            times.add(name, Duration::from_millis(ms));
        }
        let seconds = |plan: &Plan, name: &str| {
            plan.stages.iter().find(|s| s.name == name).and_then(|s| s.measured_seconds)
        };
        let measured = plan.with_measured(&times, 0.52, 2);
        for (name, expected) in [("ray march", 0.2), ("spectrum", 0.04), ("detector blur", 0.01)] {
            assert!((seconds(&measured, name).expect(name) - expected).abs() < 1e-12, "{name}");
        }
        assert!(measured.to_string().contains("measured 10.0 ms"), "{measured}");
        let whole = plan.with_measured(&StageTimes::default(), 0.5, 1);
        assert_eq!((seconds(&whole, "ray march"), seconds(&whole, "spectrum")), (Some(0.5), None));
    }
}
