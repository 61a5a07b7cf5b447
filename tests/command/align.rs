//! Alignment, as a user asks for it.

use super::*;

/// A thorax of 64³ voxels, which takes a second.
const SMALL: [&str; 9] =
    ["align", "--phantom", "thorax", "--voxels", "64", "--pixel=4", "--count", "3", "--photons=1e7"];

fn report(folder: &Path, name: &str) -> serde_json::Value {
    serde_json::from_slice(&bytes(folder, name)).expect("JSON")
}

/// Of every view: α, β, φ, Δx, Δz.
fn of_views(report: &serde_json::Value, key: &str) -> Vec<[f64; 5]> {
    let views = report["views"].as_array().expect("views").iter();
    views.map(|view| serde_json::from_value(view[key].clone()).expect("five numbers")).collect()
}

#[test]
fn misaligned_views_are_found_and_every_file_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = succeed(folder.path(), &[&SMALL[..], &["--raw", "--output", "out"]].concat());
    for word in ["thorax: 64×64×59 voxels", "before, largest", "after, largest", "evaluations", "aligned.csv"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
    let out = folder.path().join("out");
    let names = [
        "align.json",
        "aligned.csv",
        "convergence.png",
        "convergence.svg",
        "measured.f32",
        "nominal.csv",
        "views.png",
    ];
    assert_eq!(files(&out), names);
    let report = report(&out, "align.json");
    let (nominal, truth) = (of_views(&report, "nominal"), of_views(&report, "truth"));
    let moved = |k: usize| nominal.iter().zip(&truth).map(|(a, b)| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    assert!((0..5).all(|k| moved(k) > 0.5 && moved(k) <= 5.0), "there was something to find");
    // What is printed is what the errors are: below 0.02 degrees and 0.05 mm.
    for (aligned, truth) in of_views(&report, "aligned").iter().zip(&truth) {
        for k in 0..5 {
            let promise = if k < 3 { 0.02 } else { 0.05 };
            assert!((aligned[k] - truth[k]).abs() < promise, "{aligned:?} {truth:?}");
        }
    }
    assert!(text.contains("  all errors are below 0.02 degrees and 0.05 mm"), "{text}");
    assert!(of_views(&report, "standard_deviations").iter().flatten().all(|sd| *sd > 0.0 && *sd < 0.05));
    assert_eq!(succeed(folder.path(), &[&SMALL[..], &["--quiet", "--output", "quiet"]].concat()), "");
    assert_eq!(
        bytes(&out, "aligned.csv"),
        bytes(&folder.path().join("quiet"), "aligned.csv"),
        "the same again"
    );
}

#[test]
fn measured_views_are_aligned_like_simulated_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    succeed(folder.path(), &[&SMALL[..], &["--raw", "--output", "own"]].concat());
    let volume = &SMALL[..6];
    let measured =
        ["--measured", "own/measured.f32", "--views", "own/nominal.csv", "--output", "again", "--json"];
    let json = succeed(folder.path(), &[volume, &measured].concat());
    let report: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert!(report["errors"].is_null() && report["views"][0]["truth"].is_null());
    assert_eq!(
        bytes(folder.path(), "own/aligned.csv"),
        bytes(folder.path(), "again/aligned.csv"),
        "nothing of the truth is used"
    );
    // What is aligned stays where it is.
    let once = ["--measured", "own/measured.f32", "--views", "again/aligned.csv", "--output", "twice"];
    succeed(folder.path(), &[volume, &once].concat());
    let twice = self::report(folder.path(), "twice/align.json");
    for (first, second) in of_views(&report, "aligned").iter().zip(of_views(&twice, "aligned")) {
        assert!((0..5).all(|k| (first[k] - second[k]).abs() < 2e-3), "{first:?} {second:?}");
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["align", "--check", "--phantom", "thorax", "--voxels", "40"];
    let text = succeed(folder.path(), &arguments);
    for word in ["float64", "float32", "JᵀJ", "between kinks' sides", "passed"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let json = succeed(folder.path(), &[&arguments[..], &["--json"]].concat());
    let report: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(report["passed"], true);
    let rows = report["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 13, "steps and exact, float64 and float32, three each, and kinks");
    for row in rows {
        let (error, bound) = (row["relative_error"].as_f64().expect("a number"), &row["bound"]);
        assert!(error < if row["precision"] == "float64" { 1e-7 } else { 1e-4 }, "{row}");
        assert!(row["rays"].as_u64().expect("a count") > 0 && bound.as_f64() > Some(0.0), "{row}");
    }
    assert_eq!(files(folder.path()).len(), 0, "no files");
}

#[test]
fn bad_arguments_of_alignment_exit_with_2_and_name_themselves() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("short.f32"), [0; 12]).expect("written");
    let header = "alpha_degrees,beta_degrees,phi_degrees,dx_mm,dz_mm";
    std::fs::write(folder.path().join("one.csv"), format!("{header}\n0,0,0,0,0\n")).expect("written");
    std::fs::write(folder.path().join("bad.csv"), format!("{header}\n0,0,nan,0,0\n")).expect("written");
    std::fs::write(folder.path().join("nan.f32"), f32::NAN.to_le_bytes().repeat(9)).expect("written");
    let phantom = ["align", "--phantom", "water_cylinder", "--voxels", "8"];
    let cases: [(&str, &[&str]); 17] = [
        ("--phantom", &["--ct", "ct.nii"]),
        ("--kev", &["--kev", "0"]),
        ("--kev", &["--kev", "1e9"]),
        ("--count", &["--count", "0"]),
        ("--max-degrees", &["--max-degrees", "-1"]),
        ("--max-mm", &["--max-mm", "nan"]),
        ("--photons", &["--photons", "-5"]),
        ("--levels", &["--levels", "0"]),
        ("--size", &["--size", "0x4"]),
        ("--pixel", &["--pixel", "0"]),
        ("--threads", &["--threads", "100000"]),
        ("--views", &["--measured", "short.f32"]),
        ("--measured", &["--views", "one.csv"]),
        ("--measured", &["--measured", "short.f32", "--views", "one.csv"]),
        ("--measured", &["--measured", "nan.f32", "--views", "one.csv", "--size", "3x3"]),
        ("--views", &["--measured", "short.f32", "--views", "bad.csv"]),
        ("--check", &["--check", "--raw"]),
    ];
    for (name, arguments) in cases {
        let output = drr(folder.path(), &[&phantom[..], arguments].concat());
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.starts_with("error: ") && error.contains(name), "{arguments:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{arguments:?}: {error}");
    }
}

#[test]
fn what_does_not_determine_a_view_is_warned_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let own = ["align", "--phantom", "spheres", "--voxels", "16", "--count", "2", "--output", "out"];
    for (more, said) in [
        (&["--size", "1x1", "--max-degrees", "0.1"][..], "did not converge"),
        // Hardly a photon: steps leave the range of parameters.
        (&["--photons", "1e-5"], ""),
    ] {
        let output = drr(folder.path(), &[&own[..], more].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && error.contains(said), "{more:?}: {error}");
        let text = std::fs::read_to_string(folder.path().join("out/align.json")).expect("written");
        // A loss with kinks may end where no step lowers it, which is no reason to warn.
        assert!(text.contains("\"converged\": false") || !error.contains("did not converge"), "{text}");
    }
    let output = drr(folder.path(), &[&own[..], &["--pixel", "1e-300"]].concat());
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(error.contains("--pixel is 1e-300; valid: mm"), "{error}");
}
