//! The fuzzer's bytes, taken as numbers. A byte below 128 means the ordinary value: no bytes at all are a call that
//! succeeds, and most inputs are wrong in few places.

use std::ops::Range;

/// Numbers at the ends of float64 and float32, and where their arithmetic changes.
const NASTY: [f64; 24] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.0,
    -0.0,
    5e-324,
    f64::MIN_POSITIVE,
    1e-300,
    1e-100,
    1e-45,
    1.2e-38,
    1e-20,
    1e-9,
    1e-6,
    -1.0,
    0.5,
    1e6,
    1e9,
    1e10,
    16_777_217.0,
    3.4e38,
    1e100,
    1e300,
    f64::MAX,
];

/// Numbers around every limit of the interface, and those whose products overflow.
const NASTY_COUNTS: [usize; 16] = [
    0,
    1,
    255,
    4096,
    4097,
    1 << 15,
    (1 << 15) + 1,
    1 << 16,
    (1 << 16) + 1,
    1 << 31,
    1 << 32,
    (1 << 32) + 1,
    1 << 61,
    1 << 62,
    1 << 63,
    usize::MAX,
];

/// Bytes that never end: after the last come zeros.
pub(super) struct Input<'a> {
    bytes: &'a [u8],
}

impl<'a> Input<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    pub(super) fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.bytes.split_first() else { return 0 };
        self.bytes = rest;
        first
    }

    /// The last byte; inputs that know nothing of what it is for go on as before.
    pub(super) fn last(&mut self) -> u8 {
        let Some((&last, rest)) = self.bytes.split_last() else { return 0 };
        self.bytes = rest;
        last
    }

    /// The last bytes, as many as there are, if the very last is this one: inputs that end otherwise go on as before.
    pub(super) fn end(&mut self, mark: u8, count: usize) -> Option<Self> {
        let (_, rest) = self.bytes.split_last().filter(|(last, _)| **last == mark)?;
        let (bytes, end) = rest.split_at(rest.len().saturating_sub(count));
        self.bytes = bytes;
        Some(Self { bytes: end })
    }

    fn word(&mut self) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    /// True for half of all bytes, false for 0.
    pub(super) fn seldom(&mut self) -> bool {
        self.byte() >= 128
    }

    /// One of the values; the first is the ordinary one.
    pub(super) fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        let byte = usize::from(self.byte());
        values[byte.saturating_sub(128) % values.len()]
    }

    /// The ordinary value, one near it, a nasty one, or any at all.
    pub(super) fn number(&mut self, ordinary: f64) -> f64 {
        match self.byte() {
            ..128 => ordinary,
            byte @ 128..192 => ordinary * f64::from(byte - 127) / 32.0,
            byte @ 192..216 => NASTY[usize::from(byte - 192)],
            byte @ 216..232 => -NASTY[usize::from(byte - 216) + 4],
            232.. => f64::from_bits(self.word()),
        }
    }

    /// As `number`.
    pub(super) fn float(&mut self, ordinary: f32) -> f32 {
        match self.number(ordinary.into()) {
            // Bits of a float64 seldom make a denormal or a large float32.
            any if any.is_normal() && (any as f32).is_infinite() => f32::from_bits(any.to_bits() as u32),
            number => number as f32,
        }
    }

    /// As many as `ordinary`, or some within the range, or a nasty number.
    pub(super) fn count(&mut self, ordinary: usize, usual: Range<usize>) -> usize {
        match self.byte() {
            ..128 => ordinary,
            byte @ 128..224 => usual.start + usize::from(byte - 128) % usual.len(),
            byte @ 224..240 => NASTY_COUNTS[usize::from(byte - 224)],
            240.. => self.word() as usize,
        }
    }

    /// The ordinary code, a small one, or any.
    pub(super) fn code(&mut self, ordinary: u32) -> u32 {
        match self.byte() {
            ..128 => ordinary,
            byte @ 128..240 => u32::from(byte % 10),
            240.. => self.word() as u32,
        }
    }
}
