//! Flattens `shaders/` into one text per compiler, and names the shared library by its file name, so that a program that
//! links to it finds it wherever that file is. Packages made by cargo-c give it a version.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=shaders");
    println!("cargo::rerun-if-changed=include/DRR_Shared.h");
    for entry_point in ["drr.metal", "drr.cu", "host.cpp", "parallel.metal", "parallel.cu", "parallel.cpp"] {
        let mut text = String::new();
        flatten(&Path::new("shaders").join(entry_point), &mut HashSet::new(), &mut text);
        let folder = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
        std::fs::write(folder.join(entry_point), text).expect("cargo's folder can be written");
    }
    name_the_library();
}

/// Appends a file with what it includes of ours in place, each file once, and says which line is whose.
fn flatten(path: &Path, seen: &mut HashSet<PathBuf>, text: &mut String) {
    if !seen.insert(path.to_owned()) {
        return;
    }
    let source = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let line_is = |text: &mut String, number: usize| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        writeln!(text, "#line {number} \"{name}\"").expect("a string can be written");
    };
    line_is(text, 1);
    for (number, line) in source.lines().enumerate() {
        match line.strip_prefix("#include \"").and_then(|rest| rest.strip_suffix('"')) {
            Some(name) => {
                let folder = if name == "DRR_Shared.h" { "include" } else { "shaders" };
                flatten(&Path::new(folder).join(name), seen, text);
                line_is(text, number + 2);
            }
            None => writeln!(text, "{line}").expect("a string can be written"),
        }
    }
}

fn name_the_library() {
    // cargo-c sets this feature and names the library itself.
    if std::env::var_os("CARGO_FEATURE_CAPI").is_some() {
        return;
    }
    let target = |key: &str| std::env::var(key).unwrap_or_default();
    if target("CARGO_CFG_TARGET_VENDOR") == "apple" {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/libdrr.dylib");
    } else if target("CARGO_CFG_TARGET_OS") == "linux" {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libdrr.so");
    }
}
