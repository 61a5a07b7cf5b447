//! The shared library for arm64 macOS, linked on any machine by zig, which brings a linker for it. Apple's frameworks are
//! stubs, so what is looked up in them is known by its name only; nothing is run.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use libtest_mimic::Failed;
use object::read::macho::{LoadCommandVariant, MachOFile64, Nlist};
use object::{Architecture, LittleEndian, Object, macho};

use crate::header::Header;
use crate::toolchain::{run, scratch};

const TARGET: &str = "aarch64-apple-darwin";

/// Frameworks and libraries that the stubs stand for, with the folders in which macOS has them.
const STUBS: [(&str, &str); 6] = [
    ("CoreFoundation.framework/CoreFoundation", "/System/Library/Frameworks"),
    ("CoreGraphics.framework/CoreGraphics", "/System/Library/Frameworks"),
    ("Foundation.framework/Foundation", "/System/Library/Frameworks"),
    ("Metal.framework/Metal", "/System/Library/Frameworks"),
    ("libobjc.A.dylib", "/usr/lib"),
    ("libiconv.2.dylib", "/usr/lib"),
];

/// How the names begin that are looked up in them.
const THEIR_NAMES: [&str; 12] = [
    "_objc_",
    "_class_",
    "_sel_",
    "_object_",
    "_method_",
    "_protocol_",
    "_ivar_",
    "_property_",
    "_OBJC_CLASS_$_",
    "_NS",
    "_MTL",
    "__objc_",
];

/// Rust for the target, and a linker for it.
#[derive(Clone)]
pub(super) struct Linker {
    zig: &'static str,
}

impl Linker {
    /// What is installed; the reason where something is missing.
    pub(super) fn find() -> Result<Self, String> {
        let libraries = run(Command::new("rustc").args(["--print", "target-libdir", "--target", TARGET]));
        let libraries = libraries.map_err(|_| "rustc does not answer".to_owned())?;
        if !Path::new(libraries.trim()).is_dir() {
            return Err(format!("no Rust for {TARGET} (rustup target add {TARGET})"));
        }
        let there = |zig: &&str| {
            let mut words = zig.split(' ');
            words.next().is_some_and(|program| run(Command::new(program).args(words).arg("version")).is_ok())
        };
        let zig = ["zig", "python-zig", "python3 -m ziglang"].into_iter().find(there);
        zig.map(|zig| Self { zig }).ok_or_else(|| "no zig (pip install ziglang)".to_owned())
    }

    /// Builds the library; where it is, and the names that rustc has the linker export.
    fn link(&self) -> Result<(PathBuf, BTreeSet<String>), Failed> {
        let folder = scratch().join("apple");
        let (stubs, target, exports) = (folder.join("stubs"), folder.join("target"), folder.join("exports"));
        write_stubs(&stubs)?;
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut cargo = Command::new("cargo");
        cargo
            .args(["rustc", "--quiet", "--locked", "--lib", "--crate-type=cdylib", "--no-default-features"])
            .args(["--target", TARGET])
            .arg("--target-dir")
            .arg(&target)
            .arg("--manifest-path")
            .arg(root.join("Cargo.toml"))
            .env_remove("CARGO_ENCODED_RUSTFLAGS")
            .env("CARGO_TARGET_AARCH64_APPLE_DARWIN_LINKER", root.join("tests/cabi/apple_linker.sh"))
            .env("CARGO_PROFILE_DEV_STRIP", "none")
            .env("MACOSX_DEPLOYMENT_TARGET", "13.0")
            // Any folder keeps rustc from asking for Apple's.
            .env("SDKROOT", &stubs)
            .env("DRR_ZIG", self.zig)
            .env("DRR_STUBS", &stubs)
            .env("DRR_EXPORTS", &exports);
        run(&mut cargo)?;
        let names = std::fs::read_to_string(&exports)?.lines().map(str::to_owned).collect();
        Ok((target.join(TARGET).join("debug/libdrr.dylib"), names))
    }
}

fn write_stubs(folder: &Path) -> Result<(), Failed> {
    for (file, installed) in STUBS {
        let (parent, name) = file.split_once('/').unwrap_or(("", file));
        std::fs::create_dir_all(folder.join(parent))?;
        // libobjc.A.dylib is found as libobjc.
        let name = name.split('.').next().unwrap_or(name);
        let text = format!(
            "--- !tapi-tbd\ntbd-version: 4\ntargets: [ arm64-macos ]\ninstall-name: '{}'\n...\n",
            install_name(file, installed)
        );
        std::fs::write(folder.join(parent).join(name).with_extension("tbd"), text)?;
    }
    Ok(())
}

fn install_name(file: &str, installed: &str) -> String {
    format!("{installed}/{}", file.replace(".framework/", ".framework/Versions/A/"))
}

/// The library is what the header and a program that links to it expect of it.
pub(super) fn library_links(linker: &Linker) -> Result<(), Failed> {
    let (path, listed) = linker.link()?;
    let bytes = std::fs::read(&path)?;
    let library = MachOFile64::<LittleEndian>::parse(&*bytes)?;
    if library.architecture() != Architecture::Aarch64 {
        return Err(format!("{:?}", library.architecture()).into());
    }

    let declared: BTreeSet<_> = Header::read().functions.keys().map(|name| format!("_{name}")).collect();
    same("names that rustc exports", &listed, &declared)?;
    let exported: BTreeSet<_> =
        library.exports()?.iter().map(|export| String::from_utf8_lossy(export.name()).into_owned()).collect();
    same("of them not in the library", &declared.difference(&exported).cloned().collect(), &BTreeSet::new())?;

    let (name, linked) = libraries(&library)?;
    same("install name", &name, &["@rpath/libdrr.dylib".to_owned()].into())?;
    let needed = STUBS.iter().filter(|(file, _)| !file.contains("iconv"));
    let needed = needed.map(|(file, installed)| install_name(file, installed));
    let needed = needed.chain(["/usr/lib/libSystem.B.dylib".to_owned()]).collect();
    same("libraries that are needed", &linked, &needed)?;

    let elsewhere = looked_up(&library)?;
    let unknown = elsewhere.iter().filter(|name| !THEIR_NAMES.iter().any(|theirs| name.starts_with(theirs)));
    same("names that are nowhere", &unknown.cloned().collect(), &BTreeSet::new())?;
    if elsewhere.contains("_MTLCreateSystemDefaultDevice") {
        return Ok(());
    }
    Err("the Metal engine is not in the library".into())
}

fn same(what: &str, found: &BTreeSet<String>, expected: &BTreeSet<String>) -> Result<(), Failed> {
    if found == expected {
        return Ok(());
    }
    let difference: Vec<_> = found.symmetric_difference(expected).collect();
    Err(format!("{what}: {difference:?} differ").into())
}

/// The library's own name, and those of the libraries that it needs.
fn libraries(
    library: &MachOFile64<'_, LittleEndian>,
) -> Result<(BTreeSet<String>, BTreeSet<String>), Failed> {
    let (mut own, mut needed) = (BTreeSet::new(), BTreeSet::new());
    let mut commands = library.macho_load_commands()?;
    while let Some(command) = commands.next()? {
        let names = match command.variant()? {
            LoadCommandVariant::IdDylib(dylib) => (&mut own, dylib),
            LoadCommandVariant::Dylib(dylib) => (&mut needed, dylib),
            _ => continue,
        };
        let name = command.string(LittleEndian, names.1.dylib.name)?;
        names.0.insert(String::from_utf8_lossy(name).into_owned());
    }
    Ok((own, needed))
}

/// Undefined names that no library is known to have. Zig gives them the number 0, where Apple's linker has one of its own.
fn looked_up(library: &MachOFile64<'_, LittleEndian>) -> Result<BTreeSet<String>, Failed> {
    let symbols = library.macho_symbol_table();
    let nowhere = |number: u8| number == 0 || number == macho::DYNAMIC_LOOKUP_ORDINAL;
    let undefined = symbols.iter().filter(|symbol| symbol.is_undefined());
    let names = undefined
        .filter(|symbol| nowhere(symbol.library_ordinal(LittleEndian)))
        .map(|symbol| symbol.name(LittleEndian, symbols.strings()));
    names.map(|name| Ok(String::from_utf8_lossy(name?).into_owned())).collect()
}

/// The script that makes the Swift package, which needs Apple's tools, says so elsewhere and makes nothing. What it copies is
/// there.
pub(super) fn swift_package_is_made_on_macs_only() -> Result<(), Failed> {
    let folder = scratch().join("swift");
    let script = crate::root().join("objc-demo/xcframework.sh");
    let refusal =
        run(Command::new(&script).arg(&folder)).err().and_then(|failed| failed.message().map(str::to_owned));
    if folder.exists() || !refusal.as_ref().is_some_and(|message| message.contains("needs macOS")) {
        return Err(format!("{refusal:?}").into());
    }
    let text = std::fs::read_to_string(&script)?;
    let copied = text
        .split_whitespace()
        .filter(|word| word.starts_with("include/") || word.starts_with("objc-demo/DRR/"));
    let missing: Vec<_> = copied.filter(|file| !crate::root().join(file).is_file()).collect();
    if missing.is_empty() { Ok(()) } else { Err(format!("{missing:?} is not there").into()) }
}
