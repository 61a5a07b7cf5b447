#![no_main]

#[path = "../../hostile_input/file.rs"]
mod file;
#[path = "../../hostile_input/pose_table.rs"]
mod pose_table;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    pose_table::check(bytes);
});
