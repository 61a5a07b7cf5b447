//! `drr manual`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, Command, CommandFactory as _};
use clap_mangen::Man;
use drr::formats::write_text;

use crate::cli::Cli;
use crate::console::Console;
use crate::output::prepare;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder for the pages, such as /usr/local/share/man/man1; it is made where it is missing
    #[arg(long, short, value_name = "DIR")]
    output: PathBuf,
}

/// `drr manual`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    prepare(&arguments.output)?;
    let mut command = Cli::command().disable_help_subcommand(true);
    // Subcommands learn their whole names.
    command.build();
    let subcommands: Vec<Command> = command.get_subcommands().cloned().collect();
    for command in [command].into_iter().chain(subcommands) {
        let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
        let page = Man::new(command).title(name);
        let mut text = Vec::new();
        page.render(&mut text)?;
        write_text(&arguments.output.join(page.get_filename()), &String::from_utf8(text)?)?;
    }
    console.say(format_args!("wrote   drr.1 and one page per subcommand in {}", arguments.output.display()));
    Ok(ExitCode::SUCCESS)
}
