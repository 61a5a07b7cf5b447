//! What is found out about a volume before its scene is planned.

mod reach;

pub use reach::Reach;
