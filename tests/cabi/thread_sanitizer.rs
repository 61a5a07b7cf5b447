//! The library and Rust's standard library under the thread sanitizer, which needs a nightly compiler.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};

use libtest_mimic::Failed;

use crate::toolchain::{Compiler, Library, run, scratch};

/// The nightly toolchain that `.ci/run` installs.
const NIGHTLY: &str = include_str!("../../.ci/nightly").trim_ascii();

/// All that it takes to build a program with the thread sanitizer in every part of it.
#[derive(Clone)]
pub(super) struct ThreadSanitizer {
    pub(super) compiler: Compiler,
    host: String,
    /// The sanitizer's run-time: that of rustc, because an older Clang's lacks functions that a newer LLVM calls.
    runtime: PathBuf,
    library: Arc<OnceLock<Result<Library, String>>>,
}

impl ThreadSanitizer {
    /// What is installed; the reason where something is missing.
    pub(super) fn find() -> Result<Self, String> {
        let compiler = Compiler::thread_sanitized()?;
        let rustc = |question: &[&str]| {
            let answer = run(nightly("rustc").args(question));
            answer.map_err(|_| format!("no toolchain {NIGHTLY} (rustup toolchain install {NIGHTLY})"))
        };
        let version = rustc(&["-vV"])?;
        let host = version.lines().find_map(|line| line.strip_prefix("host: "));
        let host = host.ok_or_else(|| format!("rustc does not name its host: {version}"))?;
        let libraries = PathBuf::from(rustc(&["--print", "sysroot"])?.trim()).join("lib/rustlib");
        if !libraries.join("src/rust/library/Cargo.lock").is_file() {
            return Err(format!("toolchain {NIGHTLY} is without its component rust-src"));
        }
        let runtime = libraries.join(host).join("lib/librustc-nightly_rt.tsan.a");
        if !runtime.is_file() {
            return Err(format!("no thread sanitizer for {host}"));
        }
        Ok(Self { compiler, host: host.to_owned(), runtime, library: Arc::default() })
    }

    /// The static library, built on first use.
    pub(super) fn library(&self) -> Result<&Library, Failed> {
        let built = self.library.get_or_init(|| {
            self.build().map_err(|failed| failed.message().unwrap_or("the build failed").to_owned())
        });
        built.as_ref().map_err(Failed::from)
    }

    fn build(&self) -> Result<Library, Failed> {
        let target = scratch().join("thread-sanitized");
        let mut cargo = nightly("cargo");
        cargo
            .args(["build", "--quiet", "--locked", "--lib", "--no-default-features", "-Zbuild-std"])
            .args(["--target", &self.host])
            .arg("--target-dir")
            .arg(&target)
            .arg("--manifest-path")
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"))
            .env("RUSTFLAGS", "-Zsanitizer=thread")
            .env("CARGO_PROFILE_DEV_OPT_LEVEL", "1");
        run(&mut cargo)?;
        let library = target.join(&self.host).join("debug/libdrr.a");
        let link = [
            library.into(),
            "-Wl,--whole-archive".into(),
            self.runtime.clone().into(),
            "-Wl,--no-whole-archive".into(),
            "-lpthread".into(),
            "-ldl".into(),
        ];
        Ok(Library::linked_by(link.into(), "-thread-sanitized"))
    }
}

/// A program of the nightly toolchain.
fn nightly(program: &str) -> Command {
    let mut command = Command::new("rustup");
    // This would win over RUSTFLAGS.
    command.args(["run", NIGHTLY, program]).env_remove("CARGO_ENCODED_RUSTFLAGS");
    command
}
