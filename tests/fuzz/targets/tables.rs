#![no_main]

#[path = "../../hostile_input/file.rs"]
mod file;
#[path = "../../hostile_input/tables.rs"]
mod tables;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    tables::check(bytes);
});
