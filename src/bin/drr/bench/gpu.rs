//! What a GPU's own clock says.

use anyhow::Result;
use drr::engine::Timings;
use drr::{Context, Projector};
use serde_json::json;

use crate::bench::times::Times;
use crate::bench::variants::Variants;
use crate::console::Console;
use crate::value::{prefixed, seconds};

/// Fewest launches whose median is reported: they take milliseconds.
pub(super) const RUNS: u32 = 50;

/// Times of the kernel, and of copies between its launches.
pub(super) struct Gpu {
    timings: Timings,
    kernel: Times,
    /// One read of the volume at the speed of the copies.
    floor: Times,
    copy: Times,
    pub(super) variants: Option<Variants>,
}

impl Gpu {
    /// Nothing measured yet; `None` when the engine runs on the CPU.
    pub(super) fn of(projector: &Projector) -> Option<Self> {
        let timings = projector.timings()?;
        let [kernel, floor, copy] = ["kernel", "floor", "copy"].map(Times::new);
        Some(Self { timings, kernel, floor, copy, variants: None })
    }

    /// Notes the projection that has just ended, and copies as many bytes as the volume has.
    pub(super) fn note(&mut self, projector: &Projector) -> Result<()> {
        let (Some(timings), Some(bandwidth)) = (projector.timings(), projector.copy_bandwidth()?) else {
            return Ok(());
        };
        let bytes = timings.volume_bytes as f64;
        self.kernel.all.push(timings.kernel_seconds);
        self.floor.all.push(bytes / bandwidth);
        self.copy.all.push(2.0 * bytes / bandwidth);
        self.timings = timings;
        Ok(())
    }

    /// Bytes read and written per second.
    fn bandwidth(&self) -> f64 {
        2.0 * self.timings.volume_bytes as f64 / self.copy.median()
    }

    fn ratio(&self) -> f64 {
        self.kernel.median() / self.floor.median()
    }

    pub(super) fn to_json(&self, context: &Context, samples: f64) -> serde_json::Value {
        json!({
            "device": context.device_name().to_string_lossy(),
            "driver": context.device_driver(),
            "kernel": self.kernel.to_json(),
            "kernel_runs": self.kernel.all.len(),
            "upload_seconds": self.timings.upload_seconds,
            "compile_seconds": self.timings.compile_seconds,
            "registers": self.timings.registers,
            "local_bytes": self.timings.local_bytes,
            "volume_bytes": self.timings.volume_bytes,
            "copy": self.copy.to_json(),
            "copy_bytes_per_second": self.bandwidth(),
            "floor_seconds": self.floor.median(),
            "ratio_to_floor": self.ratio(),
            "samples_per_second": samples / self.kernel.median(),
            "variants": self.variants.as_ref().map(Variants::to_json),
        })
    }

    pub(super) fn say(&self, context: &Context, samples: f64, console: Console) {
        let Timings { upload_seconds, compile_seconds, registers, local_bytes, .. } = self.timings;
        let device = context.device_name().to_string_lossy();
        console.say(format_args!("  on                   {device}, {}", context.device_driver()));
        self.kernel.say(console);
        console.say(format_args!(
            "  kernel, {} runs      {}samples/s; {registers} registers and {local_bytes} bytes of memory per thread",
            self.kernel.all.len(),
            prefixed(samples / self.kernel.median()),
        ));
        console.say(format_args!(
            "  once                 upload {}, compilation {}",
            seconds(upload_seconds),
            seconds(compile_seconds),
        ));
        console.say(format_args!(
            "  floor                {}, one read of the volume at {}B/s, the speed of copies; the kernel takes {:.2} times as long",
            seconds(self.floor.median()),
            prefixed(self.bandwidth()),
            self.ratio(),
        ));
        if let Some(variants) = &self.variants {
            variants.say(self.floor.median(), console);
        }
    }
}
