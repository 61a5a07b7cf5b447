//! `drr reconstruct --joint`: the volume, and where its views really are.

mod report;

use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use drr::Context;
use drr::alignment::{JointAlignment, JointProblem, JointRound, Misalignment, without_common_motion};
use drr::parallel::{ParallelGeometry, ViewParameters};

use super::Scan;
use super::acquisition::Geometry;
use super::method::{Found, MethodArguments};
use crate::console::Console;
use crate::rms::rms;
use crate::value;
pub(super) use report::Report;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Joint alignment")]
pub(super) struct JointArguments {
    /// Find where the views of a parallel beam really are, too; simulated ones get hidden errors in all five parameters
    #[arg(long)]
    pub(super) joint: bool,
    /// Largest hidden error of an angle, degrees
    #[arg(long, value_name = "DEGREES", value_parser = value::finite, default_value = "1", requires = "joint")]
    #[arg(allow_negative_numbers = true, conflicts_with = "measured")]
    max_degrees: f64,
    /// Largest hidden error of a translation, mm
    #[arg(long, value_name = "MM", value_parser = value::finite, default_value = "2", requires = "joint")]
    #[arg(allow_negative_numbers = true, conflicts_with = "measured")]
    max_mm: f64,
    /// Joint steps of Gauss and Newton in volume and views, after two rounds of shifts of each view on its own
    #[arg(long, value_name = "N", default_value = "8", requires = "joint", allow_negative_numbers = true)]
    #[arg(value_parser = rounds)]
    rounds: usize,
}

fn rounds(text: &str) -> Result<usize, String> {
    super::within(text, 0, 10_000)
}

/// Root mean squares over all views.
#[derive(Debug, Clone, Copy)]
pub(super) struct Misaligned {
    pub(super) degrees: f64,
    pub(super) mm: f64,
}

/// A round, judged.
pub(super) struct Round {
    pub(super) residual: f64,
    /// Where the hidden errors are known.
    pub(super) errors: Option<Misaligned>,
}

/// What was found.
pub(super) struct Joint {
    pub(super) views: Vec<ViewParameters>,
    pub(super) rounds: Vec<Round>,
    pub(super) seconds: f64,
    /// With the views where they were thought to be, where they were found, and, if that is known, where they are.
    pub(super) before: Found,
    pub(super) after: Found,
    pub(super) best: Option<Found>,
}

impl JointArguments {
    /// # Errors
    /// For a cone beam.
    pub(super) fn validate(&self, parallel: bool) -> Result<()> {
        if self.joint && !parallel {
            bail!(
                "--joint is given with a cone beam; valid: with a parallel beam, whose views have five parameters"
            );
        }
        self.misalignment(0).validate().context("--max-degrees, --max-mm")
    }

    fn misalignment(&self, seed: u64) -> Misalignment {
        Misalignment { degrees: self.max_degrees, mm: self.max_mm, seed }
    }

    /// Where simulated views really are, with nothing in common, which could not be seen.
    pub(super) fn hidden(&self, nominal: &Geometry, seed: u64) -> Result<Geometry> {
        let Geometry::Parallel(geometry, views) = nominal else { return Ok(nominal.clone()) };
        let errors = self.misalignment(seed);
        let hidden: Vec<_> = views.iter().enumerate().map(|(n, view)| errors.applied(n, view)).collect();
        Ok(Geometry::Parallel(*geometry, without_common_motion(&hidden, views).context("--max-degrees")?))
    }

    /// Finds views and volume.
    pub(super) fn solve(
        &self,
        context: &Context,
        scan: &Scan,
        method: &MethodArguments,
        console: Console,
    ) -> Result<Joint> {
        let Geometry::Parallel(geometry, nominal) = &scan.geometry else {
            bail!("--joint needs a parallel beam")
        };
        let hidden = match &scan.hidden {
            Some(Geometry::Parallel(_, views)) => Some(views.clone()),
            _ => None,
        };
        let before = method.reconstruct(context, scan, console)?;
        let start = Instant::now();
        let settings = JointAlignment { rounds: self.rounds, ..JointAlignment::of(geometry) };
        let problem = JointProblem { geometry, images: &scan.data, views: nominal };
        let mut rounds = Vec::new();
        let bar = console.bar("aligning", 1 + settings.alignments + settings.rounds);
        let found = settings.solve(context, &problem, &mut |round: &JointRound<'_, f32>| {
            let errors = hidden.as_ref().and_then(|hidden| Misaligned::of(round.views, hidden).ok());
            rounds.push(Round { residual: round.residual, errors });
            bar.inc(1);
            ControlFlow::Continue(())
        });
        bar.finish_and_clear();
        let found = found.context("--joint")?;
        let seconds = start.elapsed().as_secs_f64();
        let at =
            |views: &[ViewParameters]| method.reconstruct(context, &scan.seen_from(geometry, views), console);
        let after = at(&found.views)?;
        let best = hidden.as_deref().map(at).transpose()?;
        Ok(Joint { views: found.views, rounds, seconds, before, after, best })
    }
}

impl Misaligned {
    /// Differences to where views are, but for a motion that all have in common.
    pub(super) fn of(views: &[ViewParameters], truth: &[ViewParameters]) -> Result<Self> {
        let views = without_common_motion(views, truth)?;
        let of = |parameters: Range<usize>| {
            rms(views.iter().zip(truth).flat_map(|(own, right)| {
                let (own, right) = (own.to_array(), right.to_array());
                parameters.clone().map(move |k| own[k] - right[k])
            }))
        };
        Ok(Self { degrees: of(0..3).to_degrees(), mm: of(3..ViewParameters::COUNT) })
    }
}

impl Scan {
    /// The same data, of views that are elsewhere.
    fn seen_from(&self, geometry: &ParallelGeometry, views: &[ViewParameters]) -> Self {
        Self { geometry: Geometry::Parallel(*geometry, views.to_vec()), ..self.clone() }
    }
}

/// Writes the views that were found.
pub(super) fn write_found(folder: &Path, joint: &Joint) -> Result<()> {
    Ok(drr::formats::write_views(&folder.join("aligned.csv"), &joint.views)?)
}
