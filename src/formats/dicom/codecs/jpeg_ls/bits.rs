//! The bits of a scan.

use crate::formats::Checked;

/// Reads the bits of a scan from the highest of each byte on. After a byte 0xff, one bit is stuffed (A.1).
pub(super) struct Bits<'a> {
    bytes: std::slice::Iter<'a, u8>,
    byte: u8,
    left: u32,
}

impl<'a> Bits<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes: bytes.iter(), byte: 0, left: 0 }
    }

    pub(super) fn bit(&mut self) -> Checked<u32> {
        if self.left == 0 {
            let stuffed = self.byte == 0xff;
            self.byte = *self.bytes.next().ok_or("the scan is truncated")?;
            if stuffed && self.byte & 0x80 != 0 {
                return Err("the scan ends before its last pixel".to_owned());
            }
            self.left = if stuffed { 7 } else { 8 };
        }
        self.left -= 1;
        Ok(u32::from(self.byte >> self.left & 1))
    }

    pub(super) fn bits(&mut self, count: u32) -> Checked<u32> {
        (0..count).try_fold(0, |number, _| Ok(number << 1 | self.bit()?))
    }

    /// A number in the limited Golomb code (A.5.3).
    pub(super) fn golomb(&mut self, k: u32, limit: u32, qbpp: u32) -> Checked<i32> {
        let longest = limit.checked_sub(qbpp + 1).ok_or("its code has no room")?;
        let mut zeros = 0;
        while self.bit()? == 0 {
            zeros += 1;
            if zeros > longest {
                return Err("a code is too long".to_owned());
            }
        }
        let number = if zeros < longest { zeros << k | self.bits(k)? } else { self.bits(qbpp)? + 1 };
        Ok(number as i32)
    }
}
