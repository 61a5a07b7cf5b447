//! A thorax of about a thousand ellipsoids: a default input that looks like a patient.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{Part, Phantom, Sampling, Shape};

/// Seed of the vessels and of the noise.
pub(super) const SEED: u32 = 20_260_706;

impl Phantom {
    /// Body, lungs, heart, aorta, liver, spine, ribs, sternum and 240 vessels, all axis-aligned ellipsoids. The body
    /// is longer than the default grid: compare line integrals with those of a volume only after the segment has been
    /// cut to the volume's box (`Shape::Cuboid` and `interval` do that). Voxels take the value at their centre.
    pub fn thorax() -> Self {
        let parts = ellipsoids().map(|([x, y, z, a, b, c], hu)| Part {
            shape: Shape::Ellipsoid { centre: DVec3::new(x, y, z), semi_axes: DVec3::new(a, b, c) },
            hu,
            material: material(hu),
        });
        Self::of_valid_parts("thorax", parts.collect()).with_sampling(Sampling::Centre)
    }
}

/// The four-material model's class of a CT number.
fn material(hu: i16) -> u8 {
    match hu {
        ..-950 => 0,
        -950..-200 => 1,
        -200..200 => 2,
        200.. => 3,
    }
}

/// Centre and semi-axes (mm) and HU, in painter's order; the first one is the body.
fn ellipsoids() -> impl Iterator<Item = ([f64; 6], i16)> {
    let organs = [
        ([0.0, 0.0, 0.0, 165.0, 110.0, 400.0], -90),    // body: fat
        ([0.0, 0.0, 0.0, 150.0, 97.0, 400.0], 45),      // muscle
        ([75.0, -2.0, 15.0, 55.0, 72.0, 135.0], -830),  // lungs
        ([-75.0, -2.0, 15.0, 55.0, 72.0, 135.0], -830), //
        ([25.0, -28.0, -25.0, 50.0, 42.0, 62.0], 48),   // heart
        ([12.0, 42.0, 0.0, 12.0, 12.0, 300.0], 50),     // aorta
        ([-55.0, 0.0, -150.0, 92.0, 80.0, 55.0], 60),   // liver
        ([0.0, 76.0, 0.0, 20.0, 17.0, 400.0], 320),     // spine
        ([0.0, 88.0, 0.0, 8.0, 6.0, 400.0], 15),        // spinal canal
    ];
    let sternum = ([0.0, -92.0, 20.0, 18.0, 5.0, 90.0], 380);
    organs.into_iter().chain(ribs()).chain([sternum]).chain(vessels())
}

/// Eleven ribs of up to 72 beads each, on tilted ellipses; the lower ones are open at the front.
fn ribs() -> impl Iterator<Item = ([f64; 6], i16)> {
    (0..11 * 72).filter_map(|n| {
        let (rib, bead) = (f64::from(n / 72), f64::from(n % 72));
        let angle = TAU * bead / 72.0;
        let (x, y) = (141.0 * angle.cos(), 90.0 * angle.sin());
        let open = y < -80.0 && rib > 6.0;
        (!open).then_some(([x, y, 135.0 - 27.0 * rib + 0.25 * y, 6.5, 4.0, 6.0], 620))
    })
}

/// Vessels and nodules in the lungs.
fn vessels() -> impl Iterator<Item = ([f64; 6], i16)> {
    let mut random = SplitMix64(u64::from(SEED));
    (0..240).map(move |_| {
        let side = if random.uniform(0.0, 1.0) < 0.5 { 75.0 } else { -75.0 };
        let x = side + random.uniform(-40.0, 40.0);
        let y = random.uniform(-52.0, 48.0);
        let z = 15.0 + random.uniform(-105.0, 105.0);
        let r = random.uniform(1.5, 6.0);
        ([x, y, z, r, r * random.uniform(0.7, 1.0), r * random.uniform(1.0, 3.0)], 35)
    })
}

/// Steele, Lea and Flood's generator (OOPSLA 2014).
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// From the top 53 bits, which a float64 holds exactly.
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.next() >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// Noise in HU, −15 … 16, of the voxel with a linear index (modulo 2³²).
pub(super) fn noise(voxel: u32) -> i16 {
    let h = voxel.wrapping_mul(2_654_435_761).wrapping_add(SEED);
    let h = (h ^ (h >> 16)).wrapping_mul(0x85EB_CA6B);
    ((h ^ (h >> 13)) & 31) as i16 - 15
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generator_gives_its_published_sequence() {
        let mut random = SplitMix64(1_234_567);
        let expected = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!([(); 3].map(|()| random.next()), expected);
    }

    #[test]
    fn noise_is_uniform() {
        let mut counts = [0_i32; 32];
        for voxel in 0..32_000 {
            counts[(noise(voxel) + 15) as usize] += 1;
        }
        // Standard deviation of a count is 31; an empty or doubled class is 30 of them away.
        assert!(counts.iter().all(|count| (count - 1000).abs() < 200), "{counts:?}");
    }

    #[test]
    fn sagittal_ray_meets_body_spine_and_canal_by_their_axes() {
        // Between two rings of beads; bodies of 400 mm half length shrink by a common factor at z = 9.
        let (from, to) = (DVec3::new(0.0, -500.0, 9.0), DVec3::new(0.0, 500.0, 9.0));
        let lengths = Phantom::thorax().lengths(from, to);
        let shrink = (1.0 - (9.0_f64 / 400.0).powi(2)).sqrt();
        let body: f64 = lengths.iter().sum();
        assert!((body - 220.0 * shrink).abs() < 1e-12, "the whole body: {body}");
        assert!((lengths[8] - 12.0 * shrink).abs() < 1e-12, "the canal's axis: {}", lengths[8]);
        // From the spine's front at 76 − 17 to the canal's at 88 − 6.
        assert!((lengths[7] - (12.0 + 11.0 * shrink)).abs() < 1e-12, "spine less canal: {}", lengths[7]);
    }

    #[test]
    fn lower_ribs_are_open_at_the_front() {
        let beads = ribs().filter(|([_, y, ..], _)| *y < -80.0).count();
        let all = ribs().count();
        assert_eq!(all, 11 * 72 - beads / 7 * 4, "seven closed ribs, four open ones");
        assert!(beads > 0 && beads % 7 == 0);
    }
}
