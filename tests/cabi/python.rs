//! The library as Python calls it, against a projector that was written apart from it, `cabi-tests/python`.

use std::process::Command;

use libtest_mimic::Failed;

use crate::root;
use crate::toolchain::{launch, run, shared_library_file};

/// A Python that has what the tests need.
pub(super) fn find() -> Result<(), String> {
    let imports = run(Command::new("python3").args(["-c", "import numpy, pytest"]));
    imports.map(|_| ()).map_err(|_| "no python3 with numpy and pytest".to_owned())
}

/// Runs its tests.
pub(super) fn agrees() -> Result<(), Failed> {
    let mut pytest = launch("python3".as_ref());
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(root().join("cabi-tests/python"));
    run(pytest.env("PYTHONDONTWRITEBYTECODE", "1").env("DRR_LIBRARY", shared_library_file())).map(|_| ())
}
