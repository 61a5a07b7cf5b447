//! Names the shared library by its file name, so that a program that links to it finds it wherever that file is.
//! Packages made by cargo-c give it a version.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // cargo-c sets this feature and names the library itself.
    if std::env::var_os("CARGO_FEATURE_CAPI").is_some() {
        return;
    }
    let target = |key: &str| std::env::var(key).unwrap_or_default();
    if target("CARGO_CFG_TARGET_VENDOR") == "apple" {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/libdrr.dylib");
    } else if target("CARGO_CFG_TARGET_OS") == "linux" {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libdrr.so");
    }
}
