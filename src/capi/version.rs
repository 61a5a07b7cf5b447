//! The library's version.

use std::ffi::{CStr, c_char};

const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
    Ok(version) => version,
    Err(_) => panic!("the version has no NUL"),
};

/// The version of the library that runs, such as "0.1.0". A static string; never NULL. Any thread.
///
/// DRR_VERSION_MAJOR, DRR_VERSION_MINOR and DRR_VERSION_PATCH are those of the header a program was compiled with.
#[unsafe(no_mangle)]
pub extern "C" fn drr_version() -> *const c_char {
    VERSION.as_ptr()
}

/// The version of the library that runs, as a number to compare: 10000 × major + 100 × minor + patch. Cannot fail. Any
/// thread.
#[unsafe(no_mangle)]
pub extern "C" fn drr_version_number() -> u32 {
    10_000 * number(env!("CARGO_PKG_VERSION_MAJOR"))
        + 100 * number(env!("CARGO_PKG_VERSION_MINOR"))
        + number(env!("CARGO_PKG_VERSION_PATCH"))
}

fn number(digits: &str) -> u32 {
    digits.bytes().fold(0, |n, digit| 10 * n + u32::from(digit - b'0'))
}
