#![no_main]

#[path = "../../hostile_input/ct.rs"]
mod ct;
#[path = "../../hostile_input/dicom.rs"]
mod dicom;
#[path = "../../hostile_input/file.rs"]
mod file;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    dicom::check(bytes);
});
