//! Relations between projections that hold whatever the volume, the geometry and the algorithm: they need no truth to
//! compare with. Random small scenes, both engines.
#![allow(missing_docs, reason = "a test program")]

mod case;
mod execution;
mod geometry;
mod pose;
#[path = "../support/mod.rs"]
mod support;
mod tolerance;
mod volume;

use proptest::test_runner::{Config, RngSeed};

/// `cases` scenes, the same ones in every run; `PROPTEST_CASES` and `PROPTEST_RNG_SEED` look for others.
fn scenes(cases: u32) -> Config {
    let asked = Config::default();
    let given = |variable: &str| std::env::var_os(variable).is_some();
    Config {
        cases: if given("PROPTEST_CASES") { asked.cases } else { cases },
        rng_seed: if given("PROPTEST_RNG_SEED") { asked.rng_seed } else { RngSeed::Fixed(1982) },
        failure_persistence: None,
        ..asked
    }
}
