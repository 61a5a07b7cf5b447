//! The report of a run.

use base64::Engine as _;
use roxmltree::{Document, ParsingOptions};

use super::*;

/// A name that is dangerous to everything that does not escape it.
const NAME: &str = "<script>alert('&')<.nii.gz";

fn report(folder: &TempDir, others: &[&str]) -> String {
    std::fs::copy(folder.path().join("ct.nii.gz"), folder.path().join(NAME)).expect("copied");
    project(folder.path(), &[&["--ct", NAME, "--report", "--output", "out"], &LAYERS, others]);
    String::from_utf8(bytes(folder.path(), "out/report.html")).expect("UTF-8")
}

fn parsed(html: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(html, options).expect("well-formed")
}

fn texts(document: &Document<'_>) -> String {
    document
        .descendants()
        .filter_map(|node| node.is_text().then(|| node.text()).flatten())
        .collect::<Vec<_>>()
        .join("\n")
}

/// Every number, text and truth value.
fn leaves(value: &serde_json::Value) -> Vec<String> {
    match value {
        serde_json::Value::Object(object) => object.values().flat_map(leaves).collect(),
        serde_json::Value::Array(values) => values.iter().flat_map(leaves).collect(),
        serde_json::Value::Null => Vec::new(),
        serde_json::Value::String(text) => vec![text.clone()],
        other => vec![other.to_string()],
    }
}

#[test]
fn a_report_has_everything_that_a_run_says() {
    let folder = write_inputs();
    let html = report(&folder, &["--photons", "5000", "--fall-off"]);
    let document = parsed(&html);
    let text = texts(&document);
    let titles: Vec<_> =
        document.descendants().filter(|n| n.has_tag_name("h2")).filter_map(|n| n.text()).collect();
    assert_eq!(titles, ["Warnings", "Pictures", "Error", "Plan", "Time", "Provenance"]);
    let plan: serde_json::Value =
        serde_json::from_slice(&bytes(folder.path(), "out/plan.json")).expect("JSON");
    let stated = leaves(&plan);
    assert!(stated.len() > 30, "{stated:?}");
    for value in stated {
        assert!(text.contains(&value), "{value}");
    }
    let metadata = drr::formats::read_exr_metadata(&folder.path().join("out/view1.exr")).expect("OpenEXR");
    for (name, value) in metadata {
        // Vectors stand in a table, with commas.
        let vector = value.split(' ').all(|part| part.parse::<f64>().is_ok()) && value.contains(' ');
        assert!(vector || text.contains(&value), "{name}: {value}");
    }
    for word in
        ["24 × 20 × 18", "2, 2.5, 3 mm", "--photons 5000", "RMSE", "rays/s", "projecting", "g/cm\u{b2}"]
    {
        assert!(text.contains(word), "{word}");
    }
}

#[test]
fn a_report_is_one_file_that_asks_for_nothing_and_runs_nothing() {
    let folder = write_inputs();
    let html = report(&folder, &[]);
    let document = parsed(&html);
    assert!(texts(&document).contains(NAME), "the name is there, as text");
    for node in document.descendants().filter(roxmltree::Node::is_element) {
        assert!(
            !["script", "link", "iframe", "object", "embed"].contains(&node.tag_name().name()),
            "{node:?}"
        );
        for attribute in node.attributes() {
            assert!(!attribute.name().starts_with("on") && attribute.name() != "href", "{attribute:?}");
        }
    }
    assert!(!["http:", "https:", "url(", "@import"].iter().any(|outside| html.contains(outside)));
    // One large picture, and of both views seven layers.
    let images: Vec<_> = document.descendants().filter(|node| node.has_tag_name("img")).collect();
    assert_eq!(images.len(), 1 + 2 * 7);
    for image in images {
        let source = image.attribute("src").expect("a source");
        let coded = source.strip_prefix("data:image/png;base64,").expect("in the file itself");
        let png = base64::engine::general_purpose::STANDARD.decode(coded).expect("base64");
        let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().expect("PNG");
        let stated = ["width", "height"].map(|side| image.attribute(side).and_then(|n| n.parse().ok()));
        assert_eq!([reader.info().width, reader.info().height].map(Some), stated);
        assert!(!image.attribute("alt").expect("words").is_empty());
    }
}

#[test]
fn a_report_stays_small_and_tells_of_what_it_does_not_show() {
    let folder = write_inputs();
    let angles: Vec<String> = (0..9).map(|n| (20 * n).to_string()).collect();
    let own = ["project", "--angles", &angles.join(","), "--size", "620x300", "--pixel", "0.2", "--report"];
    succeed(folder.path(), &[&own[..], &RAW, &["--output", "out", "--no-check"]].concat());
    let html = String::from_utf8(bytes(folder.path(), "out/report.html")).expect("UTF-8");
    assert!(html.len() < 4 << 20, "{}", html.len());
    let text = texts(&parsed(&html));
    assert!(text.contains("3 more view(s)") && text.contains("not measured"), "{text}");
}

#[test]
fn a_report_repeats_warnings_and_is_written_on_request_alone() {
    let folder = write_inputs();
    let far = ["--ct", "ct.raw", "--dims", "24,20,18", "--spacing", "2,2,2", "--output", "out"];
    let pose = DetectorPose::c_arm(DVec3::splat(9000.0), 0.0, 1000.0, 1500.0, 6.0, [22, 14]);
    let geometry = GeometryFile { width: 22, height: 14, views: vec![pose] };
    geometry.write(&folder.path().join("away.json")).expect("written");
    let run = |others: &[&str]| {
        drr(folder.path(), &[&["project", "--geometry", "away.json"], &far[..], others].concat())
    };
    assert!(run(&[]).status.success() && !folder.path().join("out/report.html").exists());
    let output = run(&["--report"]);
    let warning = String::from_utf8_lossy(&output.stderr).into_owned();
    let words = warning.trim().strip_prefix("warning: ").expect("one warning");
    let html = String::from_utf8(bytes(folder.path(), "out/report.html")).expect("UTF-8");
    assert!(output.status.success() && texts(&parsed(&html)).contains(words), "{warning}");
    // Views of a table are not held together.
    std::fs::write(folder.path().join("views.csv"), "angle_degrees\n0\n").expect("written");
    let output = drr(folder.path(), &["project", "--views", "views.csv", "--report"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--report"));
}
