//! `drr check`, as its user runs it: every hard case, on every engine, with every algorithm, within its bound.
#![cfg(feature = "command")]
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::collections::{BTreeMap, BTreeSet};
use std::process::{Command, Output};

use drr::Context;
use drr::engine::Backend;
use serde_json::Value;
use support::host_compiler;
use support::needing::every_tool_is_required;

/// Files and derivatives: no ray of today's engines can show them.
const WITHOUT_RAYS: [u64; 2] = [24, 25];

fn check(arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_drr")).arg("check").args(arguments).output();
    output.expect("the command starts")
}

fn text(row: &Value, key: &str) -> String {
    row[key].as_str().unwrap_or_else(|| panic!("{key} of {row}")).to_owned()
}

/// The engines of this machine.
fn engines() -> Vec<Backend> {
    let there = |backend: Backend| match backend {
        Backend::Host => match host_compiler() {
            Err(reason) if every_tool_is_required() => panic!("engine host: {reason}"),
            Err(reason) => {
                println!("without the engine host: {reason}");
                false
            }
            Ok(()) => true,
        },
        _ => Context::new(backend, 1).is_ok(),
    };
    Backend::ALL.into_iter().filter(|&backend| there(backend)).collect()
}

/// What an engine computes: "cpu joseph".
fn pairs(engine: Backend, algorithms: &[&str]) -> Vec<String> {
    algorithms.iter().map(|algorithm| format!("{} {algorithm}", engine.name())).collect()
}

#[test]
fn every_case_holds_on_every_engine_with_every_algorithm() {
    let engines = engines();
    let names: Vec<_> = engines.iter().map(|engine| engine.name()).collect();
    let output = check(&["--json", "--engine", &names.join(",")]);
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
    let algorithms = |engine: Backend| match engine {
        Backend::Reference => &["distance_driven", "exact", "joseph", "march", "siddon"][..],
        Backend::Cpu => &["distance_driven", "joseph", "march", "siddon"],
        _ => &["joseph", "march", "siddon"],
    };
    let every: BTreeSet<_> = engines.iter().flat_map(|&engine| pairs(engine, algorithms(engine))).collect();
    let once: BTreeSet<_> = engines.iter().flat_map(|&engine| pairs(engine, &["any"])).collect();
    for ((_, name), rows) in &cases {
        let each = rows.iter().map(|[engine, algorithm, _]| format!("{engine} {algorithm}"));
        let expected = if refused(rows) { &once } else { &every };
        assert_eq!(rows.len(), expected.len(), "{name}");
        assert_eq!(&each.collect::<BTreeSet<_>>(), expected, "{name}");
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
    let one = check(&["--only", "ten voxels along x", "--engine", "cpu,reference"]);
    let table = String::from_utf8(one.stdout).expect("text");
    assert_eq!(table.lines().filter(|line| line.ends_with("holds")).count(), 9, "{table}");
    let second: Value = serde_json::from_slice(&check(&["--json", "--family", "2,9"]).stdout).expect("JSON");
    let families: BTreeSet<_> =
        second["rows"].as_array().expect("rows").iter().map(|row| row["family"].as_u64()).collect();
    assert_eq!(families, [Some(2), Some(9)].into());
    let none = check(&["--only", "no such case"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&none.stderr).contains("no such case"));
    assert_eq!(check(&["--family", "29"]).status.code(), Some(2));
}
