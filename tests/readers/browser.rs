//! The report in a browser.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::process::Command;

use libtest_mimic::{Failed, Trial};

use crate::needing::ignored;
use crate::{expect, program, project};

pub(super) fn tests() -> Vec<Trial> {
    let name = "report::a_browser_shows_it_without_complaint";
    vec![match program("chromium") {
        Ok(chromium) => Trial::test(name, move || report(&chromium)),
        // Also where every tool is required: it takes longer to install than all others.
        Err(reason) => ignored(name, reason),
    }]
}

fn report(chromium: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    project(folder.path(), &["--report"])?;
    let shot = folder.path().join("shot.png");
    let address = format!("file://{}", folder.path().join("out/report.html").display());
    let output = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--window-size=1000,1600", "--hide-scrollbars", "--enable-logging=stderr", "--log-level=0"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("--screenshot={}", shot.display()))
        .arg(&address)
        .output()?;
    let log = String::from_utf8_lossy(&output.stderr);
    expect(!log.contains(":CONSOLE"), || log.to_string())?;
    let mut reader = png::Decoder::new(BufReader::new(File::open(&shot)?)).read_info()?;
    let mut pixels = vec![0; reader.output_buffer_size().ok_or("too large")?];
    let info = reader.next_frame(&mut pixels)?;
    let samples = info.color_type.samples();
    let mut colours: Vec<&[u8]> = pixels.chunks_exact(samples).collect();
    colours.sort_unstable();
    colours.dedup();
    // Paper, letters with smooth edges, and the greys of a radiograph.
    expect((info.width, info.height) == (1000, 1600) && colours.len() > 150, || {
        format!("{}×{}, {} colours", info.width, info.height, colours.len())
    })
}
