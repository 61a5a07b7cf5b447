//! Other voxels for the same field: cut, padded, renumbered, denser.

use std::ops::Range;

use drr::Algorithm::{self, DistanceDriven, Exact, Joseph, March, Siddon};
use drr::engine::{Backend, Layers};
use drr::physics::Calibration;
use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;

use crate::case::{ANY, Case, calibration, cases};
use crate::scenes;
use crate::tolerance::{Tolerance, identical, sum};

/// Whose samples stay where they are when slices are counted from another voxel or from the other end.
const WHOLE_SLICES: &[Algorithm] =
    &[Joseph, March { step: 1.0 }, March { step: 0.5 }, March { step: 0.25 }, Siddon, Exact, DistanceDriven];

/// Of those, the ones that see only what is near the ray: a pixel may see more of a larger volume.
const NEAR_THE_RAY: &[Algorithm] = WHOLE_SLICES.split_last().expect("there are some").1;

/// Those that engines in float32 have.
const SINGLE: &[Algorithm] = &[
    Joseph,
    March { step: 1.0 },
    March { step: 0.5 },
    March { step: 0.37 },
    March { step: 2.7 },
    Siddon,
    DistanceDriven,
];

/// The voxels with indices in `range` along `axis`.
fn part(case: &Case, axis: usize, range: Range<usize>) -> Case {
    let mut dimensions = case.dimensions;
    dimensions[axis] = range.len();
    case.reindexed(dimensions, DAffine3::from_translation(range.start as f64 * DVec3::AXES[axis]))
}

/// `layers` voxels of vacuum below and above, along each axis.
fn padded(case: &Case, layers: [[usize; 2]; 3]) -> Case {
    let dimensions = [0, 1, 2].map(|axis| case.dimensions[axis] + layers[axis][0] + layers[axis][1]);
    let below = DVec3::from_array(layers.map(|[below, _]| below as f64));
    case.reindexed(dimensions, DAffine3::from_translation(-below))
}

proptest! {
    #![proptest_config(scenes(48))]

    #[test]
    fn two_parts_add_up_to_the_whole(case in cases(&[Siddon]), axis in 0..3_usize, at in 0.0..1.0) {
        let n = case.dimensions[axis];
        prop_assume!(n > 1);
        let cut = 1 + (at * (n - 1) as f64) as usize;
        for &engine in case.engines() {
            // Each part sees the ray end at the cut, in its own rounding.
            let parts = [part(&case, axis, 0..cut), part(&case, axis, cut..n)];
            let [below, above] = parts.each_ref().map(|part| Tolerance::of(part, engine));
            let [a, b] = parts.map(|part| part.project(engine));
            below.plus(&above).check(&sum(&a, &b), &case.project(engine))?;
        }
    }

    /// Beyond the outermost voxels is vacuum, but the outer half voxel has the edge's value: only a volume whose
    /// outermost voxels are vacuum is, interpolated, the same field when it grows.
    #[test]
    fn vacuum_around_a_volume_adds_nothing(
        case in cases(NEAR_THE_RAY),
        layers in prop::array::uniform3(prop::array::uniform2(0..4_usize)),
    ) {
        let case = if case.algorithm == Siddon { case } else { padded(&case, [[1; 2]; 3]) };
        let larger = padded(&case, layers);
        for &engine in case.engines() {
            Tolerance::of(&larger, engine).check(&larger.project(engine), &case.project(engine))?;
        }
    }

    #[test]
    fn axes_may_be_renumbered(
        case in cases(ANY),
        order in prop::sample::select(vec![[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]),
    ) {
        let [x, y, z] = order.map(|axis| DVec3::AXES[axis]);
        let to_old = DAffine3::from_mat3(DMat3::from_cols(x, y, z));
        let renumbered = case.reindexed(order.map(|axis| case.dimensions[axis]), to_old);
        for &engine in case.engines() {
            Tolerance::of(&case, engine).check(&renumbered.project(engine), &case.project(engine))?;
        }
    }

    #[test]
    fn indices_may_run_backwards(case in cases(WHOLE_SLICES), axis in 0..3_usize) {
        let flip = DVec3::ONE - 2.0 * DVec3::AXES[axis];
        let last = (case.dimensions[axis] as f64 - 1.0) * DVec3::AXES[axis];
        let to_old = DAffine3 { matrix3: DMat3::from_diagonal(flip), translation: last };
        let backwards = case.reindexed(case.dimensions, to_old);
        for &engine in case.engines() {
            Tolerance::of(&case, engine).check(&backwards.project(engine), &case.project(engine))?;
        }
    }

    /// Whole HU are the same in either kind of storage, also where float32 has to round their densities.
    #[test]
    fn storage_does_not_show(case in cases(SINGLE)) {
        let how = Calibration::named(Calibration::DEFAULT).expect("built in");
        let [int16, float32] = [true, false].map(|coded| {
            let volume = Case { coded, ..case.clone() }.volume(how.clone());
            case.project_volume(Backend::Cpu, volume, &[case.view()], Layers::ALL)
        });
        // Rays through integer HU may be swept, through others never.
        if case.algorithm == Joseph {
            Tolerance::of(&case, Backend::Cpu).check(&int16, &float32)?;
        } else {
            identical(&int16, &float32)?;
        }
    }

    #[test]
    fn areal_density_scales_with_density(case in cases(ANY), exponent in -3..=3) {
        let scale = f64::from(exponent).exp2();
        let denser = case.volume(calibration(scale));
        for &engine in case.engines() {
            let mut expected = case.project(engine);
            expected.areal_density.iter_mut().for_each(|a| *a *= scale);
            let mut got = case.project_volume(engine, denser.clone(), &[case.view()], Layers::ALL);
            // Not linear in the density.
            (got.intensity, got.line_integral) = (expected.intensity.clone(), expected.line_integral.clone());
            identical(&got, &expected)?;
        }
    }

    #[test]
    fn areal_densities_of_fields_add_up(case in cases(ANY), share in 0.0..1.0) {
        let split = |d: u16| (f64::from(d) * share) as u16;
        let one = Case { voxels: case.voxels.with(split), ..case.clone() };
        let other = Case { voxels: case.voxels.with(|d| d - split(d)), ..case.clone() };
        for &engine in case.engines() {
            let mut total = sum(&one.project(engine), &other.project(engine));
            total.bone_path.iter_mut().for_each(|mm| *mm /= 2.0);
            Tolerance::of(&case, engine).check(&total, &case.project(engine))?;
        }
    }
}
