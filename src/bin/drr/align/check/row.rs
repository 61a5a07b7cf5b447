//! One row of the table.

use drr::parallel::Quadrature;
use serde::Serialize;

pub(super) const HEADING: &str =
    "  integral   precision  what                           rays  relative error      bound";

/// The largest relative errors of all poses.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Worst {
    pub(super) image: f64,
    pub(super) loss: f64,
    pub(super) normal: f64,
    /// How far rays at a kink are beyond its sides.
    pub(super) kinks: Option<f64>,
    pub(super) rays: usize,
    pub(super) kinked: usize,
}

/// What was compared, and how far it is off.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Row {
    integral: &'static str,
    precision: &'static str,
    what: &'static str,
    rays: usize,
    relative_error: f64,
    bound: f64,
}

pub(super) fn name(quadrature: Quadrature) -> &'static str {
    match quadrature {
        Quadrature::Steps => "steps",
        Quadrature::Exact => "exact",
    }
}

impl Row {
    pub(super) fn of(
        worst: &Worst,
        integral: &'static str,
        precision: &'static str,
        bound: f64,
    ) -> impl Iterator<Item = Self> {
        let smooth = [
            ("image's derivatives", worst.image, worst.rays),
            ("loss's gradient", worst.loss, worst.rays),
            ("JᵀJ", worst.normal, worst.rays),
        ];
        let kinks = worst.kinks.map(|kinks| ("image's, between kinks' sides", kinks, worst.kinked));
        smooth.into_iter().chain(kinks).map(move |(what, relative_error, rays)| Self {
            integral,
            precision,
            what,
            rays,
            relative_error,
            bound,
        })
    }

    /// NaN has failed.
    pub(super) fn passed(&self) -> bool {
        self.relative_error <= self.bound
    }

    pub(super) fn line(&self) -> String {
        let Self { integral, precision, what, rays, relative_error, bound } = self;
        let failed = if self.passed() { "" } else { "  FAILED" };
        format!(
            "  {integral:<9}  {precision:<9}  {what:<29}  {rays:>5}  {:>14}  {:>9}{failed}",
            format!("{relative_error:.1e}"),
            format!("{bound:.0e}")
        )
    }
}
