//! World→clip projection matrices: what `ProjectionUniforms` carries.

use glam::{DMat3, DMat4, DVec3, DVec4};

use crate::error::{Error, Result};
use crate::geometry::{DetectorPose, check_coordinates};

/// Smallest independence of the rows that make the rays, relative to the product of their norms: below, the rounding of
/// float32 entries decides where rays go.
const MIN_RELATIVE_DETERMINANT: f64 = 1e-6;

/// A world→clip matrix and the source it belongs to. Clip space as in Metal: the centre of pixel (i, j) is at
/// `x = (2i+1)/width − 1`, `y = 1 − (2j+1)/height`, depth 0…1. Rays are *half-lines* from the source; for a parallel
/// beam (the matrix's last row has no x, y, z part) they are full lines and `source` is ignored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// World (mm) → clip.
    pub matrix: DMat4,
    /// The source, world mm.
    pub source: DVec3,
}

impl Projection {
    /// The projection that sends every pixel centre of the pose to that pixel.
    ///
    /// With `K = [column_step row_step first_pixel−source]`, K⁻¹(p − source) = λ(a, b, 1) for a point p seen by the
    /// (fractional) pixel (a, b); clip x, y follow from a, b, and w = λ is 0 at the source and 1 on the detector.
    pub fn from_pose(pose: &DetectorPose, [width, height]: [usize; 2]) -> Result<Self> {
        pose.validate()?;
        let inverse =
            DMat3::from_cols(pose.column_step, pose.row_step, pose.first_pixel - pose.source).inverse();
        let (w, h) = (width as f64, height as f64);
        let [a, b, lambda] = [inverse.row(0), inverse.row(1), inverse.row(2)];
        let near = 1e-3; // depth 0 at 1/1000 of the way to the detector, depth 1 on it
        let linear = [
            2.0 / w * a + (1.0 / w - 1.0) * lambda,
            -2.0 / h * b + (1.0 - 1.0 / h) * lambda,
            lambda / (1.0 - near),
            lambda,
        ];
        let row = |n: DVec3, constant: f64| n.extend(constant - n.dot(pose.source));
        let rows = [
            row(linear[0], 0.0),
            row(linear[1], 0.0),
            row(linear[2], -near / (1.0 - near)),
            row(linear[3], 0.0),
        ];
        let matrix = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
        Ok(Self { matrix, source: pose.source })
    }

    /// Checks that all numbers are finite and that the matrix describes rays. Whether source and matrix agree is
    /// checked where the volume is known, in `Beam::new`.
    pub fn validate(&self) -> Result<()> {
        if let Some(entry) = self.matrix.to_cols_array().iter().position(|x| !x.is_finite()) {
            let argument = format!("modelViewProjectionMatrix column {}, row {}", entry / 4, entry % 4);
            return Err(Error::invalid(argument, self.matrix.to_cols_array()[entry], "finite numbers"));
        }
        let [x, y, w] = self.rows();
        let (nx, ny, nw) = (x.truncate(), y.truncate(), w.truncate());
        let singular = |ratio: f64, rows: &str| {
            let valid =
                format!("independent {rows}: |det|/(product of row norms) ≥ {MIN_RELATIVE_DETERMINANT:e}");
            Error::invalid("modelViewProjectionMatrix", format!("singular (ratio {ratio:.3e})"), valid)
        };
        if self.is_parallel() {
            let ratio = nx.cross(ny).length() / (nx.length() * ny.length());
            // The negations also refuse NaN, which 0/0 gives for a row of zeros.
            if !(ratio >= MIN_RELATIVE_DETERMINANT) {
                return Err(singular(ratio, "x and y rows"));
            }
            if w.w == 0.0 {
                return Err(Error::invalid("modelViewProjectionMatrix column 3, row 3", 0.0, "not 0"));
            }
            return Ok(());
        }
        let ratio = nx.cross(ny).dot(nw).abs() / (nx.length() * ny.length() * nw.length());
        if !(ratio >= MIN_RELATIVE_DETERMINANT) {
            return Err(singular(ratio, "x, y and w rows"));
        }
        check_coordinates("sourcePosition", self.source)
    }

    /// Whether all rays have one direction.
    pub fn is_parallel(&self) -> bool {
        self.rows()[2].truncate() == DVec3::ZERO
    }

    /// The rows for clip x, y and w.
    pub(crate) fn rows(&self) -> [DVec4; 3] {
        [self.matrix.row(0), self.matrix.row(1), self.matrix.row(3)]
    }
}
