//! The kernel's variants on one scene: the algorithms, and the specification's own loop.

use anyhow::Result;
use drr::effects::{Effects, Noise};
use drr::engine::{Layers, SILENT, Timings};
use drr::physics::DetectorResponse;
use drr::{Algorithm, Projector, Scene, ViewRequest};
use serde_json::json;

use crate::bench::times::Times;
use crate::console::Console;
use crate::inputs::Setup;

/// Launches of each variant whose median is reported, after one that is not counted.
const RUNS: usize = 50;
/// The specification's loop takes ten times as long and more.
const RUNS_OF_THE_LOOP: usize = 5;

/// Times of one variant, and what its kernel takes of the device.
struct Variant {
    times: Times,
    timings: Timings,
}

/// All variants.
pub(super) struct Variants(Vec<Variant>);

impl Variants {
    /// Measures them; only the intensity is asked for.
    pub(super) fn measure(setup: &Setup<'_>, like: &Projector, views: &[ViewRequest]) -> Result<Self> {
        let mut all = Vec::new();
        let layers = Layers { intensity: true, ..Layers::default() };
        for (name, algorithm) in [
            ("joseph", Algorithm::Joseph),
            ("march, step 0.5", Algorithm::March { step: 0.5 }),
            ("siddon", Algorithm::Siddon),
        ] {
            let scene = Scene { method: algorithm.into(), ..like.scene().clone() };
            let projector = Projector::new(&setup.context, like.volume().clone(), scene)?;
            let kernel = || {
                projector.project(views, layers, SILENT)?;
                Ok(projector.timings().map(|timings| timings.kernel_seconds))
            };
            all.extend(Variant::measure(name, RUNS, kernel, &projector)?);
        }
        all.extend(Self::two_layers(setup, like, views)?);
        let specification = || like.specification_loop(views);
        all.extend(Variant::measure("specification's loop", RUNS_OF_THE_LOOP, specification, like)?);
        Ok(Self(all))
    }

    /// The kernel that sums over energies for both layers of a detector and the moments of their noise, eight sums for
    /// a ray, of the first view; where there are responses at the scene's energies.
    fn two_layers(setup: &Setup<'_>, like: &Projector, views: &[ViewRequest]) -> Result<Option<Variant>> {
        let scene = like.scene();
        let layer = |name| DetectorResponse::named(name, *scene.spectrum.grid());
        let (Ok(top), Ok(bottom)) = (layer("top_energy"), layer("bottom_energy")) else { return Ok(None) };
        let noise = Noise { photons_per_pixel: 1000.0, quantum: true, electronic_photons: 0.0, seed: 0 };
        let scene = Scene {
            detector_layers: vec![top, bottom],
            effects: Effects { noise: Some(noise), ..Effects::default() },
            method: Algorithm::Joseph.into(),
            tolerance: None,
            supersampling: 1,
            ..scene.clone()
        };
        let projector = Projector::new(&setup.context, like.volume().clone(), scene)?;
        let layers = Layers { intensity: true, ..Layers::default() };
        let kernel = || {
            projector.project(&views[..views.len().min(1)], layers, SILENT)?;
            Ok(projector.timings().map(|timings| timings.kernel_seconds))
        };
        Variant::measure("joseph, 8 signals", RUNS, kernel, &projector)
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        let row = |Variant { times, timings }: &Variant| {
            let (registers, local_bytes) = (timings.registers, timings.local_bytes);
            json!({ "kernel": times.name, "seconds": times.to_json(), "registers": registers, "local_bytes": local_bytes })
        };
        self.0.iter().map(row).collect()
    }

    /// One line each; `floor` is the time of one read of the volume.
    pub(super) fn say(&self, floor: f64, console: Console) {
        console.say("  kernels, intensity only:");
        for Variant { times, timings } in &self.0 {
            times.say(console);
            console.say(format_args!(
                "  {:<20} {:.2} times one read of the volume; {} registers, {} bytes of memory per thread",
                "",
                times.median() / floor,
                timings.registers,
                timings.local_bytes
            ));
        }
    }
}

impl Variant {
    /// `None` when the engine does not have it.
    fn measure(
        name: &'static str,
        runs: usize,
        kernel: impl Fn() -> drr::Result<Option<f64>>,
        projector: &Projector,
    ) -> Result<Option<Self>> {
        let mut times = Times::new(name);
        for run in 0..=runs {
            let Some(seconds) = kernel()? else { return Ok(None) };
            if run > 0 {
                times.all.push(seconds);
            }
        }
        Ok(projector.timings().map(|timings| Self { times, timings }))
    }
}
