//! `drr bench --scaling`: which points it measures, and where it writes them. Times are nobody's promise.

use super::*;

fn report(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let all = [&["bench", "--json", "--repeat", "2", "--threads", "3"], arguments].concat();
    serde_json::from_str(&succeed(folder, &all)).expect("one JSON object")
}

#[test]
fn scaling_measures_growing_counts_and_draws_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let report = report(folder.path(), &["--scaling", "16,24,3", "--output", "grown"]);
    assert_eq!((&report["engine"], &report["threads"]), (&"cpu".into(), &3.into()));
    let expected = [
        ("threads", "4³ voxels, 6² pixels, 1 view", vec![1, 2, 3]),
        ("pixels per side", "4³ voxels, 1 view", vec![2, 3, 6, 12, 24]),
        ("voxels per side", "6² pixels, 1 view", vec![2, 4, 8, 16]),
        ("views", "4³ voxels, 6² pixels", vec![1, 2, 3]),
    ];
    let all = report["series"].as_array().expect("series");
    assert_eq!(all.len(), expected.len());
    for (sweep, (of, held, counts)) in all.iter().zip(expected) {
        assert_eq!((sweep["of"].as_str(), sweep["held"].as_str()), (Some(of), Some(held)));
        let steps = sweep["steps"].as_array().expect("steps");
        assert_eq!(steps.iter().map(|step| step["count"].clone()).collect::<Vec<_>>(), counts, "{of}");
        let number = |step: &serde_json::Value, name: &str| step[name].as_f64().expect("a number");
        let power = number(sweep, "power");
        let largest = if power < 0.0 { &steps[0] } else { &steps[steps.len() - 1] };
        for step in steps {
            assert_eq!(step["runs"], 2);
            let [least, median, most] =
                ["min_seconds", "median_seconds", "max_seconds"].map(|name| number(step, name));
            assert!(0.0 < least && least <= median && median <= most, "{of}: {step}");
            let work = (number(step, "count") / number(largest, "count")).powf(power);
            let proportional = number(step, "proportional_seconds") / number(largest, "median_seconds");
            assert!((proportional / work - 1.0).abs() < 1e-12, "{of}: {step}");
        }
    }
    let grown = folder.path().join("grown");
    assert_eq!(files(&grown), ["scaling.json", "scaling.png", "scaling.svg"]);
    let written: serde_json::Value = serde_json::from_slice(&bytes(&grown, "scaling.json")).expect("JSON");
    assert_eq!(written, report);
    let svg = String::from_utf8(bytes(&grown, "scaling.svg")).expect("text");
    for text in ["threads", "pixels per side", "voxels per side", "views", "4³ voxels, 6² pixels, 1 view"] {
        assert!(svg.contains(text), "{text}");
    }
}
