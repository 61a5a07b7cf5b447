//! Completions by the shells that they are for.

use std::path::Path;

use libtest_mimic::{Failed, Trial};

use crate::needing::needing;
use crate::{drr, expect, program, succeed};

pub(super) fn tests() -> Vec<Trial> {
    let name = "completions::bash_completes_subcommands_options_and_values";
    vec![
        needing(name, program("bash"), |tool| bash(&tool)),
        Trial::test("completions::every_shell_has_them", every_shell),
    ]
}

fn bash(bash: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("drr.bash"), drr(&["completions", "bash"], folder.path())?)?;
    succeed(bash, &["-n", "drr.bash"], folder.path())?;
    let cases = [
        ("drr pro", "project"),
        ("drr project --form", "--formats"),
        ("drr project --layers bone", "bone_path"),
    ];
    for (typed, expected) in cases {
        let words: Vec<&str> = typed.split(' ').collect();
        let [.., before, word] = words[..] else { unreachable!("two words at least") };
        let script = format!(
            "source drr.bash; COMP_WORDS=({typed}); COMP_CWORD={}; _drr drr '{word}' '{before}'; echo \"${{COMPREPLY[@]}}\"",
            words.len() - 1
        );
        let offered = succeed(bash, &["--norc", "-c", &script], folder.path())?;
        expect(offered.split_whitespace().any(|word| word == expected), || format!("{typed}: {offered}"))?;
    }
    Ok(())
}

fn every_shell() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = drr(&["completions", shell], folder.path())?;
        expect(["reconstruct", "formats"].iter().all(|word| script.contains(word)), || {
            format!("{shell}: {script}")
        })?;
    }
    expect(drr(&["completions", "cmd"], folder.path()).is_err(), || "a shell that nobody knows".into())
}
