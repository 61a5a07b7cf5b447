//! Every engine in float32 against its float64 twin, for every layer, algorithm, kind of volume, number of materials and
//! awkward geometry. The engine `host` runs the GPU kernels' very text, so that they are held to it without a GPU.
//!
//! Engines that this machine lacks are listed as ignored, with the reason as their kind. With `DRR_REQUIRE_ALL_TOOLS=1`
//! a missing C++ compiler, which `host` needs, fails instead.
#![allow(missing_docs, reason = "a test program")]

mod bytes;
mod effects;
mod energies;
mod methods;
mod parallel;
#[cfg(feature = "formats")]
mod scans;
mod sides;
#[path = "../support/mod.rs"]
mod support;
mod twin;
mod views;
mod voxels;

use drr::Context;
use drr::engine::Backend;
use libtest_mimic::{Arguments, Trial};
use support::host_compiler;
use support::needing::{ignored, needing};

/// A test of one engine, by name.
type Test = (&'static str, fn(Backend));

#[cfg(not(feature = "formats"))]
mod scans {
    pub(super) const TESTS: [super::Test; 0] = [];
}

fn trials(backend: Backend) -> Vec<Trial> {
    let tests = [
        &sides::TESTS[..],
        &voxels::TESTS,
        &views::TESTS,
        &energies::TESTS,
        &effects::TESTS,
        &bytes::TESTS,
        &methods::TESTS,
        &parallel::TESTS,
        &scans::TESTS,
    ]
    .concat();
    let named = |name: &str| format!("{}::{name}", backend.name());
    if let (Backend::Cuda | Backend::Metal, Err(reason)) = (backend, Context::new(backend, 1)) {
        return vec![ignored(named("every_test"), reason.to_string())];
    }
    let there = if backend == Backend::Host { host_compiler() } else { Ok(()) };
    let trial = |(name, test): Test| {
        needing(named(name), there.clone(), move |()| {
            test(backend);
            Ok(())
        })
    };
    tests.into_iter().map(trial).collect()
}

fn main() {
    let float32 = Backend::ALL.into_iter().filter(|&backend| backend != Backend::Reference);
    let mut all: Vec<_> = float32.flat_map(trials).collect();
    all.push(Trial::test("reference::a_tie_of_driving_axes_is_no_jump", || {
        sides::a_tie_of_driving_axes_is_no_jump();
        Ok(())
    }));
    all.push(Trial::test("reference::parallel::the_reference_is_wide", || {
        parallel::the_reference_is_wide();
        Ok(())
    }));
    let conclusion = libtest_mimic::run(&Arguments::from_args(), all);
    twin::print_used();
    conclusion.exit();
}
