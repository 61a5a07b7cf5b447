//! The header is the reference of the C ABI: of every function it says who owns what, how long things live, in which units
//! and shapes they come, how the call fails, and which threads may make it. Rules for all are in its frame; a function
//! that is as another has its answers.

use std::collections::{BTreeMap, BTreeSet};

use libtest_mimic::Failed;

use crate::header::{Declared, Header};

const TEXT: &str = include_str!("../../include/DRR_Shared.h");

/// Words of which an answer has one.
const THREADS: &[&str] = &["thread"];
const FAILURE: &[&str] =
    &["Fails", "fails with", "Cannot fail", "never NULL", "Never NULL", "NULL, with a message"];
const LIFETIME: &[&str] = &["A static string", "lives as long", "valid until"];
const UNITS: &[&str] =
    &["mm", "keV", "degrees", "g/cm^2", "cm^2/g", "HU", "dimensionless", "radians", "unit", "photons"];
const SHAPE: &[&str] = &[
    " per ",
    "one for each",
    "values",
    "numbers",
    "`energy_count`",
    "`view_count`",
    "are 5",
    "are 6",
    "is an image",
    "place for",
    "as many",
];
/// What says in a parameter's name in which unit it is.
const UNIT_OF_A_NAME: [&str; 4] = ["_mm", "_kev", "_degrees", "_voxels"];
/// Types whose values or elements are numbers, or structs that come in arrays.
const NUMBERS: [&str; 4] = ["float", "double", "int16_t", "uint8_t"];
const ELEMENTS: [&str; 4] = ["DrrDetectorPose", "ProjectionUniforms", "DrrWorldRay", "DrrRaySpan"];

/// The comment above each function and each field, `Struct.field`.
fn comments() -> BTreeMap<String, String> {
    let mut comments = BTreeMap::new();
    let (mut comment, mut inside) = (String::new(), None);
    for line in TEXT.lines().map(str::trim) {
        if let Some(text) = line.strip_prefix("///") {
            comment += text;
            continue;
        }
        let word_before = |end: &str| {
            let text = &line[..line.find(end)?];
            let start = text.rfind(|c: char| !c.is_alphanumeric() && c != '_').map_or(0, |at| at + 1);
            Some(text[start..].to_owned())
        };
        if let Some(name) = line.strip_prefix("typedef struct ").and_then(|line| line.strip_suffix(" {")) {
            inside = Some(name.to_owned());
        } else if line.starts_with('}') {
            inside = None;
        } else if let (Some(whole), true) = (&inside, line.ends_with(';')) {
            let field = word_before("[").or_else(|| word_before(";")).unwrap_or_default();
            comments.insert(format!("{whole}.{field}"), std::mem::take(&mut comment));
        } else if let Some(name) = word_before("(").filter(|name| name.starts_with("drr_")) {
            comments.insert(name, std::mem::take(&mut comment));
        }
        comment.clear();
    }
    comments
}

/// A function's comment, with those of the functions that it says it is as.
fn answers(name: &str, comments: &BTreeMap<String, String>) -> String {
    let (mut seen, mut open, mut text) = (BTreeSet::new(), vec![name.to_owned()], String::new());
    while let Some(name) = open.pop() {
        let Some(comment) = comments.get(&name).filter(|_| seen.insert(name.clone())) else { continue };
        text = text + comment + " ";
        let as_another = comment.split("s drr_").skip(1).zip(comment.split("s drr_"));
        let others = as_another.filter(|(_, before)| before.ends_with(['A', 'a'])).map(|(after, _)| after);
        open.extend(others.map(|after| {
            let end = after.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(after.len());
            format!("drr_{}", &after[..end])
        }));
    }
    text
}

fn has(text: &str, words: &[&str]) -> bool {
    words.iter().any(|word| text.contains(word))
}

/// What the text leaves unanswered of a parameter of a function that is told how many of something there are, or is not.
fn unanswered(parameter: &Declared, counted: bool, text: &str) -> Option<String> {
    let Declared { ctype, name, .. } = parameter;
    let pointee = ctype.trim_start_matches("const ").trim_end_matches(['*', ' ']);
    let quoted = [format!("`{name}`"), format!("`*{name}`")];
    let mut naming =
        text.split_inclusive(['.', ';']).filter(|part| quoted.iter().any(|name| part.contains(name)));
    if ctype.ends_with("**") {
        let destroyed = has(text, &["new handle"]) && has(text, &["_destroy"]);
        return (!destroyed).then(|| format!("owner of {name}"));
    }
    if !ctype.ends_with('*') {
        let stated = ctype != "double" || UNIT_OF_A_NAME.iter().any(|unit| name.ends_with(unit));
        return (!stated).then(|| format!("unit of {name}"));
    }
    let array = NUMBERS.contains(&pointee) || counted && ELEMENTS.contains(&pointee);
    if array && !naming.any(|part| has(part, SHAPE)) && !text.contains(&format!("{name}[")) {
        return Some(format!("shape of {name}"));
    }
    (ctype == "void *" && !quoted.iter().any(|name| text.contains(name))).then(|| format!("what {name} is"))
}

/// Every function answers, and every number in a struct has a unit or a meaning of its own.
pub(super) fn is_complete() -> Result<(), Failed> {
    let (header, comments) = (Header::read(), comments());
    let mut missing = Vec::new();
    for (name, function) in &header.functions {
        let text = answers(name, &comments);
        let mut ask = |question: &str, answered: bool| {
            if !answered {
                missing.push(format!("{name}: {question}"));
            }
        };
        ask("threads", has(&text, THREADS));
        ask("failure", has(&text, FAILURE));
        ask("lifetime of what is returned", !function.returns.ends_with('*') || has(&text, LIFETIME));
        ask("units", !function.parameters.iter().any(|p| p.ctype.ends_with("double *")) || has(&text, UNITS));
        let counted = function.parameters.iter().any(|parameter| parameter.name.ends_with("_count"));
        let open = function.parameters.iter().filter_map(|parameter| unanswered(parameter, counted, &text));
        missing.extend(open.map(|question| format!("{name}: {question}")));
    }
    for (name, fields) in &header.structs {
        let undescribed = fields.iter().map(|field| format!("{name}.{}", field.name));
        missing.extend(undescribed.filter(|field| comments.get(field).is_none_or(String::is_empty)));
    }
    if missing.is_empty() { Ok(()) } else { Err(missing.join("\n").into()) }
}
