//! The command `drr` as a user runs it: its files, its numbers, its errors.
#![cfg(feature = "command")]
#![allow(missing_docs, reason = "a test program")]

mod align;
mod effects;
mod reconstruct;
mod register;
#[path = "../support/mod.rs"]
mod support;

use std::path::Path;
use std::process::{Command, Output};

use drr::formats::{GeometryFile, NiftiWriter};
use drr::geometry::{DetectorPose, Grid};
use drr::phantom::Phantom;
use drr::physics::Calibration;
use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
use glam::DVec3;
use support::{chest_hu, noise};
use tempfile::TempDir;

const SIZE: [usize; 3] = [24, 20, 18];
const SMALL: [&str; 4] = ["--size", "22x14", "--pixel", "6"];

fn drr(folder: &Path, arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_drr")).args(arguments).current_dir(folder).output();
    output.expect("the command starts")
}

/// Runs the command, which must succeed, and returns its stdout.
fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let output = drr(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    assert_eq!(error, "", "{arguments:?} is silent where stderr is no terminal");
    String::from_utf8(output.stdout).expect("text")
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn f32s(folder: &Path, name: &str) -> Vec<f32> {
    bytes(folder, name).as_chunks().0.iter().map(|&b| f32::from_le_bytes(b)).collect()
}

fn f64s(folder: &Path, name: &str) -> Vec<f64> {
    bytes(folder, name).as_chunks().0.iter().map(|&b| f64::from_le_bytes(b)).collect()
}

fn grid() -> Grid {
    Grid::axis_aligned(SIZE, DVec3::new(2.0, 2.5, 3.0), DVec3::new(-10.0, 4.0, 8.5)).expect("valid")
}

/// `ct.nii.gz` and `ct.raw` with the same voxels, `labels.nii` and `labels.raw`; NIfTI keeps the origin in float32.
fn write_inputs() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let hu = chest_hu(SIZE);
    let labels: Vec<u8> = (0..hu.len()).map(|n| (4.0 * noise(n as u64)) as u8).collect();
    let mut ct = NiftiWriter::<i16>::create(&at("ct.nii.gz"), &grid()).expect("written");
    let mut label_file = NiftiWriter::<u8>::create(&at("labels.nii"), &grid()).expect("written");
    for (hu, labels) in hu.chunks(SIZE[0] * SIZE[1]).zip(labels.chunks(SIZE[0] * SIZE[1])) {
        ct.push_slice(hu).expect("written");
        label_file.push_slice(labels).expect("written");
    }
    ct.finish().expect("written");
    label_file.finish().expect("written");
    let raw: Vec<u8> = hu.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(at("ct.raw"), raw).expect("written");
    std::fs::write(at("labels.raw"), labels).expect("written");
    folder
}

const RAW: [&str; 8] =
    ["--ct", "ct.raw", "--dims", "24,20,18", "--spacing", "2,2.5,3", "--origin", "-10,4,8.5"];

fn project(folder: &Path, arguments: &[&[&str]]) -> String {
    succeed(folder, &[&["project"], &SMALL[..], &arguments.concat()].concat())
}

const LAYERS: [&str; 2] = ["--layers", "intensity,line_integral,areal_density,bone_path"];

#[test]
#[cfg_attr(debug_assertions, ignore = "half a minute without optimisation")]
fn the_main_job_needs_no_arguments() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = succeed(folder.path(), &[]);
    for word in ["720×720 pixels", "rays/s", "samples/s", "RMSE", "HU", "drr-output"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let names = ["plan.json", "radiograph.png", "view0.exr", "view1.exr"];
    assert_eq!(files(&folder.path().join("drr-output")), names);
}

fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn the_built_in_ct_gives_every_file_and_a_measured_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["project", "--size", "40x36", "--angles", "-6,0,90"];
    let text = succeed(folder.path(), &arguments);
    let names = ["plan.json", "radiograph.png", "view0.exr", "view1.exr", "view2.exr"];
    assert_eq!(files(&folder.path().join("drr-output")), names);
    let rounding = text.lines().find(|line| line.contains("rounding")).expect("the error is stated");
    let rmse: f64 = between(rounding, "RMSE ", " HU").parse().expect("a number");
    assert!(rmse > 0.0 && rmse < 0.01, "{rounding}");
    let plan: serde_json::Value =
        serde_json::from_slice(&bytes(folder.path(), "drr-output/plan.json")).expect("JSON");
    assert_eq!(plan["detector"], serde_json::json!([40, 36]));
    assert_eq!(plan["volume"], serde_json::json!([128, 128, 133]));
    assert_eq!(succeed(folder.path(), &[&arguments[..], &["--quiet"]].concat()), "");
}

fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    let rest = text.split_once(before).expect("before").1;
    rest.split_once(after).expect("after").0
}

#[test]
fn raw_and_nifti_inputs_give_identical_bytes() {
    let folder = write_inputs();
    let pair: [(&[&str], &[&str]); 2] = [
        (&["--ct", "ct.nii.gz"], &RAW),
        (&["--ct", "ct.nii.gz", "--labels", "labels.nii"], &[&RAW[..], &["--labels", "labels.raw"]].concat()),
    ];
    for (nifti, raw) in pair {
        project(folder.path(), &[nifti, &LAYERS, &["--output", "a"]]);
        project(folder.path(), &[raw, &LAYERS, &["--output", "b"]]);
        // NIfTI's frame is mirrored twice: both grids are the same, so every byte is.
        for name in ["view0.exr", "view1.exr", "radiograph.png", "plan.json"] {
            assert!(
                bytes(folder.path(), &format!("a/{name}")) == bytes(folder.path(), &format!("b/{name}")),
                "{name}"
            );
        }
    }
}

#[test]
fn raw_outputs_are_the_layers_of_the_exr() {
    let folder = write_inputs();
    project(folder.path(), &[&["--ct", "ct.nii.gz", "--raw", "--output", "out"], &LAYERS]);
    let out = folder.path().join("out");
    for view in 0..2 {
        let file = read_all_flat_layers_from_file(out.join(format!("view{view}.exr"))).expect("OpenEXR");
        let layer = &file.layer_data[0];
        let attributes: Vec<_> = layer.attributes.other.keys().map(ToString::to_string).collect();
        for name in ["source", "spectrum", "algorithm", "version", "units"] {
            assert!(attributes.contains(&format!("drr.{name}")), "{name}: {attributes:?}");
        }
        let mut names = Vec::new();
        for channel in &layer.channel_data.list {
            let FlatSamples::F32(values) = &channel.sample_data else { panic!("float32 is written") };
            let name = channel.name.to_string();
            assert_eq!(&f32s(&out, &format!("view{view}_{}.f32", name.replace('.', "_"))), values, "{name}");
            // The air around this chest has −1000 HU and no density.
            assert_eq!(values.iter().any(|&v| v != 0.0), name != "areal_density.air", "{name}");
            names.push(name);
        }
        let materials = ["air", "bone_cortical", "lung", "soft_tissue"].map(|m| format!("areal_density.{m}"));
        assert_eq!(
            names,
            [&materials[..], &["bone_path", "intensity", "line_integral"].map(String::from)].concat()
        );
    }
}

#[test]
fn the_picture_has_the_head_up_and_the_left_side_right() {
    let folder = tempfile::tempdir().expect("a folder");
    // Bone where x (to the patient's left) and z (to the head) are large, air elsewhere.
    let hu = (0..8_u16 * 8 * 8).map(|n| if n % 8 >= 5 && n / 64 >= 5 { 1000_i16 } else { -1000 });
    let raw: Vec<u8> = hu.flat_map(i16::to_le_bytes).collect();
    std::fs::write(folder.path().join("ct.raw"), raw).expect("written");
    std::fs::write(folder.path().join("alike.csv"), "energy_keV,a b,a_b\n60,0.2,0.2\n").expect("written");
    let ct = ["--ct", "ct.raw", "--dims", "8,8,8", "--spacing", "10,10,10", "--angles", "0"];
    succeed(folder.path(), &[&["project"], &ct[..], &["--size", "40x40", "--output", "out"]].concat());
    let file = std::fs::File::open(folder.path().join("out/radiograph.png")).expect("a picture");
    let mut picture = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("PNG");
    let mut pixels = vec![0; picture.output_buffer_size().expect("small")];
    picture.next_frame(&mut pixels).expect("PNG");
    let bright: Vec<usize> = (0..1600).filter(|&n| pixels[n] > 0).collect();
    assert!(bright.len() > 3 && bright.iter().all(|n| n % 40 >= 20 && n / 40 < 20), "{bright:?}");
}

#[test]
fn labels_win_over_thresholds() {
    let folder = write_inputs();
    let all_bone = vec![3_u8; SIZE.iter().product()];
    std::fs::write(folder.path().join("bone.raw"), all_bone).expect("written");
    let layers = ["--layers", "areal_density", "--raw", "--ct", "ct.nii.gz"];
    project(folder.path(), &[&layers, &["--output", "plain"]]);
    project(folder.path(), &[&layers, &["--labels", "bone.raw", "--output", "labelled"]]);
    let sum = |name: &str| f32s(folder.path(), name).iter().map(|&v| f64::from(v)).sum::<f64>();
    let tissues = ["air", "lung", "soft_tissue", "bone_cortical"];
    let plain: f64 = tissues.iter().map(|m| sum(&format!("plain/view0_areal_density_{m}.f32"))).sum();
    assert!(sum("plain/view0_areal_density_soft_tissue.f32") > 0.5 * plain);
    assert_eq!(sum("labelled/view0_areal_density_soft_tissue.f32"), 0.0);
    // The same mass, all of it bone.
    let bone = sum("labelled/view0_areal_density_bone_cortical.f32");
    assert!((bone / plain - 1.0).abs() < 1e-5, "{bone} {plain}");
}

#[test]
fn a_geometry_file_says_the_same_as_angles() {
    let folder = write_inputs();
    let pose = |angle| DetectorPose::c_arm(grid().centre(), angle, 1000.0, 1500.0, 6.0, [22, 14]);
    let geometry = GeometryFile { width: 22, height: 14, views: vec![pose(-6.0), pose(6.0)] };
    geometry.write(&folder.path().join("geometry.json")).expect("written");
    project(folder.path(), &[&RAW, &["--output", "a"]]);
    let arguments = [&["project"], &RAW[..], &["--geometry", "geometry.json", "--output", "b"]].concat();
    succeed(folder.path(), &arguments);
    for name in ["view0.exr", "view1.exr", "radiograph.png"] {
        assert!(
            bytes(folder.path(), &format!("a/{name}")) == bytes(folder.path(), &format!("b/{name}")),
            "{name}"
        );
    }
}

#[test]
fn tables_of_ones_own_stand_for_the_built_in_ones() {
    let folder = write_inputs();
    // One energy at which every gram attenuates alike: p is a tenth of the areal density.
    std::fs::write(folder.path().join("spectrum.csv"), "energy_keV,weight\n70,2\n71,6\n").expect("written");
    let rows = "energy_keV,a,b,c,d\n70,0.1,0.1,0.1,0.1\n71,0.1,0.1,0.1,0.1\n";
    std::fs::write(folder.path().join("materials.csv"), rows).expect("written");
    let tables = ["--spectrum", "spectrum.csv", "--materials", "materials.csv", "--raw", "--output", "out"];
    project(folder.path(), &[&RAW, &tables, &["--layers", "intensity,line_integral,areal_density"]]);
    let layer = |name: &str| f32s(folder.path(), &format!("out/view1_{name}.f32"));
    let densities = ["a", "b", "c", "d"].map(|m| layer(&format!("areal_density_{m}")));
    for (n, (p, i)) in layer("line_integral").into_iter().zip(layer("intensity")).enumerate() {
        let expected: f32 = densities.iter().map(|d| 0.1 * d[n]).sum();
        assert!((p - expected).abs() <= 2e-6 * expected + 1e-6, "{p} {expected}");
        assert!((i - 8.0 * (-p).exp()).abs() < 1e-5, "{i} {p}");
    }
}

#[test]
fn the_reference_engine_writes_float64_unrounded() {
    let folder = write_inputs();
    for algorithm in ["joseph", "exact"] {
        let arguments = ["--engine", "reference", "--algorithm", algorithm, "--raw", "--output", algorithm];
        project(folder.path(), &[&RAW, &arguments]);
    }
    project(folder.path(), &[&RAW, &["--raw", "--output", "cpu"]]);
    let reference = f64s(folder.path(), "joseph/view0_line_integral.f64");
    assert!(reference.iter().any(|&p| f64::from(p as f32) != p), "not rounded to float32");
    assert!(!folder.path().join("joseph/view0_line_integral.f32").exists());
    let fast = f32s(folder.path(), "cpu/view0_line_integral.f32");
    assert_eq!(fast.len(), reference.len());
    assert!(support::relative_l2(&fast, &reference) <= 2e-6);
    let exact = f64s(folder.path(), "exact/view0_line_integral.f64");
    assert!(exact != reference && support::relative_l2(&fast, &exact) < 0.05);
}

#[test]
fn a_phantom_projects_to_its_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let files = ["--output", "ct.nii.gz", "--labels-output", "labels.nii.gz"];
    succeed(at, &[&["phantom", "water_cylinder", "--size", "90,90,80"], &files[..]].concat());
    let size = [36, 36];
    let inputs = ["--ct", "ct.nii.gz", "--labels", "labels.nii.gz", "--size", "36x36", "--pixel", "12"];
    let outputs = ["--layers", "areal_density", "--raw", "--output", "out"];
    succeed(at, &[&["project"], &inputs[..], &outputs].concat());
    let phantom = Phantom::water_cylinder();
    let calibration = Calibration::named(Calibration::DEFAULT).expect("built in");
    let water = f32s(at, "out/view1_areal_density_soft_tissue.f32");
    let pose = DetectorPose::c_arm(DVec3::ZERO, 6.0, 1000.0, 1500.0, 12.0, size);
    let mut compared = 0;
    for (n, &water) in water.iter().enumerate() {
        let pixel = pose.pixel((n % size[0]) as f64, (n / size[0]) as f64);
        let density = |hu: i16| calibration.density(f64::from(hu));
        let truth = phantom.areal_densities(pose.source, pixel, &density, 4).expect("four materials")[2];
        // Well inside: a chord of 15 cm, and away from the ends.
        if truth > 15.0 && (n / size[0]).abs_diff(size[1] / 2) < 12 {
            compared += 1;
            assert!((f64::from(water) / truth - 1.0).abs() < 0.01, "pixel {n}: {water} {truth}");
        }
    }
    assert!(compared > 200, "{compared}");
    let list = succeed(at, &["phantom", "--list"]);
    assert_eq!(list.lines().collect::<Vec<_>>(), Phantom::names());
}

#[test]
fn bench_prints_one_json_object() {
    let folder = write_inputs();
    let arguments = [&["bench"], &RAW[..], &SMALL, &["--json", "--repeat", "3", "--threads", "2"]].concat();
    let report: serde_json::Value =
        serde_json::from_str(&succeed(folder.path(), &arguments)).expect("one JSON object");
    let times = report["times"].as_array().expect("times");
    assert_eq!(times.len(), 3);
    let median = report["median_seconds"].as_f64().expect("a number");
    assert!(times.iter().any(|t| t.as_f64() == Some(median)));
    assert_eq!((&report["engine"], &report["algorithm"]), (&"cpu".into(), &"joseph".into()));
    assert_eq!(report["threads"], 2);
    if cfg!(target_os = "linux") {
        assert!(report["peak_bytes"].as_u64().expect("known on Linux") > 1 << 20);
    }
    for stage in ["load", "classification", "projector_creation", "projection", "read_pass"] {
        assert!(report["stages"][stage]["median_seconds"].as_f64().expect(stage) >= 0.0);
    }
}

#[test]
fn tradeoff_measures_every_method_and_draws_it() {
    let folder = write_inputs();
    let arguments = [&["tradeoff", "--json", "--repeat", "2", "--tolerance-hu", "20"], &RAW[..], &SMALL];
    let last = ["--output", "out", "--write-timings", "timings.json"];
    let json = succeed(folder.path(), &[&arguments.concat()[..], &last].concat());
    let report: serde_json::Value = serde_json::from_str(&json).expect("one JSON object");
    assert_eq!(
        report,
        serde_json::from_slice::<serde_json::Value>(&bytes(folder.path(), "out/tradeoff.json"))
            .expect("JSON")
    );
    let settings = report["settings"].as_array().expect("settings");
    let find =
        |name: &str| settings.iter().find(|s| s["setting"] == name).unwrap_or_else(|| panic!("{name}"));
    let rms = |name: &str| find(name)["errors"]["hu"]["rms"].as_f64().expect("a number");
    assert!(rms("march, step 0.125 voxels") < 0.1 * rms("march, step 1 voxels"), "second order, and more");
    assert!(rms("march, step 1 voxels") < rms("march, step 4 voxels"));
    assert_eq!(find("siddon")["difference_of_model"], true);
    assert_eq!(find("distance_driven")["difference_of_model"], true);
    assert!(find("distance_driven")["pixel_area_hu"]["rms"].as_f64().expect("a number") > 0.0);
    let area = |name: &str| find(name)["pixel_area_hu"]["rms"].as_f64().expect("a number");
    assert!(area("joseph, 3×3 rays") < area("joseph"));
    let chosen: Vec<_> = settings.iter().filter(|s| s["chosen"] == true).collect();
    let [chosen] = chosen[..] else { panic!("one is chosen: {chosen:?}") };
    assert!(chosen["errors"]["hu"]["rms"].as_f64().expect("a number") <= 20.0);
    let times: Vec<_> = settings.iter().map(|s| s["median_seconds"].as_f64().expect("a number")).collect();
    assert!(times.is_sorted() && times[0] > 0.0);
    // Of each on the front, nothing before it is as exact.
    for (n, own) in settings.iter().enumerate().filter(|(_, s)| s["on_front"] == true) {
        let error = |s: &serde_json::Value| s["errors"]["hu"]["rms"].as_f64().expect("a number");
        assert!(settings[..n].iter().all(|s| s["difference_of_model"] == true || error(s) > error(own)));
    }
    let names = ["error_chosen.png", "error_joseph.png", "error_siddon.png", "tradeoff.png", "tradeoff.svg"];
    for name in names {
        assert!(bytes(folder.path(), &format!("out/{name}")).len() > 1000, "{name}");
    }
    // What it has measured is what a planner can be given.
    let plan =
        [&["plan", "--json", "--tolerance-hu", "20", "--timings", "timings.json"], &RAW[..], &SMALL].concat();
    let plan: serde_json::Value = serde_json::from_str(&succeed(folder.path(), &plan)).expect("JSON");
    assert!(plan["choice"]["costs"].as_str().expect("a name").contains("thread(s)"), "{plan}");
}

#[test]
fn a_stated_error_is_kept_over_all_rays() {
    let folder = write_inputs();
    let at = |hu: &str| {
        let own = ["project", "--tolerance-hu", hu, "--raw", "--output", hu, "--layers", "line_integral"];
        succeed(folder.path(), &[&own[..], &RAW, &SMALL].concat())
    };
    let exact = ["--engine", "reference", "--algorithm", "exact", "--raw", "--output", "exact"];
    succeed(folder.path(), &[&["project", "--layers", "line_integral"], &exact[..], &RAW, &SMALL].concat());
    let exact = f64s(folder.path(), "exact/view0_line_integral.f64");
    let floor = 0.05 * exact.iter().copied().fold(0.0, f64::max);
    for hu in ["50", "5"] {
        let text = at(hu);
        assert!(text.contains("tolerance") && text.contains("chosen"), "{text}");
        let own = f32s(folder.path(), &format!("{hu}/view0_line_integral.f32"));
        let errors: Vec<f64> = own
            .iter()
            .zip(&exact)
            .filter(|(_, exact)| **exact > floor)
            .map(|(own, exact)| 1000.0 * (f64::from(*own) / exact - 1.0))
            .collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!(rms > 0.0 && rms <= hu.parse().expect("a number"), "{hu} HU: {rms}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "half a minute without optimisation")]
fn rounding_grows_for_one_sum_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let report: serde_json::Value =
        serde_json::from_str(&succeed(folder.path(), &["rounding", "--json"])).expect("one JSON object");
    let rms = |sums: &str, samples: u64| {
        let rows = report["rows"].as_array().expect("rows");
        let row = rows.iter().find(|row| row["sums"] == sums && row["samples"] == samples);
        row.unwrap_or_else(|| panic!("{sums}: {report}"))["relative_rms"].as_f64().expect("a number")
    };
    assert!(rms("naive", 100_000) > 10.0 * rms("naive", 100));
    for sums in ["blocked", "compensated"] {
        assert!(rms(sums, 100_000) < 2e-7, "{sums}");
    }
    assert!(bytes(folder.path(), "drr-rounding/rounding.svg").starts_with(b"<svg"));
}

#[test]
fn plan_says_what_would_run() {
    let folder = write_inputs();
    let text = succeed(folder.path(), &[&["plan"], &RAW[..]].concat());
    assert!(text.contains("ray march") && text.contains("because"), "{text}");
    let json = succeed(folder.path(), &[&["plan", "--json", "--algorithm", "siddon"], &RAW[..]].concat());
    let plan: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(plan["method"]["algorithm"], "siddon");
    assert_eq!(files(folder.path()).len(), 4, "a plan writes nothing");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation")]
fn validate_measures_and_judges() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |size| {
        let output = drr(folder.path(), &["validate", "--json", "--size", size]);
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        (output.status.code(), report)
    };
    let (code, report) = run("240,240,222");
    let find = |what: &str| {
        let checks = report["checks"].as_array().expect("checks");
        let check = checks.iter().find(|c| c["what"] == what && c["algorithm"] == "joseph");
        check.unwrap_or_else(|| panic!("{what}: {report}"))["rmse"].as_f64().expect("a number")
    };
    assert!(find("rods") > 0.0 && find("rods") < 0.2, "{report}");
    assert!(find("water cylinder") > 0.0 && find("water cylinder") < 2.0, "{report}");
    let passed = report["passed"].as_bool().expect("a verdict");
    assert_eq!(code, Some(i32::from(!passed)));
    let (code, report) = run("40,40,37");
    assert_eq!(
        (code, report["passed"].as_bool()),
        (Some(1), Some(false)),
        "9 mm voxels cannot show rods of 2 mm"
    );
}

#[test]
fn bad_arguments_exit_with_2_and_name_themselves() {
    let folder = write_inputs();
    std::fs::write(folder.path().join("labels8.raw"), vec![8_u8; SIZE.iter().product()]).expect("written");
    std::fs::write(folder.path().join("half.csv"), "energy_keV,weight\n60.5,1\n").expect("written");
    std::fs::write(folder.path().join("alike.csv"), "energy_keV,a b,a_b\n60,0.2,0.2\n").expect("written");
    let ct = ["--ct", "ct.raw", "--dims", "24,20,18", "--spacing", "2,2,2"];
    let cases: [(&str, Vec<&str>); 43] = [
        ("--size", vec!["project", "--size", "0x5"]),
        ("--size", vec!["project", "--size", "large"]),
        ("--ct", vec!["project", "--ct", "missing.nii"]),
        ("--ct", vec!["project", "--ct", "ct.raw", "--dims", "9,9,9", "--spacing", "1,1,1"]),
        ("--dims", vec!["project", "--ct", "ct.raw"]),
        ("--dims", vec!["project", "--ct", "ct.raw", "--dims", "0,4,4", "--spacing", "1,1,1"]),
        ("--dims", vec!["project", "--ct", "ct.nii.gz", "--dims", "24,20,18"]),
        ("--spacing", vec!["project", "--ct", "ct.raw", "--dims", "24,20,18"]),
        ("--labels", [&["project"], &ct[..], &["--labels", "ct.raw"]].concat()),
        ("labels at voxel", [&["project"], &ct[..], &["--labels", "labels8.raw"]].concat()),
        ("--spectrum", vec!["project", "--spectrum", "W121"]),
        ("--materials", vec!["project", "--spectrum", "half.csv"]),
        ("--spacing", vec!["project", "--ct", "ct.raw", "--dims", "24,20,18", "--spacing", "0,1,1"]),
        ("--spacing", vec!["project", "--ct", "ct.raw", "--dims", "24,20,18", "--spacing", "nan,1,1"]),
        ("--dims", vec!["project", "--ct", "ct.raw", "--dims", "-4,4,4", "--spacing", "1,1,1"]),
        ("--threads", vec!["project", "--threads", "-1"]),
        ("--pixel", vec!["project", "--pixel", "1e300"]),
        ("--output", vec!["project", "--output", "ct.raw"]),
        ("share its file name", vec!["project", "--materials", "alike.csv"]),
        ("--mono", vec!["project", "--mono", "-3"]),
        ("--detector", vec!["project", "--detector", "film"]),
        ("--calibration", vec!["project", "--calibration", "none"]),
        ("--thresholds", vec!["project", "--thresholds", "none"]),
        ("--algorithm", vec!["project", "--algorithm", "exact"]),
        ("--step", vec!["project", "--algorithm", "march", "--step", "9"]),
        ("--step", vec!["project", "--step", "0.5"]),
        ("--preset", vec!["project", "--preset", "best"]),
        ("--tolerance-hu", vec!["project", "--tolerance-hu", "0"]),
        ("--tolerance-hu", vec!["plan", "--tolerance-hu", "1e-9", "--size", "20x20"]),
        ("--tolerance-hu", vec!["plan", "--tolerance-hu", "2", "--algorithm", "siddon"]),
        ("--tolerance-hu", vec!["plan", "--tolerance-mm", "1"]),
        ("--timings", vec!["plan", "--timings", "ct.raw"]),
        ("--engine", vec!["tradeoff", "--engine", "reference"]),
        ("tradeoff measures them all", vec!["tradeoff", "--algorithm", "siddon"]),
        ("--supersample", vec!["tradeoff", "--supersample", "2"]),
        ("--few-energies", vec!["plan", "--few-energies", "500"]),
        ("--tolerance-hu", vec!["plan", "--tolerance-hu", "5000"]),
        ("--sums", vec!["plan", "--sums", "naive", "--engine", "reference"]),
        ("takes no tolerance", vec!["plan", "--engine", "reference", "--tolerance-hu", "2"]),
        ("--geometry", vec!["project", "--geometry", "ct.raw"]),
        ("--threads", vec!["bench", "--threads", "5000"]),
        ("--device", vec!["bench", "--device", "1"]),
        ("--output", vec!["phantom", "thorax", "--output", "thorax.raw"]),
    ];
    for (name, arguments) in cases {
        let output = drr(folder.path(), &arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.starts_with("error: ") && error.contains(name), "{arguments:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{arguments:?}: {error}");
    }
    assert_eq!(files(folder.path()).len(), 7, "nothing is written: {:?}", files(folder.path()));
}
