//! The stages that effects call for.

use crate::effects::{Profile, Sights};
use crate::exposure::Focus;
use crate::geometry::View;
use crate::physics::DetectorResponse;
use crate::plan::{Omission, Plan, Stage};
use crate::scene::Scene;

/// Names of stages that effects call for.
pub(super) const NAMES: [&str; 7] =
    ["source", "implants", "focal spot", "scatter", "detector blur", "pixels", "noise"];

/// In the order in which they run.
pub(super) fn stages(plan: &Plan, scene: &Scene) -> Vec<Stage> {
    let stages = [
        source(plan, scene),
        implants(plan),
        focal_spot(plan),
        scatter(plan),
        detector_blur(plan, scene),
        pixels(plan, scene),
    ];
    stages.into_iter().flatten().chain(noise(plan, scene)).collect()
}

/// A stage that a scene with effects has because of `reason`.
fn stage(name: &'static str, what: String, cost: String, error: &str) -> Stage {
    let reason = "the scene asks for it".into();
    Stage {
        name,
        on_request: false,
        what,
        reason,
        cost,
        error: error.into(),
        seconds: None,
        measured_seconds: None,
    }
}

/// What lies before the volume, as part of the sum over energies.
fn source(plan: &Plan, scene: &Scene) -> Option<Stage> {
    let effects = &plan.effects;
    let mut parts = Vec::new();
    if effects.fall_off {
        parts.push("fall-off cos³θ".to_owned());
    }
    if let Some(heel) = &effects.heel {
        parts.push(format!(
            "heel: {:.1} µm deep in tungsten at {}°",
            1000.0 * heel.depth_mm,
            heel.target_angle_degrees
        ));
    }
    parts.extend(effects.filters.iter().map(|filter| match &filter.profile {
        Profile::Flat { mm } => format!("{mm} mm {}", filter.name),
        Profile::BowTie { mm, .. } => {
            let (thin, thick) = mm.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &x| (a.min(x), b.max(x)));
            format!("bow-tie of {thin} to {thick} mm {}", filter.name)
        }
    }));
    (!parts.is_empty()).then(|| {
        let cost = format!(
            "{} factor(s) or path(s) in closed form per ray, part of the sum over energies",
            parts.len()
        );
        let error = if hides_pixels(plan, scene) {
            "float64 rounding; some pixels are below the anode's horizon: intensity 0 and p infinite there"
        } else {
            "float64 rounding"
        };
        stage("source", parts.join("; "), cost, error)
    })
}

/// Whether the anode hides a corner of the detector in an expected view.
fn hides_pixels(plan: &Plan, scene: &Scene) -> bool {
    let Some(heel) = &plan.effects.heel else { return false };
    let [right, bottom] = scene.detector.map(|side| side as f64 - 1.0);
    let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)];
    scene.expected_views.iter().any(|view| {
        let sights = Sights::new(view, scene.detector);
        corners.iter().any(|&(column, row)| heel.path_mm(&sights.at(column, row)) == f64::INFINITY)
    })
}

fn implants(plan: &Plan) -> Option<Stage> {
    let count = plan.effects.implants.len();
    (count > 0).then(|| {
        let what = format!("{count} implant(s) instead of the volume, by their chords in closed form");
        let cost = format!(
            "{count} intersection(s) per ray, part of the ray march; where one is hit, the volume inside once more in float64"
        );
        stage("implants", what, cost, "the ray march's, where the volume is taken away")
    })
}

fn focal_spot(plan: &Plan) -> Option<Stage> {
    let (spot, choice) = (plan.effects.focal_spot?, plan.focus.as_ref()?);
    let [columns, rows] = choice.penumbra;
    let size =
        format!("{} × {} mm, penumbrae up to {columns:.2} × {rows:.2} pixels", spot.width_mm, spot.height_mm);
    Some(match choice.focus {
        Focus::Convolved => {
            let error =
                choice.errors.iter().find_map(|(focus, error)| error.filter(|_| *focus == Focus::Convolved));
            let hu = error.map_or(0.0, |error| error.rms_high);
            let error = format!("{hu:.3} HU RMSE against all its points, measured");
            let what = format!("{size}: one convolution, right at the volume's centre");
            stage("focal spot", what, "2 passes over each image".into(), &error)
        }
        Focus::Point | Focus::Points => {
            let [a, b] = choice.points;
            let what = format!("{size}: from {a}×{b} points");
            stage(
                "focal spot",
                what,
                format!("{} ray march(es), whose times are told there", a * b),
                "of a sum over points whose shadows are at most half a pixel apart",
            )
        }
    })
}

fn scatter(plan: &Plan) -> Option<Stage> {
    let scatter = plan.effects.scatter.as_ref()?;
    let what = format!(
        "superposition of kernels of water by areal density, made of {} photons per thickness",
        scatter.histories
    );
    let cost = "at most 48×48 cells, each with every other; before, once per spectrum, detector and distances, the kernels by Monte Carlo";
    Some(stage(
        "scatter",
        what,
        cost.into(),
        "scatter-to-primary ratio within 15 % of a full Monte Carlo in slabs and cylinders of water",
    ))
}

fn detector_blur(plan: &Plan, scene: &Scene) -> Option<Stage> {
    let blur = plan.effects.detector_blur.as_ref()?;
    let parts =
        blur.components().iter().map(|part| format!("{:.0} % σ {} mm", 100.0 * part.weight, part.sigma_mm));
    let what = format!("Gaussians: {}", parts.collect::<Vec<_>>().join(", "));
    let cost = format!("{} passes over each image", 2 * blur.components().len());
    let known = scene.expected_views.first().and_then(|view| {
        let pitch = ray_pitch_mm(view, scene)?;
        Some((pitch, blur.worst_response_error(pitch).ok()?))
    });
    let error = match known {
        Some(([columns, rows], error)) => format!(
            "of the MTF at most {error:.1e} up to half a cycle per ray (rays {columns:.3} × {rows:.3} mm apart); none where \
             the image is even"
        ),
        None => {
            "of the MTF, by the kernels' samples: at most 0.23 where σ is 0.4 rays, 0.01 from 1 ray on".into()
        }
    };
    Some(stage("detector blur", what, cost, &error))
}

/// Distances of neighbouring rays on the detector along columns and rows; `None` where a matrix gives the view.
fn ray_pitch_mm(view: &View, scene: &Scene) -> Option<[f64; 2]> {
    let View::Pose(pose) = view else { return None };
    let n = scene.supersampling as f64;
    Some([pose.column_step, pose.row_step].map(|step| step.length() / n))
}

fn pixels(plan: &Plan, scene: &Scene) -> Option<Stage> {
    let fill = plan.effects.fill_factor?;
    let n = scene.supersampling;
    let what = format!("the active {:.0} % of each pixel, {n}×{n} rays", 100.0 * fill.part());
    let error = if n == 1 {
        "none of the signal's size; one ray stands for the whole area"
    } else {
        "of sampling the area by points"
    };
    Some(stage("pixels", what, format!("{} addition(s) per pixel", n * n), error))
}

fn noise(plan: &Plan, scene: &Scene) -> Option<Stage> {
    let noise = plan.effects.noise.as_ref()?;
    let mut parts = Vec::new();
    if noise.quantum {
        let counting = scene.detector_layers.iter().all(DetectorResponse::counts_photons);
        let how = if counting { "Poisson" } else { "compound Poisson by energy, its first three moments" };
        parts.push(format!("{how}, {} photons per pixel of the open field", noise.photons_per_pixel));
    }
    if noise.electronic_photons > 0.0 {
        parts.push(format!("electronic, normal, σ {} photons", noise.electronic_photons));
    }
    let what = format!("{}; seed {}", parts.join("; "), noise.seed);
    Some(stage(
        "noise",
        what,
        "3 random numbers per pixel and detector layer".into(),
        "none of mean, variance and skewness; the same noise for any number of threads, and on any engine to its rounding",
    ))
}

/// What does not run although the scene asks for it, and what it does not ask for.
pub(super) fn omissions(plan: &Plan) -> Vec<Omission> {
    let mut omissions: Vec<_> = plan
        .left_out
        .iter()
        .map(|left| Omission {
            name: left.name.into(),
            reason: format!(
                "error at most {:.3} HU, {:.3} are allowed: {}",
                left.hu, left.allowed_hu, left.what
            ),
        })
        .collect();
    let effects = &plan.effects;
    let asked_for = [
        ("fall-off", effects.fall_off),
        ("heel effect", effects.heel.is_some()),
        ("filters", !effects.filters.is_empty()),
        ("implants", !effects.implants.is_empty()),
        ("focal spot", effects.focal_spot.is_some()),
        ("scatter", effects.scatter.is_some()),
        ("detector blur", effects.detector_blur.is_some()),
        ("fill factor", effects.fill_factor.is_some()),
        ("noise", effects.noise.is_some()),
    ];
    let left_out = |name: &str| plan.left_out.iter().any(|left| left.name == name);
    let others: Vec<_> =
        asked_for.iter().filter(|(name, on)| !on && !left_out(name)).map(|(name, _)| *name).collect();
    if !others.is_empty() {
        omissions.push(Omission {
            name: "not asked for".into(),
            reason: format!("{}: none of their code runs", others.join(", ")),
        });
    }
    omissions
}
