//! The parallel beam with its derivatives, on a volume of its own.

use std::process::ExitCode;
use std::time::Instant;

use anyhow::Result;
use drr::engine::Timings;
use drr::parallel::{ParallelGeometry, ParallelProjector, Quadrature, RaySelection, ViewParameters};
use drr::{Context, Error};
use glam::DVec3;
use serde_json::json;

use crate::bench::gpu;
use crate::bench::times::Times;
use crate::console::Console;
use crate::memory;

/// The volume's edge, mm.
const EXTENT: f64 = 358.4;

/// Where the object was when it was measured, and where it is believed to be: near each other, as in an alignment.
const MEASURED: ViewParameters =
    ViewParameters { alpha: 0.020, beta: -0.015, phi: 0.030, dx: 1.50, dz: -2.25 };
const BELIEVED: ViewParameters =
    ViewParameters { alpha: 0.005, beta: 0.004, phi: -0.006, dx: 0.30, dz: 0.70 };

/// Views of the batch.
const BATCH: usize = 16;

/// One call, by the host's clock and by the device's where there is one.
struct Measured {
    name: &'static str,
    call: Times,
    kernel: Times,
    timings: Option<Timings>,
}

impl Measured {
    fn new(
        name: &'static str,
        runs: u32,
        projector: &ParallelProjector<f32>,
        run: impl Fn() -> Result<(), Error>,
    ) -> Result<Self> {
        let mut measured =
            Self { name, call: Times::new("call"), kernel: Times::new("kernel"), timings: None };
        for n in 0..=runs {
            let start = Instant::now();
            run()?;
            let seconds = start.elapsed().as_secs_f64();
            measured.timings = projector.timings();
            // The first one compiles the kernel, and makes pages.
            if n > 0 {
                measured.call.all.push(seconds);
                measured.kernel.all.extend(measured.timings.map(|timings| timings.kernel_seconds));
            }
        }
        Ok(measured)
    }

    /// By the device's clock where there is one.
    fn median(&self) -> f64 {
        if self.timings.is_some() { self.kernel.median() } else { self.call.median() }
    }

    fn to_json(&self) -> serde_json::Value {
        json!({
            "call": self.call.to_json(),
            "kernel": self.timings.map(|_| self.kernel.to_json()),
            "device": self.timings,
        })
    }

    fn say(&self, console: Console) {
        console.say(format_args!("{}", self.name));
        self.call.say(console);
        if let Some(Timings { registers, local_bytes, compile_seconds, .. }) = self.timings {
            self.kernel.say(console);
            console.say(format_args!(
                "  {registers} registers and {local_bytes} bytes of memory per thread, compiled in {compile_seconds:.2} s"
            ));
        }
    }
}

/// Something of every frequency.
fn volume(n: usize) -> Vec<f32> {
    let value = |at: usize| {
        let [x, y, z] = [at % n, at / n % n, at / (n * n)].map(|i| i as f64 / n as f64 - 0.5);
        let inside = x * x + y * y + z * z < 0.2;
        let grain = (at.wrapping_mul(2_654_435_761) % 1024) as f64 / 1024.0;
        (if inside { 0.02 + 0.005 * (20.0 * (x + y * z)).sin() + 0.001 * grain } else { 0.0 }) as f32
    };
    (0..n * n * n).map(value).collect()
}

/// The calls that are measured, each so often.
struct Stages {
    forward: Measured,
    gradient: Measured,
    batch: Measured,
    runs: u32,
}

impl Stages {
    fn new(context: &Context, n: usize, runs: u32) -> Result<Self> {
        let edge = EXTENT / n as f64;
        let geometry = ParallelGeometry::new([n; 3], DVec3::splat(edge), [n; 2], [edge; 2]);
        let projector = ParallelProjector::<f32>::new(context, geometry, Quadrature::Steps, &volume(n))?;
        let all = RaySelection::default();
        let measured = projector.forward_project_view(&MEASURED, all)?;
        let turn =
            |k: usize| ViewParameters { phi: std::f64::consts::TAU * k as f64 / BATCH as f64, ..BELIEVED };
        let batch: Vec<_> = (0..BATCH).map(turn).collect();
        let runs = if projector.timings().is_some() { runs.max(gpu::RUNS) } else { runs };
        Ok(Self {
            forward: Measured::new("forward, one view", runs, &projector, || {
                projector.forward_project_view(&BELIEVED, all).map(drop)
            })?,
            gradient: Measured::new("value and gradient, one view", runs, &projector, || {
                projector.view_loss_value_and_grad(&BELIEVED, &measured, all).map(drop)
            })?,
            batch: Measured::new("forward, 16 views", runs, &projector, || {
                projector.batch_forward_project(&batch).map(drop)
            })?,
            runs,
        })
    }

    /// How many times as long the gradient takes as the image.
    fn ratio(&self) -> f64 {
        self.gradient.median() / self.forward.median()
    }

    fn to_json(&self, context: &Context, n: usize) -> serde_json::Value {
        json!({
            "engine": context.backend().name(),
            "device": context.device_name().to_string_lossy(),
            "threads": context.threads(),
            "version": drr::VERSION,
            "edge": n,
            "runs": self.runs,
            "forward": self.forward.to_json(),
            "value_and_gradient": self.gradient.to_json(),
            "forward_16_views": self.batch.to_json(),
            "gradient_to_forward": self.ratio(),
            "peak_bytes": memory::peak_bytes(),
        })
    }
}

/// `drr bench --parallel`.
pub(super) fn run(
    context: &Context,
    (n, runs): (usize, u32),
    as_json: bool,
    console: Console,
) -> Result<ExitCode> {
    let stages = Stages::new(context, n, runs)?;
    if as_json {
        Console::answer(stages.to_json(context, n));
        return Ok(ExitCode::SUCCESS);
    }
    console.say(format_args!(
        "parallel beam, {n}³ voxels, {n}² pixels, {n} steps, {} with {} thread(s), {} runs {}",
        context.backend().name(),
        context.threads(),
        stages.runs,
        context.device_name().to_string_lossy(),
    ));
    for stage in [&stages.forward, &stages.gradient, &stages.batch] {
        stage.say(console);
    }
    console.say(format_args!("value and gradient take {:.2} times as long as forward", stages.ratio()));
    Ok(ExitCode::SUCCESS)
}
