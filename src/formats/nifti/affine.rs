//! Where a NIfTI header puts its voxels: index → world, mm, LPS.

use glam::{DAffine3, DMat3, DVec3};
use nifti::NiftiHeader;

use crate::formats::Checked;

/// How far b² + c² + d² of a unit quaternion may exceed 1 by rounding; 1e-5 is less than half a degree.
const QUATERNION_TOLERANCE: f64 = 1e-5;
/// A smaller w² is rounding noise of b, c, d in float32 and means a half turn, as in the standard's own C library.
const HALF_TURN: f64 = 1e-7;

/// The map of sform, else qform, else the spacing alone with voxel (0, 0, 0) at the origin.
///
/// NIfTI's world is RAS; the first two rows change their sign for LPS.
pub(super) fn index_to_world(header: &NiftiHeader) -> Checked<DAffine3> {
    let ras = if header.sform_code > 0 {
        sform(header)
    } else if header.qform_code > 0 {
        qform(header)?
    } else {
        DAffine3::from_scale(spacing(header))
    };
    let lps = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0) * millimetres(header)?);
    Ok(DAffine3 { matrix3: lps * ras.matrix3, translation: lps * ras.translation })
}

fn sform(header: &NiftiHeader) -> DAffine3 {
    let rows = [header.srow_x, header.srow_y, header.srow_z].map(|row| row.map(f64::from));
    let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
    DAffine3::from_cols(column(0), column(1), column(2), column(3))
}

/// The rotation is written out, and not built by a library, because w = 0 must stay harmless: a half turn is common.
fn qform(header: &NiftiHeader) -> Checked<DAffine3> {
    let mut bcd = DVec3::new(header.quatern_b.into(), header.quatern_c.into(), header.quatern_d.into());
    let square = 1.0 - bcd.length_squared();
    if square.is_nan() || square < -QUATERNION_TOLERANCE {
        return Err(format!("quatern_b, c, d are {bcd}; valid: b² + c² + d² at most 1"));
    }
    let a = if square < HALF_TURN { 0.0 } else { square.sqrt() };
    if a == 0.0 {
        bcd = bcd.normalize();
    }
    let [b, c, d] = bcd.to_array();
    let rotation = DMat3::from_cols(
        DVec3::new(a * a + b * b - c * c - d * d, 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)),
        DVec3::new(2.0 * (b * c - a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d + a * b)),
        DVec3::new(2.0 * (b * d + a * c), 2.0 * (c * d - a * b), a * a + d * d - b * b - c * c),
    );
    let qfac = if header.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    let scale = spacing(header) * DVec3::new(1.0, 1.0, qfac);
    Ok(DAffine3 {
        matrix3: rotation * DMat3::from_diagonal(scale),
        translation: DVec3::new(header.quatern_x.into(), header.quatern_y.into(), header.quatern_z.into()),
    })
}

/// Distance of voxel centres in the header's unit. Some writers leave signs in it; they mean nothing there.
fn spacing(header: &NiftiHeader) -> DVec3 {
    DVec3::new(header.pixdim[1].into(), header.pixdim[2].into(), header.pixdim[3].into()).abs()
}

/// The header's unit of length in mm; a header without a unit means mm.
fn millimetres(header: &NiftiHeader) -> Checked<f64> {
    match header.xyzt_units & 7 {
        0 | 2 => Ok(1.0),
        1 => Ok(1e3),
        3 => Ok(1e-3),
        code => Err(format!("unit of length in xyzt_units is {code}; valid: 0, 1 (m), 2 (mm), 3 (µm)")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: DAffine3, columns: [[f64; 3]; 4]) -> bool {
        let [x, y, z, t] = columns.map(DVec3::from_array);
        a.abs_diff_eq(DAffine3::from_cols(x, y, z, t), 1e-6)
    }

    fn header() -> NiftiHeader {
        NiftiHeader {
            pixdim: [1.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0],
            qform_code: 0,
            sform_code: 0,
            ..NiftiHeader::default()
        }
    }

    #[test]
    fn sform_comes_first_and_turns_from_ras_to_lps() {
        let header = NiftiHeader {
            sform_code: 1,
            qform_code: 1,
            srow_x: [-0.5, 0.0, 0.125, 166.0],
            srow_y: [0.0, 0.75, 0.0, -187.0],
            srow_z: [0.0, 0.0, 2.5, -340.0],
            ..header()
        };
        let map = index_to_world(&header).unwrap();
        let columns = [[0.5, 0.0, 0.0], [0.0, -0.75, 0.0], [-0.125, 0.0, 2.5], [-166.0, 187.0, -340.0]];
        assert!(close(map, columns), "{map:?}");
        assert!(map.matrix3.determinant() < 0.0);
    }

    #[test]
    fn qform_turns_and_qfac_mirrors() {
        // A quarter turn about x: j goes to +z, k to −y (RAS).
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let mut header = NiftiHeader { qform_code: 1, quatern_b: half, quatern_x: 7.0, ..header() };
        let map = index_to_world(&header).unwrap();
        assert!(
            close(map, [[-1.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 3.0, 0.0], [-7.0, 0.0, 0.0]]),
            "{map:?}"
        );
        header.pixdim[0] = -1.0;
        let map = index_to_world(&header).unwrap();
        assert!(
            close(map, [[-1.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, -3.0, 0.0], [-7.0, 0.0, 0.0]]),
            "{map:?}"
        );
        header.pixdim[0] = 0.0;
        assert!(close(
            index_to_world(&header).unwrap(),
            [[-1.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 3.0, 0.0], [-7.0, 0.0, 0.0]]
        ));
    }

    #[test]
    fn a_half_turn_with_rounding_is_normalised_and_nonsense_is_refused() {
        let mut header = NiftiHeader { qform_code: 1, ..header() };
        // Float32 rounding makes b² + c² exceed 1, so that w² is negative, or leaves a w² of 5e-8.
        for (b, c) in [(0.6_f32.next_up(), 0.8_f32.next_up()), (0.6, 0.8_f32.next_down())] {
            (header.quatern_b, header.quatern_c) = (b, c);
            let map = index_to_world(&header).unwrap();
            assert!((map.matrix3.determinant() - 6.0).abs() < 1e-9, "{map:?}");
            assert!((map.matrix3.z_axis - DVec3::new(0.0, 0.0, -3.0)).length() < 1e-9, "{map:?}");
        }
        for wrong in [2.0, f32::NAN, f32::INFINITY] {
            header.quatern_d = wrong;
            assert!(index_to_world(&header).unwrap_err().contains("quatern"));
        }
    }

    #[test]
    fn without_codes_the_spacing_counts_in_its_unit() {
        for (code, factor) in [(0, 1.0), (1, 1000.0), (2, 1.0), (3, 0.001), (2 | 8, 1.0)] {
            let map = index_to_world(&NiftiHeader { xyzt_units: code, ..header() }).unwrap();
            let scaled = DVec3::new(-1.0, -2.0, 3.0) * factor;
            assert!((map.matrix3 * DVec3::ONE - scaled).length() < 1e-9 * factor, "{code}: {map:?}");
            assert_eq!(map.translation, DVec3::ZERO);
        }
        assert!(
            index_to_world(&NiftiHeader { xyzt_units: 5, ..header() }).unwrap_err().contains("xyzt_units")
        );
    }
}
