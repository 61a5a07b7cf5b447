//! The Objective-C demo: built as its users build it, run, and its pictures looked at; what only a Mac can run is read by Clang.

mod picture;
mod sources;

use std::path::{Path, PathBuf};
use std::process::Command;

use libtest_mimic::{Failed, Trial};

use crate::needing::{ignored, needing};
use crate::toolchain::{Compiler, launch, run, scratch};
use crate::{beside_this_file, finds_in, root};
use picture::Picture;

/// The CT that the command carries.
const CT: &str = "src/bin/drr/default_ct/lidc_idri_0001_lowres.nii.gz";

/// Statuses of `<sysexits.h>`.
const USAGE: i32 = 64;
const NO_INPUT: i32 = 66;
const CANNOT_CREATE: i32 = 73;

fn demo() -> PathBuf {
    root().join("objc-demo")
}

/// An Objective-C compiler with a Foundation, and make.
#[derive(Clone)]
struct Make {
    compiler: &'static str,
}

impl Make {
    fn find(compiler: &'static str) -> Result<Self, String> {
        let works = |program: &str, arguments: &[&str]| run(Command::new(program).args(arguments)).ok();
        works("make", &["--version"]).ok_or("no make")?;
        works(compiler, &["--version"]).ok_or_else(|| format!("no {compiler}"))?;
        works("gnustep-config", &["--base-libs"]).ok_or("no GNUstep (apt: libgnustep-base-dev)")?;
        // Of GCC's, which Clang needs as well, the runtime's header.
        let folder = works("gcc", &["-print-file-name=include"]).unwrap_or_default();
        if Path::new(folder.trim()).join("objc/objc.h").is_file() {
            return Ok(Self { compiler });
        }
        Err("no Objective-C runtime of GCC's (apt: gobjc)".to_owned())
    }

    /// Builds the demo with warnings as errors, in a folder of that name; `variables` are make's.
    fn build(&self, name: &str, variables: &[String]) -> Result<PathBuf, Failed> {
        let folder = scratch().join(format!("objc-demo-{name}"));
        // Make knows files, not variables.
        let _ = std::fs::remove_dir_all(&folder);
        let mut make = Command::new("make");
        make.arg("-C").arg(demo()).arg(format!("CC={}", self.compiler));
        make.arg(format!("BUILD={}", folder.display())).arg(format!("LIBRARY={}", scratch().display()));
        run(make.args(["WARNINGS=-Wall -Wextra -Werror"]).args(variables))?;
        Ok(folder.join("drr-demo"))
    }

    /// With the address and undefined-behaviour sanitizers.
    fn sanitized(&self, name: &str, variables: &[String]) -> Result<PathBuf, Failed> {
        let flags = "CFLAGS=-fsanitize=address,undefined -fno-sanitize-recover=all".to_owned();
        self.build(name, &[&[flags], variables].concat())
    }
}

/// Runs the demo in a folder that is empty; the folder, and what the demo said.
fn project(program: &Path, name: &str, arguments: &[&str]) -> Result<(PathBuf, String), Failed> {
    let folder = scratch().join(format!("objc-demo-output-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    // GNUstep leaks by itself.
    let mut command = launch(program);
    command.env("ASAN_OPTIONS", "detect_leaks=0").args(arguments).arg("--output").arg(&folder);
    Ok((folder, run(&mut command)?))
}

/// The demo tells the time of every step that it takes.
fn tells_times(said: &str, steps: &[&str]) -> Result<(), Failed> {
    for step in steps {
        let line = said.lines().find(|line| line.split_whitespace().next() == Some(step));
        let words: Vec<_> = line.into_iter().flat_map(str::split_whitespace).collect();
        let told = words.get(1).is_some_and(|time| time.parse::<f64>().is_ok_and(f64::is_finite));
        if !told || words.get(2) != Some(&"ms") {
            return Err(format!("no time of {step}:\n{said}").into());
        }
    }
    Ok(())
}

const STEPS: [&str; 4] = ["load", "rays", "develop", "write"];

fn of_a_phantom(make: &Make) -> Result<(), Failed> {
    let program = make.build(make.compiler, &[])?;
    let (folder, said) = project(&program, make.compiler, &["--size", "200"])?;
    tells_times(&said, &STEPS)?;
    Picture::read(&folder.join("stereo-pair.pgm"))?.is_a_symmetric_chest(200)
}

fn of_a_ct(make: &Make) -> Result<(), Failed> {
    let program = make.sanitized("ct", &[])?;
    let ct = root().join(CT);
    let ct = ct.to_str().ok_or("the path is UTF-8")?;
    let effects = ["scatter", "blur", "noise"];
    let arguments = ["--ct", ct, "--size", "96", "--angle", "10", "--effects", "scatter,blur,noise"];
    let (folder, said) = project(&program, "ct", &arguments)?;
    tells_times(&said, &[&STEPS[..], &effects].concat())?;
    Picture::read(&folder.join("stereo-pair.pgm"))?.is_a_real_chest(96)
}

/// What is not valid is told with what would be, and nothing is written.
fn bad_arguments(make: &Make) -> Result<(), Failed> {
    let program = make.build("arguments", &[])?;
    let folder = scratch().join("objc-demo-output-none");
    let _ = std::fs::remove_dir_all(&folder);
    let refuses = |arguments: &[&str], status: i32, message: &str| {
        let output = launch(&program).arg("--output").arg(&folder).args(arguments).output()?;
        let said = String::from_utf8_lossy(&output.stderr);
        if output.status.code() == Some(status) && said.contains(message) && !folder.exists() {
            return Ok(());
        }
        Err(Failed::from(format!("{arguments:?}: {}, not {status}, {message}:\n{said}", output.status)))
    };
    for (option, value, message) in [
        ("--kvp", "90", "kvp is 90; valid: 60, 80, 100, 120, 140"),
        ("--kvp", "120.5", "--kvp is \"120.5\"; valid: a whole number"),
        ("--angle", "0", "angle is 0; valid: above 0 to 45 degrees"),
        ("--angle", "nan", "angle is nan; valid: above 0 to 45 degrees"),
        ("--angle", "6x", "--angle is \"6x\"; valid: a number"),
        ("--size", "15", "size is 15; valid: 16 to 4096"),
        ("--effects", "blur,fog", "effect is \"fog\"; valid: fall-off, heel, "),
        ("--ct", "", "--ct needs a value"),
        ("--colour", "red", "there is no option \"--colour\""),
    ] {
        refuses(&[option, value], USAGE, message)?;
    }
    if cfg!(feature = "formats") {
        refuses(&["--ct", "/none.nii"], NO_INPUT, "/none.nii")?;
    }
    let below_a_file = format!("{}/output", root().join("Cargo.toml").display());
    refuses(&["--size", "16", "--output", &below_a_file], CANNOT_CREATE, &below_a_file)
}

/// No object and no handle is left; one that is left on purpose is found.
fn nothing_is_left(make: &Make) -> Result<(), Failed> {
    let source = beside_this_file("objc_demo/leaks.m");
    let program = make.sanitized("leaks", &[format!("command={}", source.display())])?;
    let run = |left: &str| {
        let suppressions = beside_this_file("objc_demo/suppressions.txt");
        let options = format!("suppressions={}:print_suppressions=0", suppressions.display());
        run(launch(&program).env("LSAN_OPTIONS", options).arg(left))
    };
    run("nothing")?;
    finds_in(run("object"), "DRREffects: 1 of")?;
    finds_in(run("handle"), "LeakSanitizer: detected memory leaks")
}

/// The kernels of the screen, as host code, compute what the pictures have.
fn kernels_compute(make: &Make) -> Result<(), Failed> {
    let ours = |name: &str| beside_this_file("objc_demo").join(name);
    let object = scratch().join("objc-demo-kernels.o");
    let mut compiler = Command::new("clang++");
    // [[buffer(0)]]
    compiler.args(["-std=c++14", "-Wall", "-Wextra", "-Werror", "-Wno-unknown-attributes", "-isystem"]);
    run(compiler.arg(ours("host")).arg("-c").arg(ours("kernels.cpp")).arg("-o").arg(&object))?;
    let sources = format!("command={} {}", ours("kernels.m").display(), object.display());
    let program = make.build("kernels", &[sources])?;
    run(&mut launch(&program)).map(|_| ())
}

pub(super) fn trials() -> Vec<Trial> {
    let mut trials = sources::trials();
    if cfg!(target_vendor = "apple") {
        trials.push(ignored(
            "objc_demo::runs",
            "the pictures are PNG here, made and shown by Apple's frameworks",
        ));
        return trials;
    }
    let (gcc, clang) = (Make::find("gcc"), Make::find("clang"));
    let sanitizing = clang.clone().and_then(|make| Compiler::sanitized().map(|_| make));
    trials.push(needing("objc_demo::phantom_gcc", gcc, |make| of_a_phantom(&make)));
    trials.push(needing("objc_demo::phantom_clang", clang.clone(), |make| of_a_phantom(&make)));
    let reading =
        if cfg!(feature = "formats") { sanitizing.clone() } else { Err("no readers of files".to_owned()) };
    trials.push(needing("objc_demo::ct_sanitized", reading, |make| of_a_ct(&make)));
    trials.push(needing("objc_demo::bad_arguments", clang.clone(), |make| bad_arguments(&make)));
    trials.push(needing("objc_demo::kernels_compute", clang, |make| kernels_compute(&make)));
    trials.push(needing("objc_demo::nothing_is_left", sanitizing, |make| nothing_is_left(&make)));
    trials
}
