//! Tests that need something that a machine may lack.

use libtest_mimic::{Failed, Trial};

/// Whether a missing tool is a failure.
pub(crate) fn every_tool_is_required() -> bool {
    std::env::var_os("DRR_REQUIRE_ALL_TOOLS").is_some_and(|value| value == "1")
}

/// A test that needs a tool; without it, ignored for the reason given, or failing where every tool is required.
pub(crate) fn needing<T: Send + 'static>(
    name: impl Into<String>,
    tool: Result<T, String>,
    test: impl FnOnce(T) -> Result<(), Failed> + Send + 'static,
) -> Trial {
    match tool {
        Ok(tool) => Trial::test(name, move || test(tool)),
        Err(reason) if every_tool_is_required() => Trial::test(name, move || Err(reason.into())),
        Err(reason) => ignored(name, reason),
    }
}

/// A test that this machine cannot run, and why.
pub(crate) fn ignored(name: impl Into<String>, reason: impl Into<String>) -> Trial {
    Trial::test(name, || Ok(())).with_kind(reason).with_ignored_flag(true)
}
