//! The command `drr`: X-ray projections of CT volumes. Every subcommand is a file; `drr --help` is the manual.
#![allow(clippy::doc_markdown, reason = "comments on arguments are texts for a terminal, not Markdown")]

mod algorithm;
mod align;
mod batch;
mod bench;
mod certificate;
mod charts;
mod check;
mod cli;
mod completions;
mod console;
mod ct;
mod default_ct;
mod effect_arguments;
mod effects;
mod fingerprint;
mod fit;
mod format;
mod inputs;
mod job;
mod layer;
mod line_integrals;
mod manual;
mod memory;
mod metadata;
mod method;
mod object;
mod output;
mod phantom;
mod physics;
mod plan;
mod project;
mod reconstruct;
mod register;
mod report;
mod rms;
mod rounding;
mod times;
mod tradeoff;
mod validate;
mod value;
mod views;

use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;

use cli::{Cli, Command};
use console::Console;

/// What went wrong lies in the arguments or in an input.
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            error.exit()
        }
        Err(error) => {
            // One line, without the usage that clap adds after an empty line.
            let text = error.to_string();
            let message = text.split("\n\n").next().unwrap_or(&text);
            eprintln!("{}", message.split_whitespace().collect::<Vec<_>>().join(" "));
            return ExitCode::from(BAD_INPUT);
        }
    };
    let console = Console::new(cli.quiet);
    let done = match cli.command {
        None => project::main_job(console),
        Some(Command::Project(arguments)) => project::run(&arguments, console),
        Some(Command::Plan(arguments)) => plan::run(&arguments, console),
        Some(Command::Tradeoff(arguments)) => tradeoff::run(&arguments, console),
        Some(Command::Effects(arguments)) => effects::run(&arguments, console),
        Some(Command::Reconstruct(arguments)) => reconstruct::run(&arguments, console),
        Some(Command::Register(arguments)) => register::run(&arguments, console),
        Some(Command::Rounding(arguments)) => rounding::run(&arguments, console),
        Some(Command::Align(arguments)) => align::run(&arguments, console),
        Some(Command::Bench(arguments)) => bench::run(&arguments, console),
        Some(Command::Phantom(arguments)) => phantom::run(&arguments, console),
        Some(Command::Validate(arguments)) => validate::run(&arguments, console),
        Some(Command::Check(arguments)) => check::run(&arguments, console),
        Some(Command::Manual(arguments)) => manual::run(&arguments, console),
        Some(Command::Completions(arguments)) => completions::run(&arguments),
    };
    done.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        match error.downcast_ref::<drr::Error>() {
            Some(drr::Error::OutOfMemory { .. }) => ExitCode::FAILURE,
            _ => ExitCode::from(BAD_INPUT),
        }
    })
}
