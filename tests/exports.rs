//! The shared library exports what the header declares, and nothing else.
#![allow(missing_docs, reason = "a test program")]

use std::collections::BTreeSet;

use object::{Object, ObjectSymbol};

fn exported() -> BTreeSet<String> {
    let name = if cfg!(target_vendor = "apple") { "libdrr.dylib" } else { "libdrr.so" };
    // Cargo puts the libraries of a test run beside the test's executable.
    let path = std::env::current_exe().expect("this test runs from a file").with_file_name(name);
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let file = object::File::parse(&*bytes).expect("an object file");
    if let object::File::Elf64(elf) = &file {
        let symbols = elf.dynamic_symbols().filter(ObjectSymbol::is_definition);
        return symbols.map(|symbol| symbol.name().expect("UTF-8").to_owned()).collect();
    }
    let exports = file.exports().expect("a table of exports");
    // Mach-O puts an underscore before the names of C.
    let name = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_start_matches('_').to_owned();
    exports.iter().map(|export| name(export.name())).collect()
}

/// The functions of the header, which `tests/cabi` holds to this list.
fn declared() -> BTreeSet<String> {
    let lines = include_str!("../cabi-tests/abi.txt").lines();
    let function = |line: &str| {
        let line = line.strip_prefix("function ")?;
        Some(line[line.find("drr_")?..line.find('(')?].to_owned())
    };
    lines.filter_map(function).collect()
}

#[test]
fn exports_are_the_functions_of_the_header() {
    let declared = declared();
    assert!(declared.contains("drr_projector_project") && declared.contains("drr_version"), "{declared:?}");
    assert_eq!(exported(), declared);
}
