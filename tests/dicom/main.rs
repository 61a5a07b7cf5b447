//! CTs in DICOM: files that the tests write, on every machine, and those of scanners where they are.
#![allow(missing_docs, reason = "a test program")]

#[path = "../support/needing.rs"]
#[allow(dead_code, reason = "every test program uses its own part")]
mod needing;
mod scanners;
mod series;
mod volume;
mod written;

fn main() {
    let arguments = libtest_mimic::Arguments::from_args();
    let trials = scanners::trials().into_iter().chain(written::trials()).collect();
    libtest_mimic::run(&arguments, trials).exit();
}
