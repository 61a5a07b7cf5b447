//! The C ABI as its users meet it: every program of `cabi-tests/` is compiled with warnings as errors, linked and run;
//! the header is read by every compiler that it is for.
//!
//! What needs a tool that this machine lacks is listed as ignored, with the reason as its kind. With
//! `DRR_REQUIRE_ALL_TOOLS=1` it fails instead.

mod abi;
mod apple;
mod coverage;
mod header;
mod kernel_text;
#[path = "../support/needing.rs"]
mod needing;
mod nvrtc;
mod objc_demo;
mod packages;
mod python;
mod reference;
mod stand_in;
mod thread_sanitizer;
mod toolchain;
mod wrapper;

use std::path::{Path, PathBuf};

use libtest_mimic::{Arguments, Failed, Trial};
use needing::needing;
use thread_sanitizer::ThreadSanitizer;
use toolchain::{Compiler, Library, launch, run};

/// Programs of `cabi-tests/`.
const PROGRAMS: [&str; 22] = [
    "layout",
    "minimal",
    "errors",
    "accepted",
    "lifecycle",
    "load",
    "threads",
    "threads_and_volumes",
    "cancel",
    "out_of_memory",
    "against_reference",
    "early_exit",
    "tolerance",
    "effects",
    "derivatives",
    "align",
    "register",
    "reconstruct",
    "raycast",
    "gpu",
    "cuda_stream",
    "pipeline",
];

/// Those that have threads of their own.
const THREADED: [&str; 3] = ["threads", "threads_and_volumes", "cancel"];

/// Sanitizers reserve terabytes of address space, which is what this program limits.
const NOT_SANITIZED: &str = "out_of_memory";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn program(name: &str) -> PathBuf {
    root().join("cabi-tests").join(name).with_extension("c")
}

fn beside_this_file(name: &str) -> PathBuf {
    root().join("tests/cabi").join(name)
}

/// Compiles a program, runs it and expects it to say PASS in the end; all that it says.
fn passes(compiler: &Compiler, library: &Library, source: &Path) -> Result<String, Failed> {
    let executable = compiler.executable(source, library)?;
    let output = run(&mut launch(&executable))?;
    if output.lines().any(|line| line.starts_with("PASS")) {
        return Ok(output);
    }
    Err(format!("{} does not say PASS:\n{output}", source.display()).into())
}

fn programs(library: &Library) -> Vec<Trial> {
    let (c11, sanitized) = (Compiler::c("c11"), Compiler::sanitized());
    let mut trials = Vec::new();
    let mut add = |prefix: &str, compiler: &Result<Compiler, String>, library: &Library, name: &str| {
        let (library, source) = (library.clone(), program(name));
        let lists_rows = name == "errors";
        let test = move |compiler| {
            let output = passes(&compiler, &library, &source)?;
            if lists_rows { coverage::complete(&output) } else { Ok(()) }
        };
        trials.push(needing(format!("{prefix}::{name}"), compiler.clone(), test));
    };
    for name in PROGRAMS {
        add("c11", &c11, library, name);
        if name != NOT_SANITIZED {
            add("sanitized", &sanitized, library, name);
        }
    }
    add("cpp17", &Compiler::cpp("c++17"), library, "pipeline");
    add("objective_c", &Compiler::objective_c(), library, "pipeline");
    add("static_library", &c11, &Library::linked_statically(), "minimal");
    let library = library.clone();
    trials.push(needing("sanitized::finds_a_deliberate_overflow", sanitized, move |compiler| {
        finds(&compiler, &library, "overflow.c", "heap-buffer-overflow")
    }));
    trials
}

/// Programs under the thread sanitizer, which sees into the library as well.
fn threaded_programs() -> Vec<Trial> {
    let sanitizer = ThreadSanitizer::find();
    let mut trials: Vec<_> = THREADED
        .into_iter()
        .map(|name| {
            needing(format!("thread_sanitized::{name}"), sanitizer.clone(), move |sanitizer| {
                passes(&sanitizer.compiler, sanitizer.library()?, &program(name)).map(|_| ())
            })
        })
        .collect();
    trials.push(needing("thread_sanitized::finds_a_deliberate_race", sanitizer, |sanitizer| {
        finds(&sanitizer.compiler, sanitizer.library()?, "race.c", "ThreadSanitizer: data race")
    }));
    trials
}

/// A sanitizer that is not on passes everything: this one finds the error in a program that has one on purpose.
fn finds(compiler: &Compiler, library: &Library, program: &str, error: &str) -> Result<(), Failed> {
    let executable = compiler.executable(&beside_this_file(program), library)?;
    finds_in(run(&mut launch(&executable)), error)
}

/// A program failed, and said so.
fn finds_in(said: Result<String, Failed>, error: &str) -> Result<(), Failed> {
    match said {
        Ok(output) => Err(format!("{error} was not found:\n{output}").into()),
        Err(failed) if failed.message().is_some_and(|m| m.contains(error)) => Ok(()),
        Err(failed) => Err(failed),
    }
}

/// Programs that take the best engine there is, on a stand-in for an NVIDIA GPU.
fn programs_on_a_gpu(library: &Library) -> Vec<Trial> {
    if !cfg!(all(feature = "cuda", target_os = "linux")) {
        return Vec::new();
    }
    let c11 = Compiler::c("c11");
    let trial = |name: &'static str| {
        let library = library.clone();
        needing(format!("cuda_stand_in::{name}"), c11.clone(), move |compiler| {
            stand_in::passes(&compiler, &library, name)
        })
    };
    let mut trials = ["gpu", "cuda_stream", "lifecycle", "threads", "threads_and_volumes"]
        .map(trial)
        .into_iter()
        .collect::<Vec<_>>();
    let library = library.clone();
    trials.push(needing("cuda_stand_in::failures_are_told", c11.clone(), move |compiler| {
        stand_in::failures_are_told(&compiler, &library)
    }));
    trials
}

fn headers() -> Vec<Trial> {
    let languages = [
        ("c99", Compiler::c("c99")),
        ("c11", Compiler::c("c11")),
        ("c17", Compiler::c("c17")),
        ("cpp11", Compiler::cpp("c++11")),
        ("cpp17", Compiler::cpp("c++17")),
        ("objective_c", Compiler::objective_c()),
    ];
    let mut trials: Vec<_> = languages
        .into_iter()
        .map(|(language, compiler)| {
            needing(format!("header::{language}"), compiler, |compiler| {
                compiler.check(&beside_this_file("header_only.c"))
            })
        })
        .collect();
    trials.push(needing("header::module", Compiler::modules(), |compiler| {
        compiler.check(&beside_this_file("module.m"))
    }));
    trials.push(needing("header::metal_stand_in", Compiler::metal_stand_in(), |compiler| {
        compiler.check(&beside_this_file("wire_only.metal.cpp"))
    }));
    trials.push(needing("header::nvrtc", nvrtc::Nvrtc::load(), |nvrtc| {
        let source = std::fs::read_to_string(beside_this_file("wire_only.cu"))?;
        let header = std::fs::read_to_string(root().join("include/DRR_Shared.h"))?;
        let ptx = nvrtc.ptx(&source, "DRR_Shared.h", &header)?;
        // 112 bytes aligned to 16, as the device's compiler sees them.
        if ptx.contains(".align 16") && ptx.contains("[112]") {
            return Ok(());
        }
        Err(format!("no parameter of 112 bytes aligned to 16:\n{ptx}").into())
    }));
    trials
}

/// A program that nobody runs tests nothing.
fn no_program_is_forgotten() -> Result<(), Failed> {
    for entry in std::fs::read_dir(root().join("cabi-tests"))? {
        let path = entry?.path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if path.extension().is_some_and(|extension| extension == "c") && !PROGRAMS.contains(&&*name) {
            return Err(format!("cabi-tests/{name}.c is not in the list").into());
        }
    }
    Ok(())
}

fn main() {
    let library = Library::shared();
    let mut trials = vec![Trial::test("no_program_is_forgotten", no_program_is_forgotten)];
    trials.push(needing("abi::is_as_committed", Compiler::c("c11"), |compiler| {
        abi::is_as_committed(&compiler)
    }));
    trials.push(Trial::test("abi::is_in_the_changelog", abi::is_in_the_changelog));
    trials.push(Trial::test("reference::is_complete", reference::is_complete));
    trials.extend(headers());
    trials.extend(programs(&library));
    trials.extend(threaded_programs());
    trials.extend(kernel_text::trials());
    let linker = apple::Linker::find();
    trials.push(needing("apple::library_links", linker, |linker| apple::library_links(&linker)));
    if !cfg!(target_vendor = "apple") {
        let script = apple::swift_package_is_made_on_macs_only;
        trials.push(Trial::test("apple::swift_package_is_made_on_macs_only", script));
    }
    trials.extend(programs_on_a_gpu(&library));
    trials.extend(wrapper::trials(&library));
    trials.push(needing("python::agrees", python::find(), |()| python::agrees()));
    trials.extend(packages::trials());
    trials.extend(objc_demo::trials());
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
