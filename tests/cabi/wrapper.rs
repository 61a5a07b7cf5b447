//! The C++ header, `include/drr.hpp`: its program, and that it leaves nothing of the C header out.

use libtest_mimic::{Failed, Trial};

use crate::header::Header;
use crate::needing::needing;
use crate::toolchain::{Compiler, Library};
use crate::{passes, root};

pub(super) fn trials(library: &Library) -> Vec<Trial> {
    let compilers = [
        ("wrapper::cpp17", Compiler::cpp_wrapper("c++17")),
        ("wrapper::cpp20", Compiler::cpp_wrapper("c++20")),
        ("wrapper::sanitized", Compiler::cpp_sanitized()),
    ];
    let mut trials: Vec<_> = compilers
        .into_iter()
        .map(|(name, compiler)| {
            let library = library.clone();
            needing(name, compiler, move |compiler| {
                passes(&compiler, &library, &root().join("cabi-tests/wrapper.cpp")).map(|_| ())
            })
        })
        .collect();
    trials.push(Trial::test("wrapper::has_every_function", has_every_function));
    trials
}

/// Every function of C is called, and so every handle destroyed and every struct filled.
fn has_every_function() -> Result<(), Failed> {
    let text = std::fs::read_to_string(root().join("include/drr.hpp"))?;
    let words: Vec<_> = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').collect();
    let missing: Vec<_> =
        Header::read().functions.into_keys().filter(|name| !words.contains(&&**name)).collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(format!("include/drr.hpp does not call\n{}", missing.join("\n")).into())
}
