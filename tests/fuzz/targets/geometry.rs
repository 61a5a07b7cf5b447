#![no_main]

#[path = "../../hostile_input/file.rs"]
mod file;
#[path = "../../hostile_input/geometry.rs"]
mod geometry;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    geometry::check(bytes);
});
