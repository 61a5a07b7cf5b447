//! The demo's sources as arm64 macOS would compile them, against stand-ins for Apple's headers, and what its README shows.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use libtest_mimic::{Failed, Trial};

use super::demo;
use crate::needing::needing;
use crate::root;
use crate::toolchain::{Compiler, run, scratch};

/// Clang for arm64 macOS, with no headers but its own, ours and the stand-ins.
#[derive(Clone)]
struct Clang {
    options: Vec<OsString>,
}

const ARC: &str = "-fobjc-arc";
const NO_ARC: &str = "-fno-objc-arc";

impl Clang {
    fn find() -> Result<Self, String> {
        let mut options: Vec<OsString> =
            ["-target", "arm64-apple-macos13", "-nostdlibinc", "-fsyntax-only", "-std=gnu11"]
                .map(OsString::from)
                .into();
        options.extend(["-Wall", "-Wextra", "-Werror"].map(OsString::from));
        let stand_ins = root().join("tests/support/apple");
        let headers = [stand_ins.clone(), stand_ins.join("libc")];
        options.extend(headers.into_iter().flat_map(|folder| ["-isystem".into(), folder.into()]));
        let ours = [root().join("include"), demo().join("Core/include"), demo().join("Metal/include")];
        options.extend(ours.into_iter().flat_map(|folder| ["-I".into(), folder.into()]));
        let clang = Self { options };

        let path = scratch().join("trivial.m");
        std::fs::write(&path, "#import <Foundation/Foundation.h>\n").map_err(|error| error.to_string())?;
        match clang.check(&path, ARC) {
            Ok(()) => Ok(clang),
            Err(_) => Err("no clang for arm64 macOS".to_owned()),
        }
    }

    fn check(&self, source: &Path, arc: &str) -> Result<(), Failed> {
        run(Command::new("clang").args(&self.options).arg(arc).arg(source)).map(|_| ())
    }
}

/// Files of one of the demo's folders.
fn files(folder: &str, extension: &str) -> Result<Vec<PathBuf>, Failed> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(demo().join(folder))? {
        let path = entry?.path();
        if path.extension().is_some_and(|own| own == extension) {
            files.push(path);
        }
    }
    if files.is_empty() { Err(format!("{folder} has no .{extension}").into()) } else { Ok(files) }
}

fn sources_compile(clang: &Clang) -> Result<(), Failed> {
    for (folder, arc) in [
        ("Core", &[ARC, NO_ARC][..]),
        ("Command", &[ARC, NO_ARC]),
        ("Metal", &[ARC]),
        ("App", &[ARC]),
        ("Tests", &[ARC]),
    ] {
        for file in files(folder, "m")? {
            arc.iter().try_for_each(|arc| clang.check(&file, arc))?;
        }
    }
    Ok(())
}

/// What cannot be right is refused: the stand-ins are read, and ARC is on.
fn mistakes_are_found(clang: &Clang) -> Result<(), Failed> {
    let path = scratch().join("mistake.m");
    for mistake in [
        "void f(id<MTLDevice> gpu) { [gpu newBufferOfLength:4]; }",
        "void f(id<MTLCommandBuffer> commands) { [commands setCompletedHandler:nil]; }",
        "void f(id<MTLTexture> texture) { drr_projector_encode(0, 0, 0, texture, 0); }",
        "void f(id object) { [object release]; }",
    ] {
        let text = format!("#import <Metal/Metal.h>\n#import \"DRR_Shared.h\"\n{mistake}\n");
        std::fs::write(&path, text)?;
        if clang.check(&path, ARC).is_ok() {
            return Err(format!("passes: {mistake}").into());
        }
    }
    Ok(())
}

fn kernels_compile(metal: &Compiler) -> Result<(), Failed> {
    files("Metal", "metal")?.iter().try_for_each(|file| metal.check(file))
}

fn readme() -> Result<String, Failed> {
    Ok(std::fs::read_to_string(demo().join("README.md"))?)
}

/// The blocks of the README in a language.
fn blocks<'a>(readme: &'a str, language: &str) -> Vec<&'a str> {
    let start = format!("```{language}\n");
    readme.split(&*start).skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

fn readme_compiles(clang: &Clang) -> Result<(), Failed> {
    let text = readme()?;
    let snippets = blocks(&text, "objc");
    if snippets.len() < 2 {
        return Err("the README shows no Objective-C".into());
    }
    let path = scratch().join("readme.m");
    for snippet in snippets {
        std::fs::write(&path, snippet)?;
        clang.check(&path, ARC)?;
    }
    Ok(())
}

/// Nothing here compiles Swift: what it calls is at least in the header, and what the README links to is there.
fn readme_names_what_exists() -> Result<(), Failed> {
    let text = readme()?;
    let header = std::fs::read_to_string(root().join("include/DRR_Shared.h"))?;
    let word = |c: char| !c.is_alphanumeric() && c != '_';
    let declared: std::collections::HashSet<_> = header.split(word).collect();
    let swift = blocks(&text, "swift").concat();
    let ours = ["drr_", "DRR_", "Drr"];
    let mut names = swift.split(word).filter(|name| ours.iter().any(|prefix| name.starts_with(prefix)));
    if let Some(name) = names.find(|name| !declared.contains(name)) {
        return Err(format!("the header has no {name}").into());
    }
    if swift.matches("drr_").count() < 5 {
        return Err("the README shows no Swift".into());
    }
    for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        if !demo().join(link).exists() {
            return Err(format!("{link} is not there").into());
        }
    }
    Ok(())
}

pub(super) fn trials() -> Vec<Trial> {
    let clang = Clang::find();
    vec![
        needing("objc_demo::sources_for_macos", clang.clone(), |clang| sources_compile(&clang)),
        needing("objc_demo::mistakes_are_found", clang.clone(), |clang| mistakes_are_found(&clang)),
        needing("objc_demo::readme_compiles", clang, |clang| readme_compiles(&clang)),
        Trial::test("objc_demo::readme_names_what_exists", readme_names_what_exists),
        needing("objc_demo::kernels_for_metal", Compiler::metal_stand_in(), |metal| kernels_compile(&metal)),
    ]
}
