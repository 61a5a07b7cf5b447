//! The command `drr` as a user runs it: its files, its numbers, its errors.
#![cfg(feature = "command")]
#![allow(missing_docs, reason = "a test program")]

mod align;
mod batch;
mod effects;
mod formats;
mod project;
mod reconstruct;
mod register;
mod report;
mod scaling;
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

fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    let rest = text.split_once(before).expect("before").1;
    rest.split_once(after).expect("after").0
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
    let cases: [(&str, Vec<&str>); 45] = [
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
        ("VOXELS,PIXELS,VIEWS", vec!["bench", "--scaling", "720,7,1"]),
        ("--output", vec!["bench", "--scaling", "8,8,1", "--output", "ct.raw"]),
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
