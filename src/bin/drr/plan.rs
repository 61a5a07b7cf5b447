//! `drr plan`.

use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Result;
use clap::Args;

use crate::console::Console;
use crate::inputs::Inputs;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    inputs: Inputs,
    /// Print the plan as JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// `drr plan`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let setup = arguments.inputs.setup()?;
    let volume = Arc::new(setup.load(console)?.volume);
    let views = setup.views(&volume)?;
    let projector = setup.projector(volume, &views)?;
    if arguments.json {
        Console::answer(projector.plan().to_json());
        return Ok(ExitCode::SUCCESS);
    }
    let plan = projector.plan().to_string();
    Console::answer(format_args!("{}: {}", arguments.inputs.ct.name(), plan.trim_end()));
    Ok(ExitCode::SUCCESS)
}
