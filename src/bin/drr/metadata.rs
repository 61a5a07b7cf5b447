//! What image files say about themselves, by name.

use drr::Projector;
use drr::geometry::PatientOrientation;
use drr::physics::Spectrum;
use drr::plan::Stage;
use glam::DVec3;

use crate::fingerprint::Fingerprint;
use crate::inputs::Setup;
use crate::views::NamedView;

/// What stands before every name in a file.
pub(crate) const PREFIX: &str = "drr.";

/// Names and values that all views of a projector have.
pub(crate) struct Metadata(Vec<(&'static str, String)>);

impl Metadata {
    pub(crate) fn new(setup: &Setup<'_>, projector: &Projector, layers: &[String]) -> Self {
        let (scene, physics) = (projector.scene(), &setup.physics);
        let units =
            "intensity: weights of the spectrum; line_integral: 1; areal_density: g/cm\u{b2}; bone_path: mm";
        Self(vec![
            ("version", format!("drr {}", drr::VERSION)),
            ("world", "LPS, mm".into()),
            ("pixel", "column i, row j: first_pixel + i column_step + j row_step".into()),
            ("layers", layers.join(", ")),
            ("units", units.into()),
            ("spectrum", detected(projector, |spectrum| spectrum.name().into())),
            ("spectrum_energies", scene.spectrum.grid().to_string()),
            ("i0", detected(projector, |spectrum| spectrum.total().to_string())),
            ("materials", scene.materials.names().join(", ")),
            ("calibration", physics.classification.calibration.name().into()),
            ("thresholds", physics.classification.thresholds.name().into()),
            ("algorithm", projector.plan().method.to_string()),
            ("supersampling", scene.supersampling.to_string()),
            ("effects", effects(projector)),
            ("engine", setup.context.backend().name().into()),
            ("made_of", setup.context.install(|| Fingerprint::of(projector)).to_string()),
        ])
    }

    /// What all views have in common.
    pub(crate) fn common(&self) -> &[(&'static str, String)] {
        &self.0
    }

    /// Everything about one view, by the names in its file.
    pub(crate) fn of(&self, view: &NamedView) -> Vec<(String, String)> {
        let mm = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
        let pose = &view.pose;
        let own = [
            ("view", view.number.to_string()),
            ("source", mm(pose.source)),
            ("first_pixel", mm(pose.first_pixel)),
            ("column_step", mm(pose.column_step)),
            ("row_step", mm(pose.row_step)),
            ("patient_orientation", PatientOrientation::of(pose).to_string()),
        ];
        let all = self.0.iter().cloned().chain(own);
        all.map(|(name, value)| (format!("{PREFIX}{name}"), value)).collect()
    }
}

/// Something of the spectrum that each of the detector's layers sees.
fn detected(projector: &Projector, text: impl Fn(&Spectrum) -> String) -> String {
    let scene = projector.scene();
    let layers = (0..scene.layers()).filter_map(|layer| scene.detected(layer).ok());
    layers.map(|spectrum| text(&spectrum)).collect::<Vec<_>>().join(", ")
}

/// What was simulated beside attenuation.
fn effects(projector: &Projector) -> String {
    let plan = projector.plan();
    let stages = plan.stages.iter().filter(|stage| stage.is_effect());
    let what = |stage: &Stage| match &plan.effects.focal_spot {
        // The plan's own words are about all expected views.
        Some(spot) if stage.name == "focal spot" => format!("{} × {} mm", spot.width_mm, spot.height_mm),
        _ => stage.what.clone(),
    };
    let effects: Vec<_> = stages.map(|stage| format!("{}: {}", stage.name, what(stage))).collect();
    if effects.is_empty() { "none".into() } else { effects.join("; ") }
}
