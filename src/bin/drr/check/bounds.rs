//! How far off an answer may be.
//!
//! Along a ray with ∫|v| dl = S through a field of at most V, rounding to `u` costs a multiple of u·S in the sum, and V
//! times the error of position: u times the size of what positions are relative to. An engine in float64 sees world
//! coordinates, up to D; one in float32 sees only what is left of them inside the volume, whose half diagonal is X.

use drr::engine::{Backend, Layers};
use drr::geometry::{Grid, View};
use drr::physics::MAX_MATERIALS;
use glam::DVec3;

use super::case::Set;
use super::row::Deviation;
use super::truth::Values;

/// The bounds of one engine on one view.
pub(crate) struct Bounds {
    /// Allowed error of a sum, relative to it.
    relative: f64,
    /// Allowed displacement of a ray, mm.
    pub(crate) shift_mm: f64,
    /// Unit roundoff of the images.
    unit: f64,
    /// Allowed error of p, relative and absolute.
    line_integral: [f64; 2],
    /// Allowed error of the intensity beyond that of p.
    intensity: f64,
    /// Largest density by label, g/cm³.
    density: [f64; MAX_MATERIALS],
    /// Largest attenuation by label, cm²/g, where the bound of p grows with that of the areal densities.
    attenuation: [f64; MAX_MATERIALS],
}

impl Bounds {
    pub(crate) fn new(backend: Backend, set: &Set, view: usize) -> Self {
        if backend == Backend::Reference {
            Self::float64(set, view)
        } else {
            Self::float32(backend, set, view)
        }
    }

    fn float64(set: &Set, view: usize) -> Self {
        let unit = f64::EPSILON / 2.0;
        let materials = &set.scene.materials;
        let steepest = |m| materials.coefficients(m).iter().copied().fold(0.0, f64::max);
        Self {
            relative: 1e-13,
            shift_mm: 8.0 * unit * reach(set.volume.grid(), &set.views[view].view),
            unit,
            line_integral: [1e-13, 1e-14],
            intensity: 0.0,
            density: densities(set),
            attenuation: std::array::from_fn(|m| if m < materials.names().len() { steepest(m) } else { 0.0 }),
        }
    }

    fn float32(backend: Backend, set: &Set, view: usize) -> Self {
        let unit = f64::from(f32::EPSILON) / 2.0;
        let whole = set.layers.line_integral || set.layers.areal_density;
        let stops = set.views[view].early_exit && !whole;
        let stopped =
            if stops { (-15.0_f64).exp() * set.scene.detected(0).expect("valid").total() } else { 0.0 };
        // Below the smallest normal number float32 loses digits; GPUs may not have such numbers.
        let lost = if backend == Backend::Cpu { unit } else { 1.0 };
        Self {
            relative: 1e-6,
            shift_mm: 8.0 * unit * half_diagonal(set.volume.grid()),
            unit,
            line_integral: [2e-6, 1e-6],
            intensity: stopped + f64::from(f32::MIN_POSITIVE) * lost,
            density: densities(set),
            attenuation: [0.0; MAX_MATERIALS],
        }
    }

    /// How far `got` is outside `low` … `high`, in the layers that were asked for.
    pub(crate) fn deviation(&self, layers: Layers, got: &Values, [low, high]: [&Values; 2]) -> Deviation {
        let mut worst = Deviation::NONE;
        let mut see = |layer, wanted: bool, bound: f64, value: &dyn Fn(&Values) -> f64| {
            let [got, low, high] = [got, low, high].map(value);
            // NaN is not inside.
            let error =
                if (low..=high).contains(&got) { 0.0 } else { (low - got).abs().min((got - high).abs()) };
            if wanted {
                worst = worst.or_worse(Deviation { layer, error, bound });
            }
        };
        let mut of_p = self.line_integral[0] * high.line_integral + self.line_integral[1];
        for m in 0..MAX_MATERIALS {
            // mm to cm.
            let bound = self.relative * high.areal_density[m] + 0.1 * self.shift_mm * self.density[m];
            of_p += self.attenuation[m] * bound;
            see("areal density", layers.areal_density, bound, &|values| values.areal_density[m]);
        }
        let of_length = self.relative * high.bone_path + self.shift_mm;
        see("bone path", layers.bone_path, of_length, &|values| values.bone_path);
        see("line integral", layers.line_integral, of_p, &|values| values.line_integral);
        let relative = 4.0 * self.unit * (1.0 + high.line_integral) + of_p;
        let of_intensity = relative * high.intensity + self.intensity;
        see("intensity", layers.intensity, of_intensity, &|values| values.intensity);
        worst
    }
}

/// Largest density by label, g/cm³.
fn densities(set: &Set) -> [f64; MAX_MATERIALS] {
    set.volume.materials().map(|material| material.max_density)
}

/// Half the longest diagonal of the volume's box, mm.
fn half_diagonal(grid: &Grid) -> f64 {
    let n = DVec3::from_array(grid.dimensions().map(|n| n as f64));
    let diagonals =
        [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0), DVec3::new(1.0, 1.0, -1.0)];
    0.5 * diagonals.map(|signs| grid.length_mm(signs * n)).into_iter().fold(0.0, f64::max)
}

/// The largest coordinate of the volume, the source and the first pixel, mm.
fn reach(grid: &Grid, view: &View) -> f64 {
    let size = |point: DVec3| point.abs().max_element();
    let of_view = match view {
        View::Pose(pose) => size(pose.source).max(size(pose.first_pixel)),
        View::Projection(projection) if projection.is_parallel() => 0.0,
        View::Projection(projection) => size(projection.source),
    };
    of_view.max(size(grid.centre()) + half_diagonal(grid))
}
