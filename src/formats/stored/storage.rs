//! How files store numbers.

/// The type of the stored numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) enum Storage {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Storage {
    /// Bytes of one number.
    pub(in crate::formats) fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// Smallest and largest number of an integer type.
    pub(in crate::formats) fn integer_range(self) -> Option<[f64; 2]> {
        Some(match self {
            Self::U8 => [0.0, f64::from(u8::MAX)],
            Self::I8 => [f64::from(i8::MIN), f64::from(i8::MAX)],
            Self::U16 => [0.0, f64::from(u16::MAX)],
            Self::I16 => [f64::from(i16::MIN), f64::from(i16::MAX)],
            Self::U32 => [0.0, f64::from(u32::MAX)],
            Self::I32 => [f64::from(i32::MIN), f64::from(i32::MAX)],
            Self::U64 => [0.0, u64::MAX as f64],
            Self::I64 => [i64::MIN as f64, i64::MAX as f64],
            Self::F32 | Self::F64 => return None,
        })
    }

    /// Calls `each` with every number in `bytes`. Integers beyond 2⁵³ are rounded.
    #[allow(
        clippy::cast_lossless,
        reason = "one text for all types; 64-bit integers have no lossless conversion"
    )]
    pub(in crate::formats) fn decode(self, big_endian: bool, bytes: &[u8], mut each: impl FnMut(f64)) {
        macro_rules! decode {
            ($number:ty) => {
                for &bytes in bytes.as_chunks().0 {
                    let little = <$number>::from_le_bytes(bytes);
                    each((if big_endian { <$number>::from_be_bytes(bytes) } else { little }) as f64);
                }
            };
        }
        match self {
            Self::U8 => decode!(u8),
            Self::I8 => decode!(i8),
            Self::U16 => decode!(u16),
            Self::I16 => decode!(i16),
            Self::U32 => decode!(u32),
            Self::I32 => decode!(i32),
            Self::U64 => decode!(u64),
            Self::I64 => decode!(i64),
            Self::F32 => decode!(f32),
            Self::F64 => decode!(f64),
        }
    }
}
