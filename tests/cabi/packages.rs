//! The package for C, C++ and Objective-C that cargo-c makes: the sources are those that `cargo package` would publish, they
//! are gone when the package is used, and the package has been moved.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use libtest_mimic::{Failed, Trial};
use object::Endianness;
use object::elf::DT_SONAME;
use object::read::elf::{Dyn, ElfFile64};

use crate::needing::needing;
use crate::root;
use crate::toolchain::{run, scratch};

const VERSION: &str = env!("CARGO_PKG_VERSION");
/// What a package has, in the order of the alphabet.
const FILES: [&str; 10] = [
    "include/drr/DRR_Shared.h",
    "include/drr/drr.hpp",
    "include/drr/module.modulemap",
    "lib/libdrr.a",
    "lib/libdrr.so",
    "lib/libdrr.so.0",
    concat!("lib/libdrr.so.", env!("CARGO_PKG_VERSION")),
    "lib/pkgconfig/drr.pc",
    "share/cmake/drr/drr-config-version.cmake",
    "share/cmake/drr/drr-config.cmake",
];
const CMAKE_PROJECT: &str = "
cmake_minimum_required(VERSION 3.21)
project(uses_drr C CXX)
set(CMAKE_CXX_STANDARD 17)
find_package(drr ${DRR_NEXT} CONFIG QUIET)
if(drr_FOUND)
    message(FATAL_ERROR \"${DRR_VERSION} counts as ${DRR_NEXT}\")
endif()
find_package(drr ${DRR_SERIES} CONFIG REQUIRED)
find_package(drr ${DRR_VERSION} EXACT CONFIG REQUIRED)
add_executable(shared wrapper.cpp)
target_link_libraries(shared PRIVATE drr::drr)
add_executable(static minimal.c)
target_link_libraries(static PRIVATE drr::drr_static)
";

/// Looks at the package in a folder.
type Test = fn(&Path) -> Result<(), Failed>;

pub(super) fn trials() -> Vec<Trial> {
    if !cfg!(target_os = "linux") {
        return Vec::new();
    }
    let tests: [(&str, Test); 5] = [
        ("holds_what_it_should", holds_what_it_should),
        ("pkg_config", pkg_config),
        ("pkg_config_static", pkg_config_static),
        ("cmake", cmake),
        ("objective_c_module", objective_c_module),
    ];
    let trial = |(name, test): (&str, Test)| {
        needing(format!("packages::{name}"), tools(), move |()| test(installed()?))
    };
    tests.into_iter().map(trial).collect()
}

/// cargo-c, and what finds and uses packages.
fn tools() -> Result<(), String> {
    let missing = |tool: &&&[&str]| run(Command::new(tool[0]).args(&tool[1..])).is_err();
    let tools: [&[&str]; 7] = [
        &["cargo", "cinstall", "--version"],
        &["pkg-config", "--version"],
        &["cmake", "--version"],
        &["cc", "--version"],
        &["c++", "--version"],
        &["clang", "--version"],
        &["tar", "--version"],
    ];
    match tools.iter().find(missing) {
        Some(tool) => Err(format!("no {}", tool[..tool.len() - 1].join(" "))),
        None => Ok(()),
    }
}

fn folder() -> PathBuf {
    scratch().join("packages")
}

/// The package, made once.
fn installed() -> Result<&'static Path, Failed> {
    static PREFIX: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let made =
        PREFIX.get_or_init(|| install().map_err(|failed| failed.message().unwrap_or_default().to_owned()));
    made.as_deref().map_err(|reason| reason.clone().into())
}

/// Packs the sources, installs them from elsewhere, takes them away and moves what was installed.
fn install() -> Result<PathBuf, Failed> {
    let folder = folder();
    let build = scratch().join("packages-build");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    let cargo = || {
        let mut cargo = Command::new("cargo");
        // Quick to make; what it does is not at stake here.
        cargo
            .env("CARGO_PROFILE_DEV_OPT_LEVEL", "0")
            .env("CARGO_PROFILE_DEV_DEBUG", "0")
            .env("CARGO_INCREMENTAL", "0");
        cargo
    };
    let mut pack = cargo();
    pack.args([
        "package",
        "--locked",
        "--offline",
        "--no-verify",
        "--allow-dirty",
        "--quiet",
        "--target-dir",
    ]);
    run(pack.arg(&build).current_dir(root()))?;
    let crate_file = build.join("package").join(format!("drr-{VERSION}.crate"));
    run(Command::new("tar").arg("-xzf").arg(&crate_file).arg("-C").arg(&folder))?;

    let source = folder.join(format!("drr-{VERSION}"));
    let mut install = cargo();
    install.args([
        "cinstall",
        "--profile",
        "dev",
        "--no-default-features",
        "--features",
        "dicom",
        "--locked",
        "--offline",
        "--libdir",
        "lib",
    ]);
    install.arg("--prefix").arg(folder.join("made")).arg("--target-dir").arg(&build);
    run(install.current_dir(&source))?;
    std::fs::remove_dir_all(&source)?;
    let prefix = folder.join("moved");
    std::fs::rename(folder.join("made"), &prefix)?;
    Ok(prefix)
}

/// The files below a folder, by their paths from there.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Failed> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() { found.extend(files(&path)?) } else { found.push(path) }
    }
    found.sort();
    Ok(found)
}

fn holds_what_it_should(prefix: &Path) -> Result<(), Failed> {
    let files = files(prefix)?;
    let names: Vec<_> = files.iter().map(|path| path.strip_prefix(prefix)).collect::<Result<_, _>>()?;
    if names != FILES.map(Path::new) {
        return Err(format!("{names:#?}").into());
    }
    let sources = [folder().join(format!("drr-{VERSION}")), root().join("src"), root().join("include")];
    for path in &files {
        let bytes = std::fs::read(path)?;
        for source in &sources {
            let source = source.as_os_str().as_encoded_bytes();
            if bytes.windows(source.len()).any(|window| window == source) {
                return Err(format!("{} names {}", path.display(), String::from_utf8_lossy(source)).into());
            }
        }
    }
    let soname = soname(&std::fs::read(prefix.join("lib/libdrr.so"))?)?;
    if soname == "libdrr.so.0" { Ok(()) } else { Err(soname.into()) }
}

fn soname(library: &[u8]) -> Result<String, Failed> {
    let file = ElfFile64::<Endianness>::parse(library)?;
    let (endian, sections) = (file.endian(), file.elf_section_table());
    let (entries, link) = sections.dynamic(endian, library)?.ok_or("no dynamic section")?;
    let strings = sections.strings(endian, library, link)?;
    let entry = entries.iter().find(|entry| entry.tag(endian) == DT_SONAME).ok_or("no soname")?;
    Ok(String::from_utf8_lossy(entry.string(endian, strings)?).into_owned())
}

/// What pkg-config answers, in words, for the package where it is now.
fn asked(prefix: &Path, arguments: &[&str]) -> Result<Vec<String>, Failed> {
    let mut command = Command::new("pkg-config");
    command.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")).arg("--define-prefix");
    Ok(run(command.args(arguments).arg("drr"))?.split_whitespace().map(str::to_owned).collect())
}

/// A folder of its own with programs of `cabi-tests/`.
fn elsewhere(name: &str, programs: &[&str]) -> Result<PathBuf, Failed> {
    let folder = folder().join(name);
    std::fs::create_dir_all(&folder)?;
    for program in programs {
        std::fs::copy(root().join("cabi-tests").join(program), folder.join(program))?;
    }
    Ok(folder)
}

fn says_pass(program: &mut Command) -> Result<(), Failed> {
    let output = run(program)?;
    if output.contains("PASS") { Ok(()) } else { Err(output.into()) }
}

fn pkg_config(prefix: &Path) -> Result<(), Failed> {
    let version = asked(prefix, &["--modversion"])?;
    if version != [VERSION] {
        return Err(format!("{version:?}").into());
    }
    let folder = elsewhere("pkg-config", &["minimal.c"])?;
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "minimal.c", "-o", "minimal"]).args(asked(prefix, &["--cflags", "--libs"])?);
    run(compiler.current_dir(&folder))?;
    says_pass(Command::new(folder.join("minimal")).env("LD_LIBRARY_PATH", prefix.join("lib")))
}

fn pkg_config_static(prefix: &Path) -> Result<(), Failed> {
    let folder = elsewhere("pkg-config-static", &["minimal.c"])?;
    let arguments = asked(prefix, &["--static", "--cflags", "--libs"])?;
    // Linkers take the shared library where both are.
    let arguments =
        arguments.iter().map(|argument| if argument == "-ldrr" { "-l:libdrr.a" } else { argument });
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "minimal.c", "-o", "minimal"]).args(arguments);
    run(compiler.current_dir(&folder))?;
    says_pass(Command::new(folder.join("minimal")).env_remove("LD_LIBRARY_PATH"))
}

fn cmake(prefix: &Path) -> Result<(), Failed> {
    let folder = elsewhere("cmake", &["minimal.c", "wrapper.cpp", "water.h", "nifti.h", "check.h"])?;
    std::fs::write(folder.join("CMakeLists.txt"), CMAKE_PROJECT)?;
    let (major, minor) = (env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"));
    let next = minor.parse::<u32>()? + 1;
    let mut configure = Command::new("cmake");
    configure.args(["-S", ".", "-B", "build", &format!("-DDRR_VERSION={VERSION}")]);
    configure.args([format!("-DDRR_SERIES={major}.{minor}"), format!("-DDRR_NEXT={major}.{next}")]);
    run(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display())).current_dir(&folder))?;
    run(Command::new("cmake").args(["--build", "build"]).current_dir(&folder))?;
    for program in ["shared", "static"] {
        says_pass(Command::new(folder.join("build").join(program)).env_remove("LD_LIBRARY_PATH"))?;
    }
    Ok(())
}

fn objective_c_module(prefix: &Path) -> Result<(), Failed> {
    let folder = folder().join("module");
    std::fs::create_dir_all(&folder)?;
    std::fs::copy(root().join("tests/cabi/module.m"), folder.join("module.m"))?;
    let mut compiler = Command::new("clang");
    compiler.args([
        "-x",
        "objective-c",
        "-fmodules",
        "-fmodules-cache-path=cache",
        "-fsyntax-only",
        "module.m",
    ]);
    run(compiler.args(asked(prefix, &["--cflags"])?).current_dir(&folder)).map(|_| ())
}
