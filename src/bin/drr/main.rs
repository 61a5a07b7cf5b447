//! The command `drr`.
fn main() {}
