//! What error to expect: some rays of the very scene, cast again in float64.

use anyhow::Result;
use drr::engine::{Layers, SILENT};
use drr::geometry::DetectorPose;
use drr::{Algorithm, Projector};

use crate::inputs::Setup;
use crate::views::Views;

/// Rays that are cast again, over all views.
const RAYS: f64 = 3000.0;
/// Most views that are looked at.
const VIEWS: usize = 4;
/// Rays below this part of the largest line integral are left out of relative errors.
const FLOOR: f64 = 0.05;

/// Differences of line integrals in HU-equivalents, 1000 (p − `p_ref`)/`p_ref`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Difference {
    pub(crate) rmse: f64,
    pub(crate) max: f64,
    pub(crate) rays: usize,
}

impl Difference {
    /// Over the pairs (p, `p_ref`) with `p_ref` above the floor; `None` when there are none.
    pub(crate) fn of(pairs: impl Iterator<Item = (f64, f64)>, floor: f64) -> Option<Self> {
        let (mut squares, mut max, mut rays) = (0.0, 0.0_f64, 0);
        for (p, reference) in pairs.filter(|(_, reference)| *reference > floor) {
            let hu = 1000.0 * (p - reference) / reference;
            squares += hu * hu;
            max = max.max(hu.abs());
            rays += 1;
        }
        (rays > 0).then(|| Self { rmse: (squares / rays as f64).sqrt(), max, rays })
    }
}

/// The error of a projector, measured.
pub(crate) struct Accuracy {
    algorithm: Algorithm,
    rays: usize,
    floor: f64,
    /// Against the same algorithm in float64: what rounding costs.
    rounding: Option<Difference>,
    /// Against the exact integral of the interpolated field: what the algorithm costs as well.
    total: Option<Difference>,
}

impl Accuracy {
    /// Casts an even grid of pixels of the same detector, one ray each.
    pub(crate) fn measure(setup: &Setup<'_>, projector: &Projector, views: &Views) -> Result<Self> {
        let sample = sample(views);
        let mut scene = projector.scene().clone();
        (scene.detector, scene.supersampling) = (sample.size, 1);
        let algorithm = scene.method.algorithm;
        let projector = Projector::new(&setup.context, projector.volume().clone(), scene)?;
        let layers = Layers { line_integral: true, ..Layers::default() };
        let requests = sample.requests();
        let ours = projector.project(&requests, layers, SILENT)?.line_integral;
        let compare = |reference: &[f64]| {
            let floor = FLOOR * reference.iter().copied().filter(|p| p.is_finite()).fold(0.0, f64::max);
            let pairs = ours.iter().map(|&p| f64::from(p)).zip(reference.iter().copied());
            (Difference::of(pairs.filter(|(_, reference)| reference.is_finite()), floor), floor)
        };
        let twin = projector.reference(algorithm, &requests, layers, SILENT)?;
        let exact = projector.reference(Algorithm::Exact, &requests, layers, SILENT)?;
        let (rounding, _) = compare(&twin.line_integral);
        let (total, floor) = compare(&exact.line_integral);
        Ok(Self { algorithm, rays: ours.len(), floor, rounding, total })
    }
}

/// Every nth pixel of every mth row of some views.
fn sample(views: &Views) -> Views {
    let every = views.poses.len().div_ceil(VIEWS);
    let poses: Vec<_> = views.poses.iter().step_by(every).collect();
    let [width, height] = views.size;
    let stride = ((width * height * poses.len()) as f64 / RAYS).sqrt().ceil().max(1.0) as usize;
    let size = views.size.map(|n| n.div_ceil(stride));
    // The last pixel of the sample may not lie beyond the detector.
    let first = |n: usize, count: usize| ((n - 1 - (count - 1) * stride) / 2) as f64;
    let coarse = |pose: &&DetectorPose| DetectorPose {
        first_pixel: pose.pixel(first(width, size[0]), first(height, size[1])),
        column_step: stride as f64 * pose.column_step,
        row_step: stride as f64 * pose.row_step,
        ..**pose
    };
    Views { size, poses: poses.iter().map(coarse).collect() }
}

impl std::fmt::Display for Accuracy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(
            f,
            "error   of the line integral p, measured on {} rays of this scene in float64;",
            self.rays
        )?;
        writeln!(
            f,
            "        HU-equivalent = 1000 (p - p_ref)/p_ref over rays with p_ref > {:.3}:",
            self.floor
        )?;
        let rows = [
            (format!("rounding, against {} in float64", self.algorithm), self.rounding),
            ("in all, against the exact integral of the interpolated voxels".into(), self.total),
        ];
        for (i, (what, difference)) in rows.into_iter().enumerate() {
            let numbers = difference.map_or("no ray above the floor".into(), |d| {
                format!("RMSE {} HU, max {} HU", short(d.rmse), short(d.max))
            });
            write!(f, "{}        {what:<62} {numbers}", if i == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

/// Three digits, with an exponent where zeros would hide them.
fn short(value: f64) -> String {
    if value < 0.01 { format!("{value:.2e}") } else { format!("{value:.3}") }
}
