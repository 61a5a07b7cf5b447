//! Effects, as a user asks for them.

use exr::prelude::read_all_flat_layers_from_file;

use super::*;

/// Every effect, on both layers of a panel.
const ALL: [&str; 22] = [
    "--fall-off",
    "--heel",
    "12,5,90",
    "--filter",
    "copper:0.1",
    "--bow-tie",
    "aluminium:bowtie.csv",
    "--implant",
    "rod:titanium:5,25,30:25,35,40:3",
    "--implant",
    "screw:steel_316l@7.9:10,30,20:0,0,1:4/3,20/1.5",
    "--focal-spot",
    "1.2x0.6",
    "--scatter",
    "2000",
    "--blur",
    "0.9:2,0.1:12",
    "--fill-factor",
    "0.7",
    "--photons",
    "20000",
    "--noise-seed=3",
];
const PANEL: [&str; 2] = ["--detector", "top_energy,bottom_energy"];

fn inputs() -> TempDir {
    let folder = write_inputs();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("bowtie.csv", "degrees,mm\n-5,8\n0,1\n5,8\n");
    write("mtf.csv", "per_mm,mtf\n0,1\n0.05,0.9\n0.1,0.7\n");
    write("steep.csv", "per_mm,mtf\n0,1\n0.05,1\n0.1,0\n");
    write("curve.csv", "angle,mm\n0,1\n");
    folder
}

#[test]
fn both_layers_of_a_detector_have_names_of_their_own() {
    let folder = inputs();
    let text = project(folder.path(), &[&RAW, &ALL, &PANEL, &["--raw", "--output", "out"]]);
    for word in ["of which ray march", "scatter kernels", "noise", "before effects", "compound Poisson"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let out = folder.path().join("out");
    let file = read_all_flat_layers_from_file(out.join("view1.exr")).expect("OpenEXR");
    let layer = &file.layer_data[0];
    let names: Vec<_> = layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    let of = |name: &str| ["bottom_energy", "top_energy"].map(|layer| format!("{name}.{layer}"));
    assert_eq!(names, [of("intensity"), of("line_integral")].concat());
    let attribute = |name: &str| {
        let found = layer.attributes.other.iter().find(|(key, _)| *key == name);
        format!("{:?}", found.unwrap_or_else(|| panic!("{name}")).1)
    };
    for effect in ["fall-off", "heel", "copper", "bow-tie", "implant", "focal spot", "scatter", "noise"] {
        assert!(attribute("drr.effects").contains(effect), "{effect}");
    }
    let [top, bottom] =
        ["top", "bottom"].map(|layer| f32s(&out, &format!("view1_intensity_{layer}_energy.f32")));
    assert_eq!((top.len(), bottom.len()), (22 * 14, 22 * 14));
    let open = |values: &[f32]| f64::from(values[0]);
    assert!(open(&top) > open(&bottom), "the lower layer has what the upper one leaves");
    let picture = std::fs::File::open(out.join("radiograph.png")).expect("a picture");
    let picture = png::Decoder::new(std::io::BufReader::new(picture)).read_info().expect("PNG");
    assert_eq!(picture.info().width, 4 * 22 + 3 * 2, "two layers of two views, and gaps");
}

#[test]
fn the_same_layer_twice_is_told_apart_by_its_place() {
    let folder = inputs();
    let detector = ["--detector", "top_counting,top_counting", "--raw", "--output", "out"];
    project(folder.path(), &[&RAW, &detector]);
    let at = |n: usize| f32s(folder.path(), &format!("out/view0_line_integral_top_counting_{n}.f32"));
    assert_eq!(at(1), at(2));
    assert!(!files(&folder.path().join("out")).iter().any(|name| name.ends_with("line_integral.f32")));
}

#[test]
fn a_plan_lists_effects_with_times_and_what_is_left_out() {
    let folder = inputs();
    let own = [&["plan", "--measure", "--json"], &RAW[..], &SMALL, &ALL, &PANEL].concat();
    let plan: serde_json::Value = serde_json::from_str(&succeed(folder.path(), &own)).expect("JSON");
    let stages = plan["stages"].as_array().expect("stages");
    let find = |name: &str| stages.iter().find(|s| s["name"] == name).unwrap_or_else(|| panic!("{name}"));
    for name in ["ray march", "spectrum", "scatter", "detector blur", "pixels", "noise"] {
        for key in ["seconds", "measured_seconds"] {
            assert!(find(name)[key].as_f64().expect(key) > 0.0, "{name} {key}");
        }
    }
    for name in ["source", "implants"] {
        assert!(find(name)["seconds"].as_f64().expect("predicted") > 0.0, "{name}");
    }
    assert!(plan["measured_seconds"].as_f64().expect("in all") > 0.0);
    let again = own.iter().copied().filter(|a| *a != "--measure").collect::<Vec<_>>();
    let plan = succeed(folder.path(), &again);
    assert!(!plan.contains("measured"), "{plan}");
    assert_eq!(plan, succeed(folder.path(), &again), "the same every time");
    // Over a few mm of the detector the fall-off is nothing.
    let little = ["plan", "--size", "22x14", "--pixel", "1", "--tolerance-hu", "50", "--fall-off"];
    let text = succeed(folder.path(), &[&little, &RAW[..]].concat());
    assert!(text.contains("skip  fall-off") && text.contains("are allowed"), "{text}");
    assert!(text.contains("not asked for  heel effect, filters"), "{text}");
}

#[test]
fn a_measured_mtf_is_a_blur_and_warns_where_it_fits_ill() {
    let folder = inputs();
    let own = |mtf: &str| drr(folder.path(), &[&["plan", "--mtf", mtf], &RAW[..], &SMALL].concat());
    let fits = own("mtf.csv");
    assert!(String::from_utf8_lossy(&fits.stdout).contains("detector blur"));
    let ill = own("steep.csv");
    assert!(ill.status.success());
    assert!(String::from_utf8_lossy(&ill.stderr).contains("off by up to"));
}

#[test]
fn bad_effects_exit_with_2_and_name_themselves() {
    let folder = inputs();
    let cases: [(&str, &[&str]); 24] = [
        ("--heel", &["--heel", "90"]),
        ("--heel", &["--heel", "a,b"]),
        ("--filter", &["--filter", "copper"]),
        ("unobtainium", &["--filter", "unobtainium:1"]),
        ("--bow-tie", &["--bow-tie", "aluminium:missing.csv"]),
        ("valid: degrees,mm", &["--bow-tie", "aluminium:curve.csv"]),
        ("--implant", &["--implant", "cube:titanium:0,0,0:1"]),
        ("sphere:MATERIAL", &["--implant", "sphere:titanium:0,0:1"]),
        ("--implant", &["--implant", "sphere:titanium@99:0,0,0:1"]),
        ("--focal-spot", &["--focal-spot", "0"]),
        ("--focal-spot", &["--focal-spot", "0.6x"]),
        ("--focal-spot", &["--focal-spot", "10", "--pixel", "0.01"]),
        ("--scatter", &["--scatter", "10"]),
        ("--blur", &["--blur", "0.5:0.2"]),
        ("--mtf", &["--blur", "0.2", "--mtf", "mtf.csv"]),
        ("--mtf", &["--mtf", "curve.csv"]),
        ("--fill-factor", &["--fill-factor", "1.5"]),
        ("--photons", &["--photons", "0"]),
        ("needs a dose", &["--electronic-noise", "5"]),
        ("--noise-seed", &["--noise-seed", "5"]),
        ("--electronic-noise", &["--photons", "9", "--electronic-noise", "-1"]),
        ("--detector", &["--detector", "top_energy,bottom_energy,ideal"]),
        ("--photons", &["--photons", "1e13"]),
        ("--noise-seed", &["--photons", "9", "--noise-seed", "-1"]),
    ];
    let many = (0..5).map(|n| ["titanium", "copper", "pmma", "steel_316l", "water"][n]);
    let many: Vec<String> = many.flat_map(|m| ["--implant".into(), format!("sphere:{m}:0,0,0:1")]).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    for (name, own) in cases.into_iter().chain([("9 materials", &many[..])]) {
        let arguments = [&["plan"], &RAW[..], &SMALL[..2], own].concat();
        let output = drr(folder.path(), &arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.starts_with("error: ") && error.contains(name), "{arguments:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{arguments:?}: {error}");
    }
    for command in ["tradeoff", "effects"] {
        let output = drr(folder.path(), &[command, "--fall-off"]);
        assert_eq!(output.status.code(), Some(2), "{command}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("an effect"), "{command}");
    }
}

#[test]
fn effects_are_timed_one_after_the_other() {
    let folder = inputs();
    let own =
        [&["effects", "--runs", "1", "--size", "40x40", "--pixel", "3", "--output", "a"], &RAW[..]].concat();
    let text = succeed(folder.path(), &own);
    let names = ["cost.png", "cost.svg", "effects.json", "effects.png"];
    assert_eq!(files(&folder.path().join("a")), names);
    let report: serde_json::Value =
        serde_json::from_slice(&bytes(folder.path(), "a/effects.json")).expect("JSON");
    let effects = report["effects"].as_array().expect("effects");
    for name in [
        "fall-off",
        "heel",
        "filter",
        "bow-tie",
        "implant",
        "focal spot, points",
        "scatter",
        "dual layer",
        "scatter, first time",
        "detector blur",
        "fill factor",
        "noise, counting",
        "everything",
        "another spectrum",
    ] {
        let row =
            effects.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("{name}: {report}"));
        assert!(row["median_seconds"].as_f64().expect("a number") > 0.0);
        assert!(text.contains(name), "{text}");
    }
    let plain = report["plain_seconds"].as_f64().expect("a number");
    let heel = effects.iter().find(|row| row["name"] == "heel").expect("there");
    let [seconds, ratio] = ["median_seconds", "ratio"].map(|key| heel[key].as_f64().expect("a number"));
    assert!((ratio - seconds / plain).abs() < 1e-9);
    let other = [&own[..8], &["b", "--json", "--with", "a/effects.json"], &RAW[..]].concat();
    let again: serde_json::Value = serde_json::from_str(&succeed(folder.path(), &other)).expect("JSON");
    assert_eq!(again["effects"].as_array().map(Vec::len), Some(effects.len()));
    let svg = String::from_utf8(bytes(folder.path(), "b/cost.svg")).expect("text");
    assert_eq!(svg.matches(": plain ").count(), 2, "a legend for each");
    let output = drr(folder.path(), &["effects", "--with", "bowtie.csv"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("--with"));
}
