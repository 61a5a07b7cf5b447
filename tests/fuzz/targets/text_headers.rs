#![no_main]

#[path = "../../hostile_input/ct.rs"]
mod ct;
#[path = "../../hostile_input/file.rs"]
mod file;
#[path = "../../hostile_input/text_headers.rs"]
mod text_headers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    text_headers::check(bytes);
});
