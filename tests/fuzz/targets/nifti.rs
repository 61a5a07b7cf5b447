#![no_main]

#[path = "../../hostile_input/ct.rs"]
mod ct;
#[path = "../../hostile_input/file.rs"]
mod file;
#[path = "../../hostile_input/nifti.rs"]
mod nifti;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    nifti::check(bytes);
});
