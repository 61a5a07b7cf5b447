//! Fits of rigid motions, as `align` and `register` report them.

use drr::alignment::{Solution, Stop};

/// A step that was taken.
pub(crate) struct Taken<const N: usize> {
    /// Of all evaluations of loss and derivatives, counted from 1 over all levels.
    pub(crate) evaluation: usize,
    /// Root mean square of the residuals, as weighted.
    pub(crate) rms: f64,
    pub(crate) parameters: [f64; N],
}

/// The steps that were taken on each level, the coarsest first.
pub(crate) fn taken<const N: usize>(levels: &[Solution<N>]) -> Vec<Vec<Taken<N>>> {
    let mut before = 0;
    let of = |level: &Solution<N>| {
        let first = before + 1;
        before += level.steps.len();
        let rms = |loss: f64| (2.0 * loss / level.equations.rays as f64).sqrt();
        let steps = level.steps.iter().enumerate().filter(|(_, step)| step.accepted);
        let taken = steps.map(|(n, step)| Taken {
            evaluation: first + n,
            rms: rms(step.loss),
            parameters: step.parameters,
        });
        taken.collect()
    };
    levels.iter().map(of).collect()
}

/// Degrees and mm: the first three of the parameters are radians.
pub(crate) fn in_degrees<const N: usize>(parameters: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| if k < 3 { parameters[k].to_degrees() } else { parameters[k] })
}

/// Why the method ended, as JSON has it.
pub(crate) fn stop_name(stop: Stop) -> &'static str {
    match stop {
        Stop::Gradient => "gradient",
        Stop::Step => "step",
        Stop::Reduction => "reduction",
        Stop::Stalled => "stalled",
        Stop::Iterations => "iterations",
        Stop::Cancelled => "cancelled",
    }
}
