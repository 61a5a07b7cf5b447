//! Effects: each alone against its closed form or its twin in float64, in pairs for their order, and off against the plain
//! image.
#![allow(missing_docs, reason = "a test program")]

mod detector;
mod exposure;
mod focal_spot;
mod implants;
mod noise;
mod order;
mod plan;
mod source;
mod stand;
