//! The heel effect: photons filtered by the anode in which they are born.

use glam::DVec3;

use crate::effects::{Sight, Sights};
use crate::error::{Error, Result};
use crate::physics::{EnergyGrid, MassAttenuation};

/// Self-filtration in a tungsten anode with a plane surface.
///
/// Electrons fly from the cathode to the anode parallel to the detector's plane. The anode's surface is at the target
/// angle α to the detector's normal: its own normal is cos α towards the cathode and sin α towards the detector.
/// Photons are born `depth_mm` behind the surface as the electrons fly, so depth · cos α below it, and leave along the
/// ray through depth · cos α / (ray · surface normal) of tungsten. In the plane of the cathode, at the angle φ from the
/// detector's normal and counted towards the cathode, that is depth · cos α / sin(α + φ); rays beside the plane are
/// longer, as their directions are. Nothing leaves below the surface (φ ≤ −α), the anode's horizon.
///
/// The tube's spectrum is that on the detector's normal (φ = 0): only the difference to `central_path_mm` is to be
/// filtered out of it, or put back.
///
/// One depth for all photons, as for the filtration in G. G. Poludniowski, Med. Phys. 34, 2175 (2007), whose photons
/// are born at many; the plane geometry follows from the above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heel {
    /// Angle α between the anode's surface and the detector's normal, degrees: above 0, at most 45.
    pub target_angle_degrees: f64,
    /// How far electrons get into the anode before they make photons, mm: above 0, at most 1.
    pub depth_mm: f64,
    /// Where the cathode is, in the detector's plane, degrees: 0 is the columns' direction (i grows), 90 is across it
    /// on the side to which j grows; −360 … 360.
    pub cathode_degrees: f64,
}

impl Heel {
    /// The anode angle of the built-in spectra, 12°, and a depth of 5 µm: a typical value, of the order of a third of the
    /// range of electrons of 100 keV in tungsten, and not that of a certain tube. The cathode is where i grows.
    pub const TYPICAL: Self = Self { target_angle_degrees: 12.0, depth_mm: 0.005, cathode_degrees: 0.0 };

    /// Checks the ranges.
    ///
    /// # Errors
    /// `InvalidArgument` for what is not finite or out of range.
    pub fn validate(&self) -> Result<()> {
        let invalid = |name: &str, value, valid| {
            Err(Error::invalid(format!("scene.effects.heel.{name}"), value, valid))
        };
        if !(self.target_angle_degrees > 0.0 && self.target_angle_degrees <= 45.0) {
            return invalid("target_angle_degrees", self.target_angle_degrees, "above 0, at most 45 degrees");
        }
        if !(self.depth_mm > 0.0 && self.depth_mm <= 1.0) {
            return invalid("depth_mm", self.depth_mm, "above 0, at most 1 mm");
        }
        if !(self.cathode_degrees.abs() <= 360.0) {
            return invalid("cathode_degrees", self.cathode_degrees, "−360 … 360 degrees");
        }
        Ok(())
    }

    /// Tungsten's coefficients at the spectrum's energies.
    ///
    /// # Errors
    /// `InvalidArgument` for energies that are not tabulated.
    pub(crate) fn anode(grid: EnergyGrid) -> Result<MassAttenuation> {
        MassAttenuation::named(&["tungsten"], grid).map_err(|error| error.of("scene.effects.heel"))
    }

    /// The tungsten that photons cross towards a pixel, mm; infinite at the horizon and below.
    pub(crate) fn path_mm(&self, sight: &Sight) -> f64 {
        self.path_at(self.surface_normal().dot(sight.direction()))
    }

    /// That along the detector's normal, for which the tube's spectrum holds.
    pub(crate) fn central_path_mm(&self) -> f64 {
        self.path_at(self.surface_normal().z)
    }

    /// The shortest path to any point of the `size` = width × height pixels, their edges included, mm: no pixel and no
    /// part of one has a shorter one, but for rounding. Infinite where all are below the horizon.
    ///
    /// The path falls as ray · surface normal grows, and the pixels for which that is above some value lie in a cone,
    /// whose section with the detector is convex. So it has no peak but where the ray *is* the surface normal; where the
    /// detector does not reach that far, the largest value is on its edges.
    pub(crate) fn least_path_mm(&self, sights: &Sights, [width, height]: [usize; 2]) -> f64 {
        let normal = self.surface_normal();
        let (right, bottom) = (width as f64 - 0.5, height as f64 - 0.5);
        let [column, row] = sights.pixel(normal);
        if (-0.5..=right).contains(&column) && (-0.5..=bottom).contains(&row) {
            return self.path_at(1.0);
        }
        let corners = [(-0.5, -0.5), (right, -0.5), (right, bottom), (-0.5, bottom)];
        let corners = corners.map(|(column, row)| sights.towards(column, row));
        let edges = (0..4).map(|k| best_cosine(normal, corners[k], corners[(k + 1) % 4]));
        self.path_at(edges.fold(f64::NEG_INFINITY, f64::max))
    }

    /// The path at a cosine between ray and surface normal.
    fn path_at(&self, cosine: f64) -> f64 {
        if cosine > 0.0 {
            self.depth_mm * self.target_angle_degrees.to_radians().cos() / cosine
        } else {
            f64::INFINITY
        }
    }

    /// Out of the anode, a unit vector in the detector's frame.
    fn surface_normal(&self) -> DVec3 {
        let (sin, cos) = self.target_angle_degrees.to_radians().sin_cos();
        let (across, along) = self.cathode_degrees.to_radians().sin_cos();
        DVec3::new(cos * along, cos * across, sin)
    }
}

/// The largest cosine between the unit vector `normal` and any direction `from + s (to − from)`, s in 0 … 1.
fn best_cosine(normal: DVec3, from: DVec3, to: DVec3) -> f64 {
    let step = to - from;
    // Where the derivative of n·d/|d| vanishes, (n·b)(d·d) = (n·d)(d·b) for d = a + s b, which is linear in s.
    let (n_a, n_b) = (normal.dot(from), normal.dot(step));
    let (a_a, a_b, b_b) = (from.length_squared(), from.dot(step), step.length_squared());
    let s = (n_a * a_b - n_b * a_a) / (n_b * a_b - n_a * b_b);
    // NaN for a parallel beam, whose directions are all the same: not in the range either.
    let turn = if (0.0..=1.0).contains(&s) { from + s * step } else { from };
    [from, to, turn].into_iter().map(|d| normal.dot(d.normalize())).fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::sight::tests::{SIZE, upright};
    use crate::geometry::{DetectorPose, View};

    fn towards(degrees_to_cathode: f64) -> Sight {
        let (column, normal) = degrees_to_cathode.to_radians().sin_cos();
        Sight { column, row: 0.0, normal }
    }

    #[test]
    fn the_path_in_the_plane_of_the_cathode() {
        let heel = Heel::TYPICAL;
        let cosine = 12.0_f64.to_radians().cos();
        for (phi, sine) in
            [(18.0, 0.5), (78.0, 1.0), (0.0, 12.0_f64.to_radians().sin()), (-9.0, 3.0_f64.to_radians().sin())]
        {
            let path = heel.path_mm(&towards(phi));
            assert!((path * sine / (0.005 * cosine) - 1.0).abs() < 1e-13, "{phi}°: {path} mm");
        }
        assert!((heel.central_path_mm() - 0.005 / 12.0_f64.to_radians().tan()).abs() < 1e-17);
        assert!(heel.path_mm(&towards(-11.999_999)).is_finite());
        assert_eq!(heel.path_mm(&towards(-12.000_001)), f64::INFINITY);
    }

    #[test]
    fn the_path_ends_where_the_ray_leaves_the_anode() {
        // Marched from the birth to the surface: the half-space (p · normal ≤ 0), the birth `depth` from the cathode.
        for cathode_degrees in [0.0, 90.0, -130.0] {
            let heel = Heel { target_angle_degrees: 7.0, depth_mm: 0.02, cathode_degrees };
            let (across, along) = cathode_degrees.to_radians().sin_cos();
            let cathode = DVec3::new(along, across, 0.0);
            let birth = -heel.depth_mm * cathode;
            for direction in
                [DVec3::new(0.1, 0.2, 1.0), DVec3::new(-0.02, 0.05, 1.0), DVec3::new(0.0, -0.1, 1.0)]
            {
                let sight = Sight::along(direction);
                let path = heel.path_mm(&sight);
                if path.is_finite() {
                    let out = birth + path * sight.direction();
                    // The surface passes through the origin, at 7° to the detector's normal towards the anode.
                    let (sin, cos) = 7.0_f64.to_radians().sin_cos();
                    assert!((out.dot(cathode) * cos + out.z * sin).abs() < 1e-16, "{out}");
                }
            }
        }
    }

    #[test]
    fn more_tungsten_towards_the_anode_and_beside_its_plane() {
        let heel = Heel::TYPICAL;
        let paths: Vec<_> = (-11..=40).map(|phi| heel.path_mm(&towards(f64::from(phi)))).collect();
        assert!(paths.windows(2).all(|pair| pair[1] < pair[0]));
        // Directions of the same two components towards cathode and detector: longer as they are.
        let beside = Sight::along(DVec3::new(0.1, 0.2, 1.0));
        let within = Sight::along(DVec3::new(0.1, 0.0, 1.0));
        let ratio = heel.path_mm(&beside) / heel.path_mm(&within);
        assert!((ratio - (1.05_f64 / 1.01).sqrt()).abs() < 1e-15, "{ratio}");
    }

    #[test]
    fn no_pixel_has_a_shorter_path_than_the_least_one() {
        // The last is so close that it holds the ray along the surface normal.
        let close = DetectorPose { source: DVec3::new(78.0, 90.0, 10.0), ..upright() };
        for (view, alpha) in [(upright(), 12.0), (upright(), 1.0), (close, 12.0), (close, 45.0)] {
            let sights = Sights::new(&View::Pose(view), SIZE);
            for cathode_degrees in [0.0, 35.0, 90.0, 180.0, -100.0] {
                let heel = Heel { target_angle_degrees: alpha, depth_mm: 0.005, cathode_degrees };
                let least = heel.least_path_mm(&sights, SIZE);
                let mut sampled = f64::INFINITY;
                for n in 0..=300 {
                    for m in 0..=240 {
                        let (i, j) = (f64::from(n) * 40.0 / 300.0 - 0.5, f64::from(m) * 30.0 / 240.0 - 0.5);
                        sampled = heel.path_mm(&sights.at(i, j)).min(sampled);
                    }
                }
                assert!(sampled >= least * (1.0 - 1e-14), "{alpha}°, {cathode_degrees}°: {sampled} {least}");
                assert!(sampled <= least * (1.0 + 1e-3), "{alpha}°, {cathode_degrees}°: {sampled} {least}");
            }
        }
    }

    #[test]
    fn a_beam_below_the_horizon_and_a_parallel_one() {
        let aside = DetectorPose { source: DVec3::new(-1000.0, 30.0, 1000.0), ..upright() };
        let sights = Sights::new(&View::Pose(aside), SIZE);
        let heel = Heel { cathode_degrees: 180.0, ..Heel::TYPICAL };
        assert_eq!(heel.least_path_mm(&sights, SIZE), f64::INFINITY);
        let matrix = glam::DMat4::IDENTITY;
        let parallel = View::Projection(crate::geometry::Projection { matrix, source: DVec3::NAN });
        let sights = Sights::new(&parallel, SIZE);
        assert_eq!(heel.least_path_mm(&sights, SIZE), heel.central_path_mm());
        assert_eq!(heel.path_mm(&sights.at(39.0, 0.0)), heel.central_path_mm());
    }

    #[test]
    fn refusals_name_the_field() {
        let with = |target_angle_degrees, depth_mm, cathode_degrees| Heel {
            target_angle_degrees,
            depth_mm,
            cathode_degrees,
        };
        for (heel, field) in [
            (with(0.0, 0.005, 0.0), "target_angle_degrees is 0;"),
            (with(45.1, 0.005, 0.0), "target_angle_degrees is 45.1;"),
            (with(f64::NAN, 0.005, 0.0), "target_angle_degrees is NaN;"),
            (with(12.0, 0.0, 0.0), "depth_mm is 0;"),
            (with(12.0, 1.1, 0.0), "depth_mm is 1.1;"),
            (with(12.0, f64::NAN, 0.0), "depth_mm is NaN;"),
            (with(12.0, 0.005, 361.0), "cathode_degrees is 361;"),
            (with(12.0, 0.005, f64::NAN), "cathode_degrees is NaN;"),
        ] {
            let message = heel.validate().unwrap_err().to_string();
            assert!(message.starts_with(&format!("scene.effects.heel.{field}")), "{message}");
        }
        assert_eq!(Heel::TYPICAL.validate(), Ok(()));
        assert_eq!(with(45.0, 1.0, -360.0).validate(), Ok(()));
    }
}
