//! Where an object is, from images of it.

use super::*;

#[test]
fn a_hidden_motion_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let own = ["register", "--size", "48x48", "--angles", "-6,90", "--photons", "1e5", "--max-degrees", "3"];
    let capture = ["--max-mm", "6", "--capture-range", "2", "--distances", "2,8", "--output", "out"];
    let text = succeed(folder.path(), &[&own[..], &capture].concat());
    for word in
        ["hidden", "mTRE", "sigma", "capture range", "end within 2 mm", "median left", "; at a minimum"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
    let names = [
        "capture_range.png",
        "capture_range.svg",
        "convergence.png",
        "convergence.svg",
        "register.json",
        "views.png",
    ];
    assert_eq!(files(&folder.path().join("out")), names);
    let report: serde_json::Value =
        serde_json::from_slice(&bytes(folder.path(), "out/register.json")).expect("JSON");
    let number = |value: &serde_json::Value| value.as_f64().unwrap_or_else(|| panic!("a number: {report}"));
    let [before, after] = [0, 1].map(|k| number(&report["mtre_mm"][k]));
    assert!(before > 3.0 && after < 0.5, "{before} {after}");
    for k in 0..6 {
        let [hidden, found, sigma] =
            ["hidden", "found", "standard_deviations"].map(|name| number(&report[name][k]));
        // Photons' noise, and pixels and voxels that are not the exact integral's.
        let most = 10.0 * sigma + if k < 3 { 0.05 } else { 0.1 };
        assert!((hidden - found).abs() < most, "{k}: {hidden} {found} {sigma}");
    }
    let rows = report["capture"]["rows"].as_array().expect("a row per distance");
    assert_eq!(
        (rows.len(), rows[0]["starts"].as_u64(), rows[0]["successes"].as_u64()),
        (2, Some(2), Some(2))
    );
}

#[test]
fn measured_images_need_no_truth() {
    let folder = write_inputs();
    let size = ["--size", "24x20", "--pixel", "6"];
    project(folder.path(), &[&RAW, &["--raw", "--layers", "line_integral", "--output", "own"]]);
    let both: Vec<u8> =
        (0..2).flat_map(|n| bytes(folder.path(), &format!("own/view{n}_line_integral.f32"))).collect();
    std::fs::write(folder.path().join("both.f32"), both).expect("written");
    let own = ["register", "--measured", "both.f32", "--levels", "1", "--output", "out"];
    let text = succeed(folder.path(), &[&own[..], &RAW, &SMALL].concat());
    assert!(!text.contains("mTRE") && text.contains("sigma"), "{text}");
    let output = drr(folder.path(), &[&own[..], &RAW, &size].concat());
    assert_eq!(output.status.code(), Some(2), "another number of pixels");
    assert!(String::from_utf8_lossy(&output.stderr).contains("--measured"));
    std::fs::write(folder.path().join("both.f32"), f32::NAN.to_le_bytes().repeat(2 * 24 * 20))
        .expect("written");
    let output = drr(folder.path(), &[&own[..], &RAW, &SMALL].concat());
    assert_eq!(output.status.code(), Some(2), "not finite");
    assert!(String::from_utf8_lossy(&output.stderr).contains("--measured"));
}

#[test]
fn bad_arguments_of_register_exit_with_2_and_name_themselves() {
    let folder = write_inputs();
    let cases: [(&str, &[&str]); 6] = [
        ("--max-degrees", &["--max-degrees", "-1"]),
        ("--max-mm", &["--max-mm", "nan"]),
        ("--photons", &["--photons", "-5"]),
        ("--levels", &["--levels", "6", "--size", "20x20"]),
        ("--distances", &["--capture-range", "1", "--distances", "0"]),
        ("--capture-range", &["--distances", "5"]),
    ];
    for (name, own) in cases {
        let arguments = [&["register", "--output", "out"], &RAW[..], own].concat();
        let output = drr(folder.path(), &arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.starts_with("error: ") && error.contains(name), "{arguments:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{arguments:?}: {error}");
    }
}

#[test]
fn a_source_inside_the_volume_is_refused_and_no_photons_tell_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let own = ["register", "--size", "24x24", "--output", "out"];
    let output = drr(folder.path(), &[&own[..], &["--sad", "1", "--sdd", "2"]].concat());
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() != Some(0) && error.contains("--sad is 1 and --sdd 2"), "{error}");
    let output = drr(folder.path(), &[&own[..], &["--photons", "1e-9"]].concat());
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && error.contains("did not converge"), "{error}");
}
