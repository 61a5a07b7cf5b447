//! `drr check`, as its user runs it: every hard case, on every engine, with every algorithm, within its bound.
#![cfg(feature = "command")]
#![allow(missing_docs, reason = "a test program")]

use std::collections::{BTreeMap, BTreeSet};
use std::process::{Command, Output};

use serde_json::Value;

/// Files and derivatives: no ray of today's engines can show them.
const WITHOUT_RAYS: [u64; 2] = [24, 25];

fn check(arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_drr")).arg("check").args(arguments).output();
    output.expect("the command starts")
}

fn text(row: &Value, key: &str) -> String {
    row[key].as_str().unwrap_or_else(|| panic!("{key} of {row}")).to_owned()
}

#[test]
fn every_case_holds_on_every_engine_with_every_algorithm() {
    let output = check(&["--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let rows = report["rows"].as_array().expect("rows");
    let failed: Vec<_> = rows.iter().filter(|row| row["holds"] != true).map(Value::to_string).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
    assert!(output.status.success() && report["holds"] == true);

    let mut cases: BTreeMap<(u64, String), Vec<[String; 3]>> = BTreeMap::new();
    for row in rows {
        let case = (row["family"].as_u64().expect("a number"), text(row, "case"));
        cases.entry(case).or_default().push(["engine", "algorithm", "layer"].map(|key| text(row, key)));
    }
    let refused = |rows: &[[String; 3]]| rows.iter().any(|[_, _, layer]| layer == "refusal");
    let projected = cases.values().filter(|rows| !refused(rows)).count();
    assert!(cases.len() > 300 && projected > 300, "{} cases, {projected} of them projected", cases.len());
    for family in (1..=28).filter(|family| !WITHOUT_RAYS.contains(family)) {
        assert!(cases.keys().any(|(of, _)| *of == family), "family {family} is without a case");
    }
    for ((_, name), rows) in &cases {
        let mut pairs: Vec<_> =
            rows.iter().map(|[engine, algorithm, _]| format!("{engine} {algorithm}")).collect();
        pairs.sort();
        let every = [
            "cpu joseph",
            "cpu march",
            "cpu siddon",
            "reference exact",
            "reference joseph",
            "reference march",
            "reference siddon",
        ];
        let once = ["cpu any", "reference any"];
        assert_eq!(pairs, if refused(rows) { once.to_vec() } else { every.to_vec() }, "{name}");
    }
}

/// The page of the hard cases lists each family as the program does.
#[test]
fn the_page_lists_every_family() {
    let report: Value =
        serde_json::from_slice(&check(&["--json", "--family", "2"]).stdout).expect("one JSON object");
    let page = include_str!("../src/bin/drr/check/README.md");
    let titles = report["families"].as_array().expect("titles");
    assert_eq!(titles.len(), 28);
    for (n, title) in titles.iter().enumerate() {
        let line = format!("| {} | {} |", n + 1, title.as_str().expect("text"));
        assert!(page.contains(&line), "no row begins with {line}");
    }
}

#[test]
fn cases_are_chosen_by_family_and_by_name() {
    let one = check(&["--only", "ten voxels along x"]);
    let table = String::from_utf8(one.stdout).expect("text");
    assert_eq!(table.lines().filter(|line| line.ends_with("holds")).count(), 7, "{table}");
    let second: Value = serde_json::from_slice(&check(&["--json", "--family", "2,9"]).stdout).expect("JSON");
    let families: BTreeSet<_> =
        second["rows"].as_array().expect("rows").iter().map(|row| row["family"].as_u64()).collect();
    assert_eq!(families, [Some(2), Some(9)].into());
    let none = check(&["--only", "no such case"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&none.stderr).contains("no such case"));
    assert_eq!(check(&["--family", "29"]).status.code(), Some(2));
}
