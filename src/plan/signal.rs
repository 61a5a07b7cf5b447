//! The stage that makes a signal of areal densities.

use crate::engine::Backend;
use crate::physics::Quadrature;
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
    }
}

fn all_energies(plan: &Plan, scene: &Scene, rays: usize) -> Stage {
    Stage {
        name: "spectrum",
        on_request: false,
        what: format!(
            "I = Σ_k w_k exp(−Σ_m (μ/ρ)_m(E_k) A_m) over {} bins × {} materials, once per ray",
            plan.energy_bins,
            plan.materials.len()
        ),
        reason: format!("the scene is poly-energetic ({})", scene.spectrum.name()),
        cost: cost(plan, rays, plan.energy_bins),
        error: rounding(plan).into(),
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
            scene.spectrum.name()
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
