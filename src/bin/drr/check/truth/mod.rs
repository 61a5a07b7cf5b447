//! What a ray should come to: line integrals in exact rational arithmetic, the spectrum summed in float64.

mod field;
mod line;

use drr::physics::MAX_MATERIALS;
use drr::volume::Volume;
use drr::{Algorithm, Scene};

use field::Field;
pub(crate) use line::Line;

/// The value of every layer along one ray.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Values {
    /// g/cm² by label.
    pub(crate) areal_density: [f64; MAX_MATERIALS],
    /// mm.
    pub(crate) bone_path: f64,
    pub(crate) line_integral: f64,
    pub(crate) intensity: f64,
}

impl Values {
    /// One of many by each layer.
    pub(crate) fn each(many: &[Self], pick: fn(f64, f64) -> f64) -> Self {
        let of = |value: &dyn Fn(&Self) -> f64| many.iter().map(value).reduce(pick).unwrap_or(f64::NAN);
        Self {
            areal_density: std::array::from_fn(|m| of(&|values| values.areal_density[m])),
            bone_path: of(&|values| values.bone_path),
            line_integral: of(&|values| values.line_integral),
            intensity: of(&|values| values.intensity),
        }
    }
}

/// The fields of one volume and the spectrum of one scene.
pub(crate) struct Truth {
    densities: Vec<Option<Field>>,
    bone: Option<Field>,
    weights: Vec<f64>,
    /// Mass attenuation by label, then energy, cm²/g.
    coefficients: Vec<Vec<f64>>,
}

impl Truth {
    pub(crate) fn new(volume: &Volume, scene: &Scene) -> Self {
        let present = |label: usize| volume.materials()[label].labelled;
        let density = |label: usize| {
            let of_label = move |voxel: drr::volume::Voxel| {
                if usize::from(voxel.label) == label { voxel.density } else { 0.0 }
            };
            present(label).then(|| Field::of(volume, of_label))
        };
        let materials = scene.materials.names().len();
        let bone = scene.bone.filter(|&bone| present(usize::from(bone)));
        Self {
            densities: (0..MAX_MATERIALS).map(density).collect(),
            bone: bone.map(|bone| Field::of(volume, |voxel| f64::from(u8::from(voxel.label == bone)))),
            weights: scene.detected(0).expect("a valid scene").weights().to_vec(),
            coefficients: (0..materials).map(|m| scene.materials.coefficients(m).to_vec()).collect(),
        }
    }

    /// The values along a line. More than one where rounding decides the driving axis.
    pub(crate) fn values(&self, line: &Line, algorithm: Algorithm) -> Vec<Values> {
        let bone_path = self.bone.as_ref().map_or(0.0, |field| field.integrals(line, Algorithm::Siddon)[0]);
        let integrals: Vec<_> = self
            .densities
            .iter()
            .map(|field| field.as_ref().map_or_else(Vec::new, |field| field.integrals(line, algorithm)))
            .collect();
        let choices = integrals.iter().map(Vec::len).max().unwrap_or(0).max(1);
        (0..choices)
            .map(|choice| {
                // mm to cm.
                let areal_density =
                    std::array::from_fn(|m| integrals[m].get(choice).map_or(0.0, |mm| 0.1 * mm));
                let (line_integral, intensity) = self.signal(&areal_density);
                Values { areal_density, bone_path, line_integral, intensity }
            })
            .collect()
    }

    /// p = −ln(I/I0) and I = Σ N exp(−τ), relative to the least attenuated energy so that p stays finite.
    fn signal(&self, areal_density: &[f64]) -> (f64, f64) {
        let depth = |k: usize| self.coefficients.iter().zip(areal_density).map(|(mu, a)| mu[k] * a).sum();
        // An energy without photons says nothing about what passes.
        let lit = (0..self.weights.len()).filter(|&k| self.weights[k] > 0.0);
        let bins: Vec<(f64, f64)> = lit.map(|k| (self.weights[k], depth(k))).collect();
        let least = bins.iter().map(|(_, tau)| *tau).fold(f64::INFINITY, f64::min);
        let seen = sum(bins.iter().map(|(n, tau)| n * (least - tau).exp()));
        let all = sum(self.weights.iter().copied());
        (least - (seen / all).ln(), seen * (-least).exp())
    }
}

/// With the rounding of every addition made good (Neumaier, ZAMM 54, 39, 1974).
fn sum(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0);
    for value in values {
        let next = sum + value;
        lost += if sum.abs() >= value.abs() { (sum - next) + value } else { (value - next) + sum };
        sum = next;
    }
    sum + lost
}

#[cfg(test)]
mod tests {
    use drr::geometry::View;
    use glam::DVec3;
    use num_traits::ToPrimitive;

    use super::*;
    use crate::check::case::segment;
    use crate::check::volumes::{unit_grid, volume};

    const ALL: [Algorithm; 4] =
        [Algorithm::Joseph, Algorithm::March { step: 0.25 }, Algorithm::Siddon, Algorithm::Exact];

    /// g/cm² of soft tissue in voxels of 1 mm, and mm of bone, from `from` to `to`.
    fn through(n: [usize; 3], density: fn([usize; 3]) -> (i16, u8), from: DVec3, to: DVec3) -> Vec<[f64; 2]> {
        let volume = volume(unit_grid(n), density);
        let truth = Truth::new(&volume, &Scene::new([1, 1]).expect("valid"));
        let line = Line::of(&View::Pose(segment(from, to)), volume.grid(), [1, 1], [0, 0]);
        let each = ALL.map(|algorithm| truth.values(&line, algorithm).remove(0));
        each.map(|values| [values.areal_density[2], values.bone_path]).to_vec()
    }

    #[test]
    fn a_diagonal_through_water_is_its_length() {
        let ends = [DVec3::splat(-4.0), DVec3::splat(9.0)];
        for [water, _] in through([3, 3, 3], |_| (0, 2), ends[0], ends[1]) {
            assert!((water - 0.3 * 3.0_f64.sqrt()).abs() < 1e-15, "{water}");
        }
    }

    /// Densities 0, ½, 1 along x, the middle one bone, up to the middle of the ramp's upper half.
    #[test]
    fn every_rule_on_a_ramp() {
        let (from, to) = (DVec3::new(-5.0, 0.25, 0.25), DVec3::new(1.5, 0.25, 0.25));
        let ramp = |[i, _, _]: [usize; 3]| (-1000 + 500 * i as i16, 2);
        let areal =
            through([3, 2, 2], ramp, from, to).into_iter().map(|[areal, _]| areal).collect::<Vec<_>>();
        // Slices and voxels give 1 mm of ½; the ramp itself is (3/2)²/4, also for midpoints.
        assert_eq!(areal, [0.05, 0.05625, 0.05, 0.05625]);
        let bone = |[i, _, _]: [usize; 3]| (0, if i == 1 { 3 } else { 2 });
        assert!(through([3, 2, 2], bone, from, to).iter().all(|&[_, mm]| mm == 1.0));
    }

    #[test]
    fn boxes_are_half_open() {
        let water =
            |y: f64| through([3, 3, 3], |_| (0, 2), DVec3::new(-5.0, y, 1.0), DVec3::new(5.0, y, 1.0));
        for (y, areal) in [(-0.5, 0.3), ((-0.5_f64).next_down(), 0.0), (2.5_f64.next_down(), 0.3), (2.5, 0.0)]
        {
            assert!(water(y).iter().all(|&[through, _]| (through - areal).abs() < 1e-16), "y = {y}");
        }
    }

    #[test]
    fn a_ray_through_a_matrix_starts_at_its_source() {
        let pose = segment(DVec3::new(1.0, 1.1, 1.2), DVec3::new(9.0, 2.1, 3.2));
        let projection = drr::geometry::Projection::from_pose(&pose, [1, 1]).expect("valid");
        let grid = unit_grid([3, 3, 3]);
        let [segment, half_line] = [View::Pose(pose), View::Projection(projection)]
            .map(|view| Line::of(&view, &grid, [1, 1], [0, 0]))
            .map(|line| line.span([3; 3]).map(|span| span.map(|t| line.at(&t).map(|x| x.to_f64()))));
        for (a, b) in segment.into_iter().flatten().flatten().zip(half_line.into_iter().flatten().flatten()) {
            assert!((a.expect("finite") - b.expect("finite")).abs() < 1e-12, "{a:?} {b:?}");
        }
    }
}
