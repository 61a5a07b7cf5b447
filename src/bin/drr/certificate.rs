//! What error to expect, in words.

use drr::Energies;
use drr::accuracy::{Certificate, Estimate};
use drr::plan::{Plan, Stage};

/// A kind of error.
pub(crate) struct Row {
    pub(crate) what: String,
    /// `None` where no ray is above the floor.
    pub(crate) estimate: Option<Estimate>,
    pub(crate) unit: &'static str,
}

/// How wrong images of some views are.
pub(crate) fn rows(certificate: &Certificate, plan: &Plan) -> [Row; 3] {
    let method = plan.method;
    let own = if method.energies == Energies::All { "rounding" } else { "rounding and few energies" };
    let own = format!("{own}, against {} in float64", method.algorithm);
    let row = |what: String, estimate, unit| Row { what, estimate, unit };
    [
        row(own, certificate.rounding, "HU"),
        row("in all, against the exact integral of the voxels".into(), certificate.total.hu, "HU"),
        row("displacement of edges that would explain it".into(), certificate.total.mm, "mm"),
    ]
}

/// What was measured, and how, line by line; of a scene with effects, images before these are applied.
pub(crate) fn method(certificate: &Certificate, plan: &Plan) -> Vec<String> {
    let Certificate { rays, floor, confidence, .. } = certificate;
    let mut lines =
        vec![format!("of the line integral p, measured on {rays} rays of this scene in float64;")];
    if plan.stages.iter().any(Stage::is_effect) {
        lines.push("before effects, whose errors the plan states with each of them;".into());
    }
    lines.push(format!(
        "HU-equivalent = 1000 (p - p_ref)/p_ref over rays with p_ref > {floor:.3}; estimates of all rays"
    ));
    lines.push(format!("aim at {:.0} % confidence:", 100.0 * confidence));
    lines
}

/// All of it, for a terminal.
pub(crate) fn lines(certificate: &Certificate, plan: &Plan) -> String {
    let row = |Row { what, estimate, unit }: Row| {
        let numbers = estimate.map_or("no ray above the floor".into(), |e| {
            let [rms, high, max] = [e.rms, e.rms_high, e.max].map(short);
            format!("RMSE {rms} {unit}, of all rays below {high}, max {max}")
        });
        format!("{what:<49} {numbers}")
    };
    let lines = method(certificate, plan).into_iter().chain(rows(certificate, plan).map(row));
    format!("error   {}", lines.collect::<Vec<_>>().join("\n        "))
}

/// Three digits, with an exponent where zeros would hide them.
pub(crate) fn short(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.01 { format!("{value:.2e}") } else { format!("{value:.3}") }
}
