//! What error to expect, in words.

use drr::Energies;
use drr::accuracy::{Certificate, Estimate};
use drr::plan::{Plan, Stage};

/// The lines that say how wrong images of some views are; those of a scene with effects before these are applied.
pub(crate) fn lines(certificate: &Certificate, plan: &Plan) -> String {
    let method = plan.method;
    let before = if plan.stages.iter().any(Stage::is_effect) {
        "\n        before effects, whose errors the plan states with each of them;"
    } else {
        ""
    };
    let own = if method.energies == Energies::All { "rounding" } else { "rounding and few energies" };
    let Certificate { rays, floor, confidence, total, rounding } = certificate;
    let row = |what: String, estimate: Option<Estimate>, unit: &str| {
        let numbers = estimate.map_or("no ray above the floor".into(), |e| {
            let [rms, high, max] = [e.rms, e.rms_high, e.max].map(short);
            format!("RMSE {rms} {unit}, of all rays below {high}, max {max}")
        });
        format!("        {what:<49} {numbers}")
    };
    [
        format!("error   of the line integral p, measured on {rays} rays of this scene in float64;{before}"),
        format!("        HU-equivalent = 1000 (p - p_ref)/p_ref over rays with p_ref > {floor:.3}; estimates of all rays"),
        format!("        aim at {:.0} % confidence:", 100.0 * confidence),
        row(format!("{own}, against {} in float64", method.algorithm), *rounding, "HU"),
        row("in all, against the exact integral of the voxels".into(), total.hu, "HU"),
        row("displacement of edges that would explain it".into(), total.mm, "mm"),
    ]
    .join("\n")
}

/// Three digits, with an exponent where zeros would hide them.
pub(crate) fn short(value: f64) -> String {
    if value != 0.0 && value < 0.01 { format!("{value:.2e}") } else { format!("{value:.3}") }
}
