//! `drr plan`.

use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use drr::engine::{Backend, Layers};
use drr::plan::Plan;
use drr::{Projector, StageTimes};

use crate::console::Console;
use crate::inputs::Inputs;
use crate::views::Views;

/// What is projected to be timed.
const SIGNALS: Layers =
    Layers { intensity: true, line_integral: true, areal_density: false, bone_path: false };

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    inputs: Inputs,
    /// Project once as well, and tell what every stage took
    #[arg(long, help_heading = "Output")]
    measure: bool,
    /// Print the plan as JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// `drr plan`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.json);
    let setup = arguments.inputs.setup()?;
    let volume = Arc::new(setup.load(console)?.volume);
    let views = setup.views(&volume)?;
    let projector = setup.projector(volume, &views)?;
    let plan =
        if arguments.measure { measured(&projector, &views, console)? } else { projector.plan().clone() };
    if arguments.json {
        Console::answer(plan.to_json());
        return Ok(ExitCode::SUCCESS);
    }
    Console::answer(format_args!("{}: {}", arguments.inputs.ct.name(), plan.to_string().trim_end()));
    Ok(ExitCode::SUCCESS)
}

/// The plan with what its stages take, intensity and line integral of all views; of a second projection, because the
/// first makes what is kept.
fn measured(projector: &Projector, views: &Views, console: Console) -> Result<Plan> {
    let requests = views.requests();
    let bar = console.bar("projecting", 2 * projector.rays(&requests));
    let progress = |rays: usize| {
        bar.inc(rays as u64);
        ControlFlow::Continue(())
    };
    let mut plan = projector.plan().clone();
    for _ in 0..2 {
        let start = Instant::now();
        let times = if plan.engine == Backend::Reference {
            projector.reference(plan.method.algorithm, &requests, SIGNALS, &progress)?;
            StageTimes::default()
        } else {
            projector.project_timed(&requests, SIGNALS, &progress)?.1
        };
        plan = projector.plan().with_measured(&times, start.elapsed().as_secs_f64(), requests.len());
    }
    bar.finish_and_clear();
    Ok(plan)
}
