//! What a planner chose, what it rejected, and why.

use serde::Serialize;

use crate::accuracy::{CONFIDENCE, Estimate};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::method::{Algorithm, Energies, Method};
use crate::physics::Quadrature;
use crate::planner::candidates::candidates;
use crate::planner::judge::Judge;
use crate::planner::{Effort, expected};
use crate::scene::Scene;
use crate::tolerance::Tolerance;
use crate::volume::Volume;

/// How a method fared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The cheapest that keeps the tolerance.
    Chosen,
    /// Cheaper, but its error is too large.
    MissesTolerance,
    /// Not measured: dearer than the chosen one, or there is nothing to measure.
    NotMeasured,
    /// Taken without having been measured: no ray of the expected views meets anything.
    TakenUnmeasured,
}

/// A method that was considered.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidate {
    /// The method.
    pub method: Method,
    /// Predicted time of all expected views, s.
    pub seconds: f64,
    /// Its error, HU-equivalents; `None` when it was not measured, or no ray is above the floor.
    pub hu: Option<Estimate>,
    /// The displacement of edges that would explain it, mm.
    pub mm: Option<Estimate>,
    /// How it fared.
    pub verdict: Verdict,
}

/// A planner's choice, with its reasons.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// What was asked for.
    pub tolerance: Tolerance,
    /// The confidence that is aimed at: the test `truthfulness` tells how often a tolerance is kept.
    pub confidence: f64,
    /// Rays that the methods were measured on, and those that were integrated exactly.
    pub rays: [usize; 2],
    /// The p above which errors count.
    pub floor: f64,
    /// Where the predicted times come from.
    pub costs: String,
    /// Everything that was considered, cheapest first.
    pub candidates: Vec<Candidate>,
}

impl Choice {
    /// All candidates, cheapest first, none measured.
    pub(super) fn new(
        context: &Context,
        volume: &Volume,
        scene: &Scene,
        tolerance: Tolerance,
        energies: Energies,
        judge: &Judge,
        quadrature: Option<&Quadrature>,
    ) -> Result<Self> {
        let effort = Effort::new(&expected::views(scene, volume), volume.grid(), scene)?;
        let summed = quadrature.map_or(scene.spectral_model()?.bins(), |few| few.nodes().len());
        let costs = context.costs();
        let candidate = |method: Method| {
            let seconds = costs.seconds(context, method, &effort, summed);
            Candidate { method, seconds, hu: None, mm: None, verdict: Verdict::NotMeasured }
        };
        let mut candidates: Vec<_> = candidates(energies).into_iter().map(candidate).collect();
        candidates.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let (floor, rays, costs) = (judge.floor(), judge.rays(), costs.name(context.backend()).to_owned());
        Ok(Self { tolerance, confidence: CONFIDENCE, rays, floor, costs, candidates })
    }

    /// The chosen candidate.
    pub fn chosen(&self) -> Option<&Candidate> {
        let taken = [Verdict::Chosen, Verdict::TakenUnmeasured];
        self.candidates.iter().find(|candidate| taken.contains(&candidate.verdict))
    }

    /// Takes an algorithm as there is nothing to measure.
    pub(super) fn take_unmeasured(&mut self, algorithm: Algorithm) {
        for candidate in self.candidates.iter_mut().filter(|c| c.method.algorithm == algorithm) {
            candidate.verdict = Verdict::TakenUnmeasured;
        }
    }

    /// # Errors
    /// `InvalidArgument` when no candidate keeps the tolerance.
    pub(super) fn method(&self) -> Result<Method> {
        self.chosen().map(|candidate| candidate.method).ok_or_else(|| {
            let high = |error: Option<Estimate>| error.map_or(0.0, |error| error.rms_high);
            let best = self.candidates.iter().min_by(|a, b| high(a.hu).total_cmp(&high(b.hu)));
            // Rounded up: it can be had.
            let [hu, mm] = best.map_or([0.0; 2], |best| [best.hu, best.mm].map(|e| 1.01 * high(e)));
            let valid = format!("at least {hu:.2e} HU and {mm:.2e} mm, which the finest of the engine's methods reaches in this scene");
            Error::invalid("scene.tolerance", self.tolerance, valid)
        })
    }
}

impl Candidate {
    /// Notes a measurement. Whether it keeps the tolerance.
    pub(super) fn judge(&mut self, measured: [Option<Estimate>; 2], tolerance: Tolerance) -> bool {
        [self.hu, self.mm] = measured;
        let within = |error: Option<Estimate>, most: f64| error.is_none_or(|error| error.rms_high <= most);
        let keeps = within(self.hu, tolerance.hu) && within(self.mm, tolerance.mm);
        self.verdict = if keeps { Verdict::Chosen } else { Verdict::MissesTolerance };
        keeps
    }
}

/// One line per method that was looked at.
impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { tolerance, confidence, rays: [rays, exact], costs, .. } = self;
        write!(
            f,
            "  tolerance {tolerance} RMSE, aiming at {:.0} % confidence, by {rays} rays and {exact} exact ones; predicted times by {costs}:",
            100.0 * confidence
        )?;
        for candidate in &self.candidates {
            let Candidate { method, seconds, hu, verdict, .. } = candidate;
            let verdict = match verdict {
                Verdict::Chosen => "chosen",
                Verdict::MissesTolerance => "misses it",
                Verdict::NotMeasured => "not measured",
                Verdict::TakenUnmeasured => "taken unmeasured: no ray of the expected views meets anything",
            };
            let error =
                hu.map_or(String::new(), |e| format!("{} HU, below {}; ", digits(e.rms), digits(e.rms_high)));
            let (algorithm, seconds) = (method.algorithm.to_string(), digits(*seconds));
            write!(f, "\n        {algorithm:<24} {seconds:>9} s  {error}{verdict}")?;
        }
        Ok(())
    }
}

/// Four digits, with an exponent where zeros would hide them.
fn digits(value: f64) -> String {
    match value {
        0.0 | 1.0.. => format!("{value:.3}"),
        0.01.. => format!("{value:.4}"),
        _ => format!("{value:.3e}"),
    }
}
