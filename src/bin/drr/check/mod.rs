//! `drr check`: the hard cases, on the engines of this machine, against exact arithmetic.

mod bounds;
mod case;
mod families;
mod judge;
mod row;
mod truth;
mod volumes;

use std::panic::resume_unwind;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Result, bail};
use clap::Args;
use drr::engine::Backend;
use drr::{Algorithm, Context};
use serde_json::json;

use crate::console::Console;
use crate::method::EngineName;
use case::{Case, Demand};
use families::TITLES;
use judge::Judge;
use row::{Deviation, HEADING, Row};

/// The engines that are checked when none is named, each where this machine has it.
const ENGINES: [Backend; 4] = [Backend::Cpu, Backend::Reference, Backend::Cuda, Backend::Metal];
/// Each case has its own step for the march.
const ALGORITHMS: [Algorithm; 5] = [
    Algorithm::Joseph,
    Algorithm::March { step: 0.5 },
    Algorithm::Siddon,
    Algorithm::DistanceDriven,
    Algorithm::Exact,
];

#[derive(Debug, Args)]
#[command(after_help = "\
Every case is a small volume and a few rays, most of them by pose (segments) and by uniforms in float32 (half-lines), with
every algorithm that an engine has; every layer asked for counts. What is right is computed here, in exact rational
arithmetic; a row shows the layer that uses most of its bound. S is the exact integral, V the largest density, X half the
volume's diagonal, D the largest coordinate of volume, source and first pixel (X and D in cm for areal densities):

  float32 engines   areal density, bone path  1e-6 S + 8 2^-24 X V      line integral  2e-6 p + 1e-6
  float64 engine    areal density, bone path  1e-13 S + 8 2^-53 D V     line integral  1e-13 p + 1e-14 + that of S

Where rounding decides on which side of a face a ray lies, right is also what lies between the values of the rays beside
it, 8 2^-24 X (8 2^-53 D) away. A row with a bound of 0 compares bytes, or is about an input that must be refused.
Exit code 1 when a row fails.")]
pub(crate) struct Arguments {
    /// Only the families with these numbers, 1 to 28
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = clap::value_parser!(u8).range(1..=28))]
    family: Vec<u8>,
    /// Only the cases with this text in their names
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Only these engines [default: all that this machine has, but host]
    #[arg(long, value_enum, value_name = "NAME,...", value_delimiter = ',')]
    engine: Vec<EngineName>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Threads; 0 is one per core
    #[arg(long, value_name = "N", default_value = "0")]
    threads: usize,
}

impl Arguments {
    fn wants(&self, case: &Case) -> bool {
        let family = self.family.is_empty() || self.family.iter().any(|&n| usize::from(n) == case.family);
        family && self.only.as_ref().is_none_or(|text| case.name.contains(text))
    }
}

impl Arguments {
    /// Of the engines that are named; or of those that are there.
    fn contexts(&self) -> drr::Result<Vec<Context>> {
        if self.engine.is_empty() {
            return Ok(ENGINES
                .into_iter()
                .filter_map(|engine| Context::new(engine, self.threads).ok())
                .collect());
        }
        self.engine.iter().map(|engine| Context::new(engine.backend(), self.threads)).collect()
    }
}

/// `drr check`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let console = console.without_text(arguments.json);
    let contexts = arguments.contexts()?;
    let cases: Vec<_> = families::all().into_iter().filter(|case| arguments.wants(case)).collect();
    if cases.is_empty() {
        let Arguments { family, only, .. } = arguments;
        let only = only.as_deref().unwrap_or_default();
        bail!(
            "--family {family:?} with --only \"{only}\" leaves no case; valid: what `drr check` prints without them"
        );
    }
    let bar = console.bar("checking", cases.len());
    let of_case = |case: &Case| {
        let rows = rows(case, &contexts);
        bar.inc(1);
        rows
    };
    let rows = all_rows(&cases, contexts[0].threads(), of_case);
    bar.finish_and_clear();

    let holds = rows.iter().all(|row| row.holds);
    if arguments.json {
        Console::answer(json!({
            "holds": holds, "version": drr::VERSION, "cases": cases.len(), "families": TITLES, "rows": rows,
        }));
    } else {
        console.say(HEADING);
        for row in &rows {
            console.say(row);
        }
        console.say(summary(cases.len(), &rows, &contexts));
    }
    Ok(if holds { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The rows of all cases, in their order. On threads of its own: one of a pool that waits for an engine's pool would
/// begin the next case meanwhile, and so on, one case deeper in its stack each time.
fn all_rows(cases: &[Case], threads: usize, of_case: impl Fn(&Case) -> Vec<Row> + Sync) -> Vec<Row> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mine = std::iter::from_fn(|| {
            let n = next.fetch_add(1, Ordering::Relaxed);
            cases.get(n).map(|case| (n, of_case(case)))
        });
        mine.collect::<Vec<_>>()
    };
    let mut rows: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let done =
            threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
        done.flatten().collect()
    });
    rows.sort_by_key(|(n, _)| *n);
    rows.into_iter().flat_map(|(_, rows)| rows).collect()
}

/// One row for every algorithm and engine.
fn rows(case: &Case, contexts: &[Context]) -> Vec<Row> {
    // A refusal does not get as far as an algorithm.
    let algorithms = if matches!(case.demand, Demand::Refused(..)) { &ALGORITHMS[..1] } else { &ALGORITHMS };
    let mut rows = Vec::new();
    for &algorithm in algorithms {
        let judge = Judge::new(case, algorithm);
        for context in contexts {
            let (worst, note) = match judge.verdict(context) {
                Ok(verdict) => verdict,
                Err(drr::Error::Unsupported(_)) => continue,
                Err(error) => (Deviation::NOT_SEEN, Some(error.to_string())),
            };
            rows.push(Row {
                family: case.family,
                case: case.name.clone(),
                algorithm: if algorithms.len() == 1 { "any" } else { algorithm.name() },
                engine: context.backend().name(),
                holds: worst.ratio() <= 1.0,
                worst,
                note,
            });
        }
    }
    rows
}

fn summary(cases: usize, rows: &[Row], contexts: &[Context]) -> String {
    let failed = rows.iter().filter(|row| !row.holds).count();
    if failed > 0 {
        return format!("{failed} of {} rows fail", rows.len());
    }
    let used = |engine: &str| {
        let of_engine = rows.iter().filter(|row| row.engine == engine);
        of_engine.map(|row| row.worst.ratio()).fold(0.0, f64::max)
    };
    let names = contexts.iter().map(|context| context.backend().name());
    let engines: Vec<_> = names.map(|name| format!("{name} {:.2}", used(name))).collect();
    format!(
        "{cases} cases, {} rows: all hold. Most of a bound that was used: {}",
        rows.len(),
        engines.join(", ")
    )
}
