//! The stages of a plan, and what it leaves out.

use serde::Serialize;

use crate::engine::Backend;
use crate::method::{Algorithm, Energies};
use crate::plan::{Plan, effects, signal};
use crate::scene::Scene;
use crate::volume::Volume;

/// Something that runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stage {
    /// Short name.
    pub name: &'static str,
    /// Whether it only runs for a call that asks for its layer.
    pub on_request: bool,
    /// What it computes, with its parameters.
    pub what: String,
    /// Why the scene calls for it.
    pub reason: String,
    /// An upper bound of its work per view, counted, not timed.
    pub cost: String,
    /// Predicted time per view, s, where rates are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// What it took per view, s, where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured_seconds: Option<f64>,
    /// How far its result can be from the exact one, and against what.
    pub error: String,
}

impl Stage {
    /// Whether it is there because of the scene's effects.
    pub fn is_effect(&self) -> bool {
        effects::NAMES.contains(&self.name)
    }
}

/// Something that does not run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Omission {
    /// Short name.
    pub name: String,
    /// Why nothing is lost.
    pub reason: String,
}

pub(super) fn stages(plan: &Plan, scene: &Scene, volume: &Volume) -> Vec<Stage> {
    let rays = plan.rays_per_view();
    let cast = rays * plan.focal_points();
    let mut stages = vec![march(plan, cast), signal::stage(plan, scene, cast)];
    stages.extend(effects::stages(plan, scene));
    if plan.supersampling > 1 && plan.effects.fill_factor.is_none() {
        stages.push(Stage {
            name: "supersampling",
            on_request: false,
            what: format!("mean of the {0}×{0} rays of a pixel", plan.supersampling),
            reason: "the scene asks for it".into(),
            cost: format!("{rays} additions per layer"),
            error: "point sampling of the pixel's area".into(),
            seconds: None,
            measured_seconds: None,
        });
    }
    if let Some(bone) = scene.bone.filter(|&bone| volume.materials()[usize::from(bone)].labelled) {
        stages.push(Stage {
            name: "bone path",
            on_request: true,
            what: format!("length in mm through voxels labelled {bone}, by Siddon's lengths"),
            reason: "a call may ask for the bone_path layer".into(),
            cost: format!("at most {} voxel reads", rays * 3 * longest(plan)),
            error: "exact for voxels of constant label".into(),
            seconds: None,
            measured_seconds: None,
        });
    }
    stages
}

fn march(plan: &Plan, rays: usize) -> Stage {
    let what = match plan.method.algorithm {
        Algorithm::Joseph => "Joseph: one bilinear sample per slice of the driving axis".into(),
        Algorithm::March { step } => format!("trilinear march, step {step} voxels along the driving axis"),
        Algorithm::Siddon => "Siddon: exact lengths through constant voxels".into(),
        Algorithm::DistanceDriven => {
            "distance-driven: mean of the voxels under the pixel in each slice of the driving axis".into()
        }
        Algorithm::Exact => "trilinear field integrated exactly, cell by cell".into(),
    };
    let names: Vec<_> = plan.materials.iter().map(|m| m.name.as_str()).collect();
    Stage {
        name: "ray march",
        on_request: false,
        what: format!(
            "{what}; areal densities of {}{}",
            if names.is_empty() { "nothing".into() } else { names.join(", ") },
            passed_over(plan)
        ),
        reason: "every image is a function of the areal densities along its rays".into(),
        cost: format!(
            "at most {} samples ({} rays × {})",
            rays * plan.samples_per_ray(),
            rays,
            plan.samples_per_ray()
        ),
        error: match plan.engine {
            Backend::Reference => "float64 rounding".into(),
            _ => "float32: |ΔA| ≤ 1e-6 A + 5e-7 ρ X, X half the volume's diagonal".into(),
        },
        seconds: None,
        measured_seconds: None,
    }
}

/// What is done about empty space.
fn passed_over(plan: &Plan) -> String {
    match plan.empty {
        Some(empty) if plan.looks_for_ends() => {
            format!("; {:.0} % of the volume's bricks are empty and passed over", 100.0 * empty)
        }
        Some(empty) if empty > 0.0 => {
            format!(
                "; {:.0} % of the volume's bricks are empty, too few for single rays to look for",
                100.0 * empty
            )
        }
        _ => String::new(),
    }
}

fn longest(plan: &Plan) -> usize {
    plan.volume.into_iter().max().unwrap_or(0)
}

pub(super) fn omissions(plan: &Plan, scene: &Scene, volume: &Volume) -> Vec<Omission> {
    let mut omissions = Vec::new();
    for (label, name) in scene.materials.names().iter().enumerate() {
        if plan.materials.iter().all(|m| usize::from(m.label) != label) {
            let implanted =
                plan.effects.implants.iter().any(|implant| usize::from(implant.material) == label);
            let reason = match volume.materials()[label].labelled {
                _ if implanted => "only implants are made of it, whose chords need no march",
                true => "all its voxels have density 0: it attenuates nothing",
                false => "no voxel carries its label",
            };
            omissions.push(Omission {
                name: name.clone(),
                reason: format!("{reason}; no accumulator, exactly no error"),
            });
        }
    }
    if matches!(scene.method.energies, Energies::Few { .. }) && plan.quadrature.is_none() {
        omissions.push(Omission {
            name: "few energies".into(),
            reason: if scene.has_effects() {
                "effects are made of every energy; all bins are summed".into()
            } else {
                "none are known that keep the bound; all bins are summed".into()
            },
        });
    }
    omissions.extend(silent_bins(scene));
    if scene.bone.is_some_and(|bone| !volume.materials()[usize::from(bone)].labelled) {
        omissions.push(Omission {
            name: "bone path".into(),
            reason: "no bone in this volume: the layer is 0".into(),
        });
    }
    omissions.extend(effects::omissions(plan));
    omissions
}

/// Energies that no photon has, or that no layer of the detector sees.
fn silent_bins(scene: &Scene) -> Option<Omission> {
    let grid = scene.spectrum.grid();
    let seen = |k: usize| {
        let mut layers = scene.detector_layers.iter();
        scene.spectrum.weights()[k] > 0.0
            && (scene.detector_layers.is_empty() || layers.any(|layer| layer.factors()[k] > 0.0))
    };
    let silent: Vec<usize> = (0..grid.count()).filter(|&k| !seen(k)).collect();
    let (first, last) = (grid.energy(*silent.first()?), grid.energy(*silent.last()?));
    let range = if silent.last()? - silent.first()? + 1 == silent.len() { "at" } else { "between" };
    Some(Omission {
        name: "energy bins".into(),
        reason: format!(
            "{} bins {range} {first}–{last} keV carry 0 of the signal: exactly no error",
            silent.len()
        ),
    })
}
