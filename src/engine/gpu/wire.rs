//! What the host tells the kernel: `shaders/wire.h`, byte for byte.

use glam::{DMat3, DVec3};

use crate::engine::{MAX_BEFORE, MAX_SIGNALS};
use crate::raycast::Even;

/// A number as an unevaluated sum of two float32: 48 bits.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Twofold {
    high: f32,
    low: f32,
}

impl From<f64> for Twofold {
    fn from(x: f64) -> Self {
        let high = x as f32;
        Self { high, low: (x - f64::from(high)) as f32 }
    }
}

impl Twofold {
    /// a − b, exact before it is rounded to 48 bits.
    pub(super) fn difference(a: f64, b: f64) -> Self {
        let sum = a - b;
        let of_b = a - sum;
        let lost = (a - (sum + of_b)) + (of_b - b);
        let high = sum as f32;
        Self { high, low: ((sum - f64::from(high)) + lost) as f32 }
    }
}

/// A number that changes evenly from pixel to pixel: `offset + column·i + row·j`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Affine {
    offset: Twofold,
    column: Twofold,
    row: Twofold,
}

impl Affine {
    /// `offset + column·i + row·j`.
    pub(crate) fn new(offset: f64, column: f64, row: f64) -> Self {
        Self { offset: offset.into(), column: column.into(), row: row.into() }
    }

    /// The three components of a vector that changes evenly, relative to `origin`.
    pub(super) fn relative(vector: &Even, origin: DVec3) -> [Self; 3] {
        [0, 1, 2].map(|axis| Self {
            offset: Twofold::difference(vector.constant[axis], origin[axis]),
            column: vector.column[axis].into(),
            row: vector.row[axis].into(),
        })
    }

    /// The three components of a vector that changes evenly.
    pub(super) fn of(vector: &Even) -> [Self; 3] {
        Self::relative(vector, DVec3::ZERO)
    }
}

/// `anchor` is a point of the ray.
pub(super) const ANCHOR_POINT: u32 = 0;
/// `anchor` is point × direction, the same for all points of the ray.
pub(super) const ANCHOR_MOMENT: u32 = 1;
/// The ray starts at the source.
pub(super) const ENDS_AT_SOURCE: u32 = 1;
/// The ray ends at the pixel.
pub(super) const ENDS_AT_PIXEL: u32 = 2;

/// Where a sum over energies finds its tables.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Table {
    pub(super) bins: u32,
    pub(super) first_weight: u32,
    pub(super) first_attenuation: u32,
    pub(super) weight_sum: Twofold,
}

/// All rays of one view, in voxel-index space, relative to the centre of the volume.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Beam {
    pub(super) direction: [Affine; 3],
    pub(super) anchor: [Affine; 3],
    pub(super) pixel: [Affine; 3],
    pub(super) source: [Twofold; 3],
    pub(super) anchor_kind: u32,
    pub(super) ends: u32,
    pub(super) early_exit: u32,
    pub(super) i0: f32,
    pub(super) least_attenuation: [f32; 8],
    pub(super) all: Table,
    pub(super) few: Table,
    pub(super) few_up_to: [f32; 8],
}

/// Where the sums by several rows of weights find their tables.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Channels {
    pub(super) bins: u32,
    pub(super) first_weight: u32,
    pub(super) first_attenuation: u32,
    pub(super) weight_sum: [Twofold; MAX_SIGNALS],
    pub(super) least_attenuation: [f32; 8 + MAX_BEFORE],
}

/// How the codes of voxels with one label stand in for their densities, g/cm³: with t = 2⁻²³ code + origin,
/// density = scale · (t − kink · |t|) + offset.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct StandIn {
    pub(super) origin: f32,
    pub(super) kink: f32,
    pub(super) scale: f32,
    pub(super) offset: f32,
}

/// The volume, the detector and the method.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Launch {
    pub(super) dimensions: [u32; 3],
    pub(super) bricks: [u32; 3],
    pub(super) stride: [u32; 3],
    pub(super) first_voxel: u32,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) views: u32,
    pub(super) millimetres: [[Twofold; 3]; 3],
    pub(super) step: Twofold,
    pub(super) stand_in: [StandIn; 8],
    pub(super) scale: f32,
    pub(super) kink: [f32; 2],
}

const _: () = {
    assert!(size_of::<Twofold>() == 8 && size_of::<Affine>() == 24 && size_of::<Table>() == 20);
    assert!(size_of::<Beam>() == 360 && align_of::<Beam>() == 4);
    assert!(size_of::<Channels>() == 140 && align_of::<Channels>() == 4);
    assert!(size_of::<Launch>() == 272 && align_of::<Launch>() == 4);
};

/// The columns of a matrix.
pub(super) fn columns(matrix: DMat3) -> [[Twofold; 3]; 3] {
    matrix.to_cols_array_2d().map(|column| column.map(Twofold::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of which every number here is a multiple.
    const UNIT: f64 = 1.0 / (1 << 20) as f64;

    fn in_units(x: f64) -> i128 {
        let units = x / UNIT;
        assert_eq!(units, units.trunc(), "{x:e} is not a multiple");
        units as i128
    }

    #[test]
    fn a_difference_is_exact_before_it_is_rounded() {
        let mut state = 1_u64;
        let mut random = |scale: u32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // All 53 bits.
            (state.cast_signed() >> 11) as f64 * UNIT * f64::from(scale).exp2()
        };
        for n in 0..10_000 {
            // With more bits together than float64 has.
            let (a, b) = (random(n % 40), random(n / 40 % 40));
            let Twofold { high, low } = Twofold::difference(a, b);
            let rest = in_units(a) - in_units(b) - in_units(f64::from(high));
            let off = (rest - in_units(f64::from(low))) as f64;
            assert!(off.abs() <= 0.5001 * f64::from(f32::EPSILON) * (rest as f64).abs(), "{a:e} - {b:e}");
        }
    }

    #[test]
    fn nothing_is_lost_that_48_bits_can_hold() {
        // 1 + 2⁻⁶⁰: float64 alone would lose the second part.
        let tiny = (-60.0_f64).exp2();
        assert_eq!(Twofold::difference(1.0, -tiny), Twofold { high: 1.0, low: tiny as f32 });
        for x in [0.0, -0.1, 1.0 / 3.0, 1e9 / 7.0, -1e-30] {
            let Twofold { high, low } = Twofold::from(x);
            let error = (f64::from(high) + f64::from(low) - x).abs();
            assert!(error <= (-48.0_f64).exp2() * x.abs(), "{x:e}: {error:e}");
        }
    }
}
