//! The stage that makes a signal of areal densities.

use crate::engine::Backend;
use crate::physics::{DetectorResponse, Quadrature};
use crate::plan::{Plan, Stage};
use crate::scene::Scene;

pub(super) fn stage(plan: &Plan, scene: &Scene, rays: usize) -> Stage {
    match &plan.quadrature {
        _ if plan.energy_bins == 1 => one_energy(plan, rays),
        None => all_energies(plan, scene, rays),
        Some(quadrature) => few_energies(plan, scene, quadrature, rays),
    }
}

fn one_energy(plan: &Plan, rays: usize) -> Stage {
    Stage {
        name: "attenuate",
        on_request: false,
        what: "I = I0 exp(−Σ_m (μ/ρ)_m A_m) at one energy".into(),
        reason: "the spectrum has a single bin".into(),
        cost: format!("{rays} exponentials"),
        error: rounding(plan).into(),
        seconds: None,
        measured_seconds: None,
    }
}

fn all_energies(plan: &Plan, scene: &Scene, rays: usize) -> Stage {
    Stage {
        name: "spectrum",
        on_request: false,
        what: format!(
            "I = Σ_k w_k exp(−Σ_m (μ/ρ)_m(E_k) A_m) over {} bins × {} materials, {}",
            plan.energy_bins,
            plan.materials.len() + beside(plan),
            how_often(plan, scene)
        ),
        reason: format!("the scene is poly-energetic ({})", spectrum_name(scene)),
        cost: cost(plan, rays, plan.energy_bins),
        error: rounding(plan).into(),
        seconds: None,
        measured_seconds: None,
    }
}

fn few_energies(plan: &Plan, scene: &Scene, quadrature: &Quadrature, rays: usize) -> Stage {
    let list = |items: Vec<String>| items.join(", ");
    let energies = list(quadrature.nodes().iter().map(|node| format!("{:.1}", node.kev)).collect());
    let limits = plan
        .materials
        .iter()
        .map(|material| format!("{} {:.3}", material.name, quadrature.limits()[usize::from(material.label)]));
    let few = quadrature.nodes().len();
    Stage {
        name: "spectrum",
        on_request: false,
        what: format!(
            "I = Σ_k w_k exp(−Σ_m (μ/ρ)_m(E_k) A_m) over {few} of {} bins ({energies} keV) × {} materials, once per ray; \
             beyond {} g/cm² over all bins",
            plan.energy_bins,
            plan.materials.len(),
            list(limits.collect())
        ),
        reason: format!(
            "the scene is poly-energetic ({}), and few energies keep the bound that it asks for",
            spectrum_name(scene)
        ),
        cost: format!(
            "{}; where all rays lie beyond, {}",
            cost(plan, rays, few),
            cost(plan, rays, plan.energy_bins)
        ),
        error: format!(
            "{}, and of few energies |Δp| ≤ {:.2e} max(p, {:.3})",
            rounding(plan),
            quadrature.bound(),
            quadrature.floor()
        ),
        seconds: None,
        measured_seconds: None,
    }
}

/// Materials in the way of rays that the march does not meet: those of implants alone, filters and the anode.
fn beside(plan: &Plan) -> usize {
    let effects = &plan.effects;
    let marched = |label: u8| plan.materials.iter().any(|material| material.label == label);
    let mut implanted: Vec<u8> = effects.implants.iter().map(|implant| implant.material).collect();
    implanted.sort_unstable();
    implanted.dedup();
    let implanted = implanted.into_iter().filter(|label| !marched(*label)).count();
    implanted + effects.filters.len() + usize::from(effects.heel.is_some())
}

fn how_often(plan: &Plan, scene: &Scene) -> String {
    let ray = match plan.focal_points() {
        1 => "once per ray".into(),
        points => format!("once per ray and each of {points} points of the focal spot"),
    };
    let noisy = plan.effects.noise.as_ref().is_some_and(|noise| noise.quantum);
    match (scene.layers(), noisy && !scene.detector_layers.iter().all(DetectorResponse::counts_photons)) {
        (1, false) => ray,
        (1, true) => format!("{ray}, for the signal and the moments of its noise"),
        (layers, false) => format!("{ray}, for {layers} detector layers"),
        (layers, true) => format!("{ray}, for {layers} detector layers and the moments of their noise"),
    }
}

fn cost(plan: &Plan, rays: usize, energies: usize) -> String {
    let terms = energies * plan.materials.len();
    format!("{} exponentials, {} multiply-adds", rays * energies, rays * terms)
}

/// Of a sum over every bin with weight rounding is all.
fn rounding(plan: &Plan) -> &'static str {
    match plan.engine {
        Backend::Reference => "float64 rounding",
        _ => "float32: |Δp| ≤ 2e-6 p + 1e-6",
    }
}

/// With the detector's response.
fn spectrum_name(scene: &Scene) -> String {
    let layers = scene.detector_layers.iter().map(DetectorResponse::name);
    let layers = layers.collect::<Vec<_>>().join(" and ");
    if layers.is_empty() {
        scene.spectrum.name().into()
    } else {
        format!("{} × {layers}", scene.spectrum.name())
    }
}
