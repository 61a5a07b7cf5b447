//! What a compiled caller relies on: functions, constants, and where every field of every struct is, as a C compiler has
//! them. `cabi-tests/abi.txt` keeps it, so that no change goes unseen; `DRR_UPDATE_ABI=1` rewrites it. The changelog tells
//! of every change.

use std::fmt::Write as _;

use libtest_mimic::Failed;

use crate::header::{Declared, Header};
use crate::root;
use crate::toolchain::{Compiler, Library, launch, run, scratch};

const SNAPSHOT: &str = "cabi-tests/abi.txt";
const FIRST_LINES: &str = "# What compiled callers rely on, where pointers have 64 bits: structs have size and alignment, fields
# offset and size. DRR_UPDATE_ABI=1 cargo test --test cabi abi rewrites this file; CHANGELOG.md tells of the change.
";

/// The snapshot of the header, as `compiler` reads it.
pub(super) fn is_as_committed(compiler: &Compiler) -> Result<(), Failed> {
    let header = Header::read();
    header.misses_no_type()?;
    let now = snapshot(&header, compiler)?;
    let path = root().join(SNAPSHOT);
    if std::env::var_os("DRR_UPDATE_ABI").is_some_and(|value| value == "1") {
        std::fs::write(&path, &now)?;
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    if now == committed {
        return Ok(());
    }
    let (gone, new) = (lines_without(&committed, &now), lines_without(&now, &committed));
    Err(format!(
        "{SNAPSHOT} differs from the header; DRR_UPDATE_ABI=1 rewrites it.\ngone:\n{gone}new:\n{new}"
    )
    .into())
}

/// The newest "C ABI" section of the changelog states which snapshot it has come to, and the sections together name
/// everything in it.
pub(super) fn is_in_the_changelog() -> Result<(), Failed> {
    let snapshot = std::fs::read_to_string(root().join(SNAPSHOT))?;
    let changelog = std::fs::read_to_string(root().join("CHANGELOG.md"))?;
    let sections = sections(&changelog, "### C ABI");
    let state = format!("ABI {:016x}", fnv1a(snapshot.as_bytes()));
    if !sections.first().is_some_and(|newest| newest.contains(&state)) {
        return Err(format!(
            "the newest section \"C ABI\" of CHANGELOG.md does not say `{state}`: tell what has changed"
        )
        .into());
    }
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '*';
    let words: Vec<_> = sections.iter().flat_map(|section| section.split(|c| !is_word(c))).collect();
    let named = |name: &str| {
        words.iter().any(|word| match word.strip_suffix('*') {
            // Not everything at once.
            Some(start) => start.len() > "drr_".len() && name.starts_with(start),
            None => *word == name,
        })
    };
    let header = Header::read();
    let names = header.functions.keys().chain(header.structs.keys()).chain(&header.handles);
    let names = names.chain(header.aliases.keys()).chain(header.callbacks.keys()).chain(&header.constants);
    let missing: Vec<_> = names.filter(|name| !named(name)).map(String::as_str).collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(format!("no section \"C ABI\" of CHANGELOG.md names\n{}", missing.join("\n")).into())
}

/// What stands under each heading of that text, in the order of the file.
fn sections<'a>(text: &'a str, heading: &str) -> Vec<&'a str> {
    let after = text.split(heading).skip(1);
    after.map(|section| section.split("\n#").next().unwrap_or_default()).collect()
}

/// Fowler, Noll and Vo's hash FNV-1a of 64 bits: the same everywhere, and no secret.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn lines_without(text: &str, other: &str) -> String {
    let lines = text.lines().filter(|&line| other.lines().all(|there| there != line));
    lines.fold(String::new(), |all, line| all + line + "\n")
}

fn snapshot(header: &Header, compiler: &Compiler) -> Result<String, Failed> {
    let mut text = String::from(FIRST_LINES);
    for (name, ctype) in &header.aliases {
        writeln!(text, "alias {name} {ctype}")?;
    }
    for declared in header.callbacks.values() {
        writeln!(text, "callback {declared}")?;
    }
    for name in &header.handles {
        writeln!(text, "handle {name}")?;
    }
    text += &measured(header, compiler)?;
    for (name, function) in &header.functions {
        let parameters: Vec<_> = function.parameters.iter().map(spelt).collect();
        let parameters = if parameters.is_empty() { "void".to_owned() } else { parameters.join(", ") };
        let returns = Declared { ctype: function.returns.clone(), name: name.clone(), size: String::new() };
        writeln!(text, "function {}({parameters})", spelt(&returns))?;
    }
    Ok(text)
}

fn spelt(declared: &Declared) -> String {
    let Declared { ctype, name, size } = declared;
    let space = if ctype.ends_with('*') { "" } else { " " };
    format!("{ctype}{space}{name}{size}")
}

/// Constants and structs, as a program that is made of the header's own names says.
fn measured(header: &Header, compiler: &Compiler) -> Result<String, Failed> {
    let mut program = String::from("#include <stdio.h>\n#include \"DRR_Shared.h\"\nint main(void) {\n");
    for name in &header.constants {
        writeln!(program, "printf(\"constant {name} %lld\\n\", (long long){name});")?;
    }
    for (name, fields) in &header.structs {
        writeln!(program, "printf(\"struct {name} %zu %zu\\n\", sizeof({name}), _Alignof({name}));")?;
        for field in fields {
            let (member, spelt) = (&field.name, spelt(field));
            write!(program, "printf(\"field {name} %zu %zu {spelt}\\n\", offsetof({name}, {member}), ")?;
            writeln!(program, "sizeof((({name} *)0)->{member}));")?;
        }
    }
    program += "return 0;\n}\n";
    let source = scratch().join("abi.c");
    std::fs::write(&source, program)?;
    run(&mut launch(&compiler.executable(&source, &Library::none())?))
}
