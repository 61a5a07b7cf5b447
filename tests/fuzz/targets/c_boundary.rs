#![no_main]

#[path = "../../hostile_input/c_boundary/mod.rs"]
mod c_boundary;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    c_boundary::check(bytes);
});
