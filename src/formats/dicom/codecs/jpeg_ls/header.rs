//! What stands before the scan, and what follows from it.

use crate::formats::Checked;

/// The parameters of a scan.
#[derive(Debug, Clone)]
pub(super) struct Header {
    /// Columns and rows.
    pub(super) size: [usize; 2],
    pub(super) precision: u16,
    pub(super) maxval: i32,
    pub(super) near: i32,
    /// T1, T2, T3.
    pub(super) thresholds: [i32; 3],
    pub(super) reset: i32,
}

impl Header {
    /// Reads the marker segments; the scan's bytes are what follows them (annex C).
    pub(super) fn parse(frame: &[u8]) -> Checked<(Self, &[u8])> {
        let mut rest = frame.strip_prefix(&[0xff, 0xd8]).ok_or("it starts with no image")?;
        let (mut image, mut preset) = (None, [0; 5]);
        loop {
            let [0xff, marker, high, low, ..] = *rest else {
                return Err("its header is truncated".to_owned());
            };
            let length = usize::from(u16::from_be_bytes([high, low]));
            let segment = rest.get(4..length + 2).ok_or("its header is truncated")?;
            rest = &rest[length + 2..];
            let word = |at: usize| i32::from(u16::from_be_bytes([segment[at], segment[at + 1]]));
            match (marker, segment) {
                (0xf7, &[precision @ 2..=16, _, _, _, _, 1, _, 0x11, _]) => {
                    image = Some((u16::from(precision), [word(3) as usize, word(1) as usize]));
                }
                (0xf7, _) => return Err("its frame is not one of one component, of 2 to 16 bits".to_owned()),
                (0xf8, &[1, ..]) if segment.len() == 11 => preset = [1, 3, 5, 7, 9].map(word),
                (0xf8, _) => return Err("it has a mapping table or sizes beyond 65535".to_owned()),
                (0xdd, restart) if restart.iter().any(|&byte| byte != 0) => {
                    return Err("it has restart intervals".to_owned());
                }
                (0xda, &[1, _, 0, near, 0, 0]) => {
                    let (precision, size) = image.ok_or("its scan comes before its frame")?;
                    return Ok((Self::new(precision, size, near.into(), preset)?, rest));
                }
                (0xda, _) => return Err("its scan is not one of one component".to_owned()),
                _ => {}
            }
        }
    }

    /// Parameters of 0 have their defaults (C.2.4.1.1).
    fn new(precision: u16, size: [usize; 2], near: i32, preset: [i32; 5]) -> Checked<Self> {
        let [maxval, t1, t2, t3, reset] = preset;
        let largest = (1 << precision) - 1;
        let maxval = if maxval == 0 { largest } else { maxval };
        if !(1..=largest).contains(&maxval) || near > (maxval / 2).min(255) {
            return Err(format!(
                "MAXVAL is {maxval} and NEAR {near}; valid: 1 … {largest}, and at most half of it"
            ));
        }
        let clamp = |value: i32, low: i32| if value > maxval || value < low { low } else { value };
        let basic = |at: i32, n: i32| {
            if maxval >= 128 {
                let factor = (maxval.min(4095) + 128) / 256;
                factor * (at - n) + n + (2 * n - 1) * near
            } else {
                let factor = 256 / (maxval + 1);
                n.max(at / factor + (2 * n - 1) * near)
            }
        };
        let or = |given: i32, default: i32| if given == 0 { default } else { given };
        let t1 = or(t1, clamp(basic(3, 2), near + 1));
        let t2 = or(t2, clamp(basic(7, 3), t1));
        let t3 = or(t3, clamp(basic(21, 4), t2));
        let reset = or(reset, 64);
        if !(near < t1 && t1 <= t2 && t2 <= t3 && t3 <= maxval && reset >= 3) {
            return Err(format!(
                "thresholds are {t1}, {t2}, {t3} and RESET {reset}; valid: NEAR < T1 ≤ T2 ≤ T3 ≤ MAXVAL, 3 ≤ RESET"
            ));
        }
        Ok(Self { size, precision, maxval, near, thresholds: [t1, t2, t3], reset })
    }

    /// The number of values of an error, quantised.
    pub(super) fn range(&self) -> i32 {
        (self.maxval + 2 * self.near) / (2 * self.near + 1) + 1
    }

    /// Bits of such an error.
    pub(super) fn qbpp(&self) -> u32 {
        bits(self.range() - 1)
    }

    /// The longest code of one.
    pub(super) fn limit(&self) -> u32 {
        let bpp = bits(self.maxval).max(2);
        2 * (bpp + bpp.max(8))
    }
}

/// Bits that hold a number.
fn bits(largest: i32) -> u32 {
    i32::BITS - largest.leading_zeros()
}
