use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::effects::{DetectorBlur, FillFactor, Filter, Noise, Profile, Scatter};
use crate::engine::reference::Reference;
use crate::geometry::Grid;
use crate::method::Energies;
use crate::physics::{Calibration, DetectorResponse, Spectrum, Thresholds};
use crate::volume::Classification;

fn volume(hu: &[i16], labels: Option<&[u8]>) -> Volume {
    let grid = Grid::centred([hu.len(), 1, 1], DVec3::ONE).expect("valid");
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    Volume::from_int16(grid, hu, labels, &how).expect("valid")
}

fn plan(scene: &Scene, volume: &Volume) -> Plan {
    Plan::new(scene, volume, Backend::Cpu, None).expect("valid")
}

#[test]
fn only_materials_that_can_attenuate_get_an_accumulator() {
    let scene = Scene::new([8, 8]).expect("valid");
    let planned = plan(&scene, &volume(&[-1000, 40, 900], None));
    let labels: Vec<u8> = planned.materials.iter().map(|m| m.label).collect();
    assert_eq!(labels, [2, 3], "air is vacuum at -1000 HU, lung is absent");
    let left_out = |name: &str| planned.omissions.iter().any(|o| o.name == name);
    assert!(left_out("air") && left_out("lung") && !left_out("soft_tissue"));
}

#[test]
fn a_single_bin_needs_no_sum_over_energies_and_absent_bone_no_path() {
    let scene = Scene::new([8, 8]).expect("valid");
    let mono = Spectrum::monoenergetic(60.0).expect("valid");
    let materials = crate::physics::MassAttenuation::named(
        &["air", "lung", "soft_tissue", "bone_cortical"],
        *mono.grid(),
    );
    let mono = Scene { spectrum: mono, materials: materials.expect("tabulated"), ..scene.clone() };
    let names = |plan: &Plan| plan.stages.iter().map(|s| s.name).collect::<Vec<_>>();
    assert_eq!(names(&plan(&mono, &volume(&[40], None))), ["ray march", "attenuate"]);
    assert_eq!(names(&plan(&scene, &volume(&[900], None))), ["ray march", "spectrum", "bone path"]);
}

#[test]
fn a_label_without_a_material_is_refused() {
    let scene = Scene::new([8, 8]).expect("valid");
    let error =
        Plan::new(&scene, &volume(&[0, 0], Some(&[1, 6])), Backend::Cpu, None).expect_err("label 6 of 4");
    assert_eq!(
        error.to_string(),
        "scene.material_count is 4; valid: at least 7: the volume has voxels with label 6"
    );
}

#[test]
fn the_plan_is_json() {
    let scene = Scene::new([8, 8]).expect("valid");
    let json: serde_json::Value =
        serde_json::from_str(&plan(&scene, &volume(&[40], None)).to_json()).expect("valid JSON");
    assert_eq!(json["engine"], "cpu");
    assert_eq!(json["stages"][0]["name"], "ray march");
}

#[test]
fn labels_of_one_scheme_do_not_meet_materials_of_another() {
    let grid = Grid::centred([3, 1, 1], DVec3::ONE).expect("valid");
    let how = Classification::named(Calibration::DEFAULT, "deepdrr_thresholds").expect("built in");
    let volume = Volume::from_int16(grid, &[-900, 40, 900], None, &how).expect("valid");
    let scene = Scene::new([8, 8]).expect("valid");
    let error = Plan::new(&scene, &volume, Backend::Cpu, None).expect_err("label 1 is soft tissue, not lung");
    assert!(error.to_string().starts_with("scene.materials[1] is lung; valid: soft_tissue"), "{error}");
}

#[test]
fn a_volume_in_a_texture_may_hold_every_material_and_is_for_metal_alone() {
    let grid = Grid::centred([4, 4, 4], DVec3::ONE).expect("valid");
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    let volume = Arc::new(Volume::from_texture(grid, Arc::new(()), &how).expect("small"));
    let scene = Scene::new([8, 8]).expect("valid");
    let planned = Plan::new(&scene, &volume, Backend::Metal, None).expect("planned, wherever it runs");
    let labels: Vec<u8> = planned.materials.iter().map(|m| m.label).collect();
    assert_eq!(labels, [0, 1, 2, 3], "air up to -950 HU has a density");
    for backend in Backend::ALL.into_iter().filter(|&backend| backend != Backend::Metal) {
        let error = Plan::new(&scene, &volume, backend, None).expect_err("it cannot read textures");
        assert!(matches!(&error, Error::Unsupported(text) if text.contains(backend.name())), "{error}");
    }
    // The truth that images of another engine are measured against.
    let error =
        Reference::new(volume, &scene, scene.method.algorithm).err().expect("it cannot read textures");
    assert!(matches!(error, Error::Unsupported(_)), "{error}");
}

#[test]
fn distance_driven_means_are_of_the_cpu() {
    let scene = Scene { method: Algorithm::DistanceDriven.into(), ..Scene::new([8, 8]).expect("valid") };
    for backend in Backend::ALL {
        match Plan::new(&scene, &volume(&[40], None), backend, None) {
            Ok(plan) => {
                assert!(matches!(backend, Backend::Reference | Backend::Cpu), "{}", backend.name());
                assert!(plan.stages[0].what.starts_with("distance-driven: mean of the voxels"));
            }
            Err(Error::Unsupported(text)) => {
                assert!(matches!(backend, Backend::Host | Backend::Cuda | Backend::Metal), "{text}");
                assert!(text.contains(backend.name()) && text.contains("distance_driven"), "{text}");
            }
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn few_energies_are_in_the_plan_with_their_limits_and_their_bound() {
    let volume = volume(&[-1000, 40, 900], None);
    let few = Energies::Few { hu: 1.0 };
    let scene = Scene::new([8, 8]).expect("valid");
    let scene = Scene { method: Method { energies: few, ..scene.method }, ..scene };
    let model = scene.spectral_model().expect("valid");
    let quadrature = Quadrature::new(&model, &[0.0, 0.0, 45.0, 12.0], 0.25, 1e-3).expect("there are few");
    let planned = |engine, quadrature| Plan::new(&scene, &volume, engine, quadrature).expect("valid");
    let [with, without] = [Some(quadrature.clone()), None].map(|some| planned(Backend::Cpu, some));
    let stage = with.stages.iter().find(|stage| stage.name == "spectrum").expect("poly-energetic");
    let nodes = quadrature.nodes().len();
    let first = format!("{nodes} of {} bins ({:.1}, ", model.bins(), quadrature.nodes()[0].kev);
    assert!(stage.what.contains(&first), "{}", stage.what);
    assert!(stage.what.ends_with("beyond soft_tissue 45.000, bone_cortical 12.000 g/cm² over all bins"));
    assert!(stage.cost.starts_with(&format!("{} exponentials", 64 * nodes)), "{}", stage.cost);
    assert!(stage.error.contains(&format!("{:.2e} max(p, 0.250)", quadrature.bound())), "{}", stage.error);
    let json = |plan: &Plan| -> serde_json::Value { serde_json::from_str(&plan.to_json()).expect("JSON") };
    assert_eq!(json(&with)["quadrature"]["nodes"].as_array().map(Vec::len), Some(nodes));
    assert!(json(&without).get("quadrature").is_none());
    let says = |plan: &Plan| plan.omissions.iter().any(|omission| omission.name == "few energies");
    assert!(!says(&with) && says(&without));
    assert_eq!(
        planned(Backend::Reference, Some(quadrature)).quadrature,
        None,
        "the truth is of all energies"
    );
}

/// What a scene asks for, in the order in which a photon meets it; what it does not ask for is said too.
#[test]
fn effects_are_stages_and_their_absence_is_stated() {
    let grid = *Scene::new([8, 8]).expect("valid").spectrum.grid();
    let effects = Effects {
        fall_off: true,
        filters: vec![Filter::named("copper", grid, Profile::Flat { mm: 0.1 }).expect("built in")],
        scatter: Some(Scatter::default()),
        detector_blur: Some(DetectorBlur::gaussians(&[(1.0, 0.2)]).expect("valid")),
        fill_factor: Some(FillFactor::new(0.6).expect("valid")),
        noise: Some(Noise { photons_per_pixel: 1e4, quantum: true, electronic_photons: 0.0, seed: 3 }),
        ..Effects::default()
    };
    let response = DetectorResponse::named("top_energy", grid).expect("built in");
    let scene =
        Scene { effects, detector_layers: vec![response], bone: None, ..Scene::new([8, 8]).expect("valid") };
    let planned = plan(&scene, &volume(&[40, 900], None));
    let names: Vec<_> = planned.stages.iter().map(|stage| stage.name).collect();
    assert_eq!(names, ["ray march", "spectrum", "source", "scatter", "detector blur", "pixels", "noise"]);
    let what = |name: &str| &planned.stages.iter().find(|stage| stage.name == name).expect("planned").what;
    assert!(what("source").contains("cos³θ") && what("source").contains("0.1 mm copper"));
    assert!(what("spectrum").contains("moments") && what("noise").contains("compound Poisson"));
    let others = planned.omissions.iter().find(|o| o.name == "not asked for").expect("stated");
    assert!(others.reason.contains("heel effect, implants, focal spot:"), "{}", others.reason);

    let plain = plan(
        &Scene { effects: Effects::default(), detector_layers: Vec::new(), ..scene },
        &volume(&[40], None),
    );
    let names: Vec<_> = plain.stages.iter().map(|stage| stage.name).collect();
    assert_eq!(names, ["ray march", "spectrum"]);
    let silent = plain.omissions.iter().find(|o| o.name == "energy bins").expect("stated");
    assert!(silent.reason.starts_with("30 bins at 121–150 keV carry 0 of the signal"), "{}", silent.reason);
}
