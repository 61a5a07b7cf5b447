//! What the header declares, read from its text.

use std::collections::{BTreeMap, BTreeSet};

use libtest_mimic::Failed;

const TEXT: &str = include_str!("../../include/DRR_Shared.h");
/// Types whose spelling depends on the reader; the header itself asserts what their bytes are.
const SPELT_BY_READER: [&str; 3] = ["DrrAddress", "DrrFloat3", "DrrFloat4x4"];

/// A parameter or a field.
pub(super) struct Declared {
    pub(super) ctype: String,
    pub(super) name: String,
    /// Of an array its size, such as `[3]`; otherwise empty.
    pub(super) size: String,
}

impl Declared {
    /// From C, such as `const float *spectrum` or `double source[3]`.
    fn parse(text: &str) -> Option<Self> {
        let (text, size) = text.split_at(text.find('[').unwrap_or(text.len()));
        let start = text.rfind(|c: char| !c.is_alphanumeric() && c != '_')? + 1;
        Some(Self { ctype: ctype(&text[..start]), name: text[start..].to_owned(), size: size.to_owned() })
    }
}

/// What a function takes and gives.
pub(super) struct Function {
    pub(super) returns: String,
    pub(super) parameters: Vec<Declared>,
}

/// Everything that the header declares for hosts, by name.
#[derive(Default)]
pub(super) struct Header {
    pub(super) functions: BTreeMap<String, Function>,
    pub(super) structs: BTreeMap<String, Vec<Declared>>,
    /// Structs that only the library looks into.
    pub(super) handles: BTreeSet<String>,
    /// Names for types of C.
    pub(super) aliases: BTreeMap<String, String>,
    /// What is called back, as it is declared.
    pub(super) callbacks: BTreeMap<String, String>,
    pub(super) constants: BTreeSet<String>,
}

impl Header {
    /// The committed one.
    pub(super) fn read() -> Self {
        Self::parse(TEXT)
    }

    /// Whether every `typedef` of the text has been understood.
    pub(super) fn misses_no_type(&self) -> Result<(), Failed> {
        let is_spelt = |line: &&str| SPELT_BY_READER.iter().any(|name| line.ends_with(&format!(" {name};")));
        let types = TEXT.lines().filter(|line| line.starts_with("typedef ") && !is_spelt(line)).count();
        let found = self.structs.len() + self.handles.len() + self.aliases.len() + self.callbacks.len();
        if types == found {
            Ok(())
        } else {
            Err(format!("{found} of {types} types of the header are found").into())
        }
    }

    fn parse(text: &str) -> Self {
        let mut header = Self::default();
        let mut inside: Option<String> = None;
        let mut statement = String::new();
        let is_code = |line: &&str| !["/", "*", "extern "].iter().any(|start| line.trim().starts_with(start));
        for line in text.lines().filter(is_code) {
            let opened = line.strip_prefix("typedef struct ").and_then(|line| line.strip_suffix(" {"));
            if let Some(directive) = line.strip_prefix('#') {
                header.constants.extend(constant(directive));
            } else if let Some(name) = opened {
                inside = Some(name.to_owned());
            } else if line.starts_with('}') {
                inside = None;
            } else if let Some(name) = &inside {
                let fields = header.structs.entry(name.clone()).or_default();
                fields.extend(Declared::parse(line.trim().trim_end_matches(';')));
            } else {
                statement += line.trim();
                statement.push(' ');
                if let Some(whole) = statement.trim().strip_suffix(';') {
                    header.take(whole);
                    statement.clear();
                }
            }
        }
        header
    }

    /// A declaration of anything but a struct with fields.
    fn take(&mut self, statement: &str) {
        let Some(declared) = statement.strip_prefix("typedef ") else {
            self.functions.extend(function(statement));
            return;
        };
        let pointed_to = declared.split_once("(*").and_then(|(_, rest)| rest.split_once(')'));
        if let Some((name, _)) = pointed_to {
            self.callbacks.insert(name.to_owned(), declared.to_owned());
        } else if let Some((ctype, name)) = declared.rsplit_once(' ').filter(|_| !declared.contains('{')) {
            if ctype.starts_with("struct ") {
                self.handles.insert(name.to_owned());
            } else if !SPELT_BY_READER.contains(&name) {
                self.aliases.insert(name.to_owned(), ctype.to_owned());
            }
        }
    }
}

/// A type without the word `struct`, which C++ does without.
fn ctype(text: &str) -> String {
    text.trim().trim_start_matches("struct ").replace("const struct ", "const ")
}

/// The name of a number that programs are compiled with, but for the version, which is to change.
fn constant(directive: &str) -> Option<String> {
    let (name, value) = directive.strip_prefix("define ")?.split_once(' ')?;
    let is_number = name.starts_with("DRR_") && !name.contains('(') && !value.starts_with("__");
    (is_number && !name.starts_with("DRR_VERSION_")).then(|| name.to_owned())
}

/// A function's name, and what it takes and gives.
fn function(statement: &str) -> Option<(String, Function)> {
    let start = statement.find("drr_")?;
    let (name, rest) = statement[start..].split_once('(')?;
    let parameters = rest.rsplit_once(')')?.0.split(',').filter_map(Declared::parse).collect();
    Some((name.to_owned(), Function { returns: ctype(&statement[..start]), parameters }))
}
