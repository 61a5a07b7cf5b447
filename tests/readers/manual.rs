//! Manual pages by man.

use std::path::Path;

use libtest_mimic::{Failed, Trial};

use crate::needing::needing;
use crate::{drr, expect, program, succeed};

pub(super) fn tests() -> Vec<Trial> {
    vec![
        Trial::test("manual::every_subcommand_has_a_page", pages),
        needing("manual::pages_are_without_fault", program("mandoc"), |tool| without_fault(&tool)),
    ]
}

/// The subcommands that the help lists.
fn subcommands() -> Result<Vec<String>, Failed> {
    let folder = tempfile::tempdir()?;
    let help = drr(&["--help"], folder.path())?;
    let (_, list) = help.split_once("Commands:\n").ok_or("no commands")?;
    let lines = list.lines().take_while(|line| !line.is_empty());
    // A text goes on in the next line with more indentation.
    let names =
        lines.filter(|line| !line.starts_with("   ")).filter_map(|line| line.split_whitespace().next());
    Ok(names.filter(|name| *name != "help").map(Into::into).collect())
}

fn pages() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    drr(&["manual", "--output", "man1"], folder.path())?;
    let subcommands = subcommands()?;
    expect(subcommands.len() > 12, || format!("{subcommands:?}"))?;
    for subcommand in &subcommands {
        let path = folder.path().join(format!("man1/drr-{subcommand}.1"));
        let page = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        expect(
            page.contains(".SH OPTIONS")
                && page.contains(&format!(".TH drr-{subcommand} 1"))
                && page.contains(&format!("drr\\-{subcommand}")),
            || page.clone(),
        )?;
    }
    let own = std::fs::read_to_string(folder.path().join("man1/drr.1"))?;
    expect(subcommands.iter().all(|name| own.contains(&format!("drr\\-{name}(1)"))), || own.clone())?;
    expect(std::fs::read_dir(folder.path().join("man1"))?.count() == subcommands.len() + 1, || "more".into())
}

/// Nothing that mandoc calls an error, and the texts of the help.
fn without_fault(mandoc: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    drr(&["manual", "--output", "man1"], folder.path())?;
    for entry in std::fs::read_dir(folder.path().join("man1"))? {
        let page = entry?.path();
        let page = page.to_str().ok_or("a name")?;
        succeed(mandoc, &["-T", "lint", "-W", "error", page], folder.path())?;
    }
    let text = succeed(mandoc, &["-T", "utf8", "-O", "width=200", "man1/drr-project.1"], folder.path())?;
    expect(
        ["patient_orientation", "--formats", "radiograph.png"].iter().all(|word| text.contains(word)),
        || text.clone(),
    )
}
