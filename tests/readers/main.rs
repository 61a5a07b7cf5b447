//! What the command writes, as programs of others read it: OpenEXR's own tools, shells, man, a browser.
//!
//! What needs a tool that this machine lacks is listed as ignored, with the reason as its kind. With
//! `DRR_REQUIRE_ALL_TOOLS=1` it fails instead, but for the browser, which takes longer to install than all the rest.

mod browser;
mod exr_tools;
mod manual;
#[path = "../support/needing.rs"]
mod needing;
mod shells;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use libtest_mimic::{Arguments, Failed, Trial};

fn main() -> ExitCode {
    let tests = [exr_tools::tests(), manual::tests(), shells::tests(), browser::tests()];
    let tests: Vec<Trial> = tests.into_iter().flatten().collect();
    libtest_mimic::run(&Arguments::from_args(), tests).exit_code()
}

/// Where a program is, or that it is nowhere.
fn program(name: &str) -> Result<PathBuf, String> {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&folders).map(|folder| folder.join(name)).find(|path| path.is_file());
    found.ok_or(format!("no {name} on the PATH"))
}

/// Runs a program, which must succeed, and returns its stdout.
fn succeed(program: &Path, arguments: &[&str], folder: &Path) -> Result<String, Failed> {
    let output = Command::new(program).args(arguments).current_dir(folder).output()?;
    let error = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("{} {arguments:?}: {}: {error}", program.display(), output.status).into());
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn drr(arguments: &[&str], folder: &Path) -> Result<String, Failed> {
    succeed(Path::new(env!("CARGO_BIN_EXE_drr")), arguments, folder)
}

/// One small view of the built-in CT with all of its layers, in `out`.
fn project(folder: &Path, others: &[&str]) -> Result<(), Failed> {
    let own = ["project", "--size", "160x140", "--angles", "30", "--output", "out", "--quiet"];
    let layers = ["--layers", "intensity,line_integral,areal_density,bone_path"];
    drr(&[&own[..], &layers, others].concat(), folder).map(drop)
}

/// An error unless it holds.
fn expect(holds: bool, what: impl FnOnce() -> String) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(what().into()) }
}
