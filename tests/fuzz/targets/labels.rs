#![no_main]

#[path = "../../hostile_input/file.rs"]
mod file;
#[path = "../../hostile_input/labels.rs"]
mod labels;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    labels::check(bytes);
});
