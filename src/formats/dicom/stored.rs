//! What the bits of a pixel mean.

use dicom_dictionary_std::tags;

use super::attributes::{Attributes, name};
use crate::formats::Checked;

/// The image pixel module's description of a pixel (part 3, C.7.6.3; part 5, section 8.1.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stored {
    /// Bits that a pixel takes: 8, 16 or 32.
    pub(super) allocated: u16,
    /// Bits that mean something; the others may hold anything.
    pub(super) bits: u16,
    /// Bits below those.
    shift: u16,
    signed: bool,
}

impl Stored {
    pub(super) fn from_attributes(attributes: &Attributes) -> Checked<Self> {
        let allocated = attributes.required_word(tags::BITS_ALLOCATED)?;
        let bits = attributes.required_word(tags::BITS_STORED)?;
        let high = attributes.required_word(tags::HIGH_BIT)?;
        let representation = attributes.required_word(tags::PIXEL_REPRESENTATION)?;
        let wrong = |tag, value, valid: String| Err(format!("{} is {value}; valid: {valid}", name(tag)));
        if ![8, 16, 32].contains(&allocated) {
            return wrong(tags::BITS_ALLOCATED, allocated, "8, 16, 32".to_owned());
        }
        if !(1..=allocated).contains(&bits) {
            return wrong(tags::BITS_STORED, bits, format!("1 … {allocated}"));
        }
        if !(bits - 1..allocated).contains(&high) {
            return wrong(tags::HIGH_BIT, high, format!("{} … {}", bits - 1, allocated - 1));
        }
        if representation > 1 {
            return wrong(tags::PIXEL_REPRESENTATION, representation, "0 (unsigned), 1 (signed)".to_owned());
        }
        Ok(Self { allocated, bits, shift: high + 1 - bits, signed: representation == 1 })
    }

    /// The same for words of so many bits that a decoder delivers: nothing is below the bits that mean something. Whether
    /// they are signed is for the attribute to say, not for the code stream: encoders that were given the bits of signed
    /// pixels as unsigned ones are common, and the bits are right.
    pub(super) fn decoded(self, precision: u16) -> Self {
        Self { bits: self.bits.min(precision).max(1), shift: 0, ..self }
    }

    /// The number that a pixel's bits stand for.
    pub(super) fn value(self, word: u32) -> i64 {
        let unused = 64 - u32::from(self.bits);
        let top = u64::from(word >> self.shift) << unused;
        if self.signed { top as i64 >> unused } else { (top >> unused) as i64 }
    }

    /// Smallest and largest number.
    pub(super) fn range(self) -> [i64; 2] {
        let values = 1_i64 << self.bits;
        if self.signed { [-values / 2, values / 2 - 1] } else { [0, values - 1] }
    }

    /// The number that marks padding, from the 16 bits of its attribute. Its VR should be that of the pixels, but is often
    /// wrong; and some write as many bits as pixels have. A number that no pixel has marks none.
    pub(super) fn padding(self, word: u16) -> i64 {
        if !self.signed {
            return word.into();
        }
        let [low, high] = self.range();
        let number = i64::from(word.cast_signed());
        let bits_of_a_pixel = i64::from(word) < 1_i64 << self.bits;
        if (low..=high).contains(&number) || !bits_of_a_pixel {
            number
        } else {
            Self { shift: 0, ..self }.value(word.into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWELVE: Stored = Stored { allocated: 16, bits: 12, shift: 0, signed: false };

    #[test]
    fn bits_that_mean_nothing_are_masked_and_the_sign_is_the_highest_that_does() {
        let signed = Stored { signed: true, ..TWELVE };
        for (word, unsigned, with_sign) in [(0xf7ff, 2047, 2047), (0x0800, 2048, -2048), (0xafff, 4095, -1)] {
            assert_eq!((TWELVE.value(word), signed.value(word)), (unsigned, with_sign), "{word:x}");
        }
        let shifted = Stored { shift: 4, ..signed };
        assert_eq!(shifted.value(0xfffa), -1);
        let wide = Stored { allocated: 32, bits: 32, shift: 0, signed: true };
        assert_eq!([wide.value(u32::MAX), wide.value(1 << 31)], [-1, i64::from(i32::MIN)]);
        assert_eq!(wide.range(), [i64::from(i32::MIN), i64::from(i32::MAX)]);
    }

    #[test]
    fn padding_is_understood_whatever_its_vr() {
        let signed16 = Stored { bits: 16, signed: true, ..TWELVE };
        let signed12 = Stored { signed: true, ..TWELVE };
        assert_eq!(signed16.padding(63536), -2000);
        assert_eq!(signed12.padding(63536), -2000);
        assert_eq!(signed12.padding(0x0830), -2000);
        assert_eq!(TWELVE.padding(4095), 4095);
        // No pixel of 12 bits, not even 0, whose bits are the lower ones.
        assert_eq!(signed12.padding(0x8000), -32768);
        // −2000 for pixels that have no sign: no pixel is padding, 2096 least of all.
        assert_eq!(TWELVE.padding(63536), 63536);
    }
}
