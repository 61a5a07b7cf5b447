//! The levels of vector instructions: arithmetic is written once, for pulp's vectors, and runs at the best level that the
//! machine has.

use std::sync::LazyLock;

use pulp::{Scalar128b, Simd};

/// Rays side by side, whatever the width of a vector.
pub(super) const LANES: usize = 16;

/// A value for each ray.
pub(super) type Wide = [f32; LANES];

/// A level: pulp's arithmetic, and what it lacks.
pub(super) trait Level: Simd {
    /// `values[at]` and `values[at + 1]`, lane by lane. Every place is limited to the last one that there is.
    fn pairs(self, values: &[f32], at: Self::u32s) -> [Self::f32s; 2];

    /// As `pairs`, for places below 31.
    #[inline(always)]
    fn near_pairs(self, values: &[f32; 2 * LANES], at: Self::u32s) -> [Self::f32s; 2] {
        self.pairs(values, at)
    }

    /// a·b + c, fused where the machine can.
    #[inline(always)]
    fn times_plus(self, a: Self::f32s, b: Self::f32s, c: Self::f32s) -> Self::f32s {
        self.mul_add_e_f32s(a, b, c)
    }

    /// Has a line of codes brought near.
    #[inline(always)]
    fn prefetch(self, _codes: &[u16]) {}
}

/// The vector at the start of `values`.
#[inline(always)]
pub(super) fn load<S: Simd>(values: &[f32]) -> S::f32s {
    S::as_simd_f32s(&values[..S::F32_LANES]).0[0]
}

/// As `load`, of integers.
#[inline(always)]
pub(super) fn load_u32<S: Simd>(values: &[u32]) -> S::u32s {
    S::as_simd_u32s(&values[..S::U32_LANES]).0[0]
}

/// Puts a vector at the start of `values`.
#[inline(always)]
pub(super) fn store<S: Simd>(values: &mut [f32], vector: S::f32s) {
    S::as_mut_simd_f32s(&mut values[..S::F32_LANES]).0[0] = vector;
}

/// Pairs read one by one.
#[inline(always)]
fn each_pair<S: Simd>(values: &[f32], at: S::u32s) -> [S::f32s; 2] {
    let at: &[u32] = pulp::bytemuck::cast_slice(std::slice::from_ref(&at));
    let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
    for (n, &at) in at.iter().enumerate() {
        let at = (at as usize).min(values.len() - 2);
        (low[n], high[n]) = (values[at], values[at + 1]);
    }
    [load::<S>(&low), load::<S>(&high)]
}

/// Vectors of four that any compiler makes, of SSE2 on x86-64.
impl Level for Scalar128b {
    #[inline(always)]
    fn pairs(self, values: &[f32], at: Self::u32s) -> [Self::f32s; 2] {
        each_pair::<Self>(values, at)
    }

    /// pulp's is a call of a function for each number.
    #[inline(always)]
    fn times_plus(self, a: Self::f32s, b: Self::f32s, c: Self::f32s) -> Self::f32s {
        self.add_f32s(self.mul_f32s(a, b), c)
    }
}

#[cfg(target_arch = "aarch64")]
impl Level for pulp::aarch64::Neon {
    #[inline(always)]
    fn pairs(self, values: &[f32], at: Self::u32s) -> [Self::f32s; 2] {
        each_pair::<Self>(values, at)
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::_MM_HINT_T1;

    use pulp::x86::{V3, V4};
    use pulp::{NullaryFnOnce, Simd, cast};

    use super::{AtLevel, LANES, Level, load};

    /// Codes in a cache line.
    const LINE: usize = 32;

    const EVEN: [u32; LANES] = [0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30];
    const ODD: [u32; LANES] = [1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31];

    /// What pulp compiles for a level.
    pub(super) struct With<S, W>(pub S, pub W);

    impl<S: Level, W: AtLevel> NullaryFnOnce for With<S, W> {
        type Output = W::Output;

        #[inline(always)]
        fn call(self) -> W::Output {
            self.1.run(self.0)
        }
    }

    impl Level for V3 {
        #[inline(always)]
        #[allow(unsafe_code, reason = "gathers take addresses")]
        fn pairs(self, values: &[f32], at: Self::u32s) -> [Self::f32s; 2] {
            assert!((2..1 << 31).contains(&values.len()), "{} values", values.len());
            let last = self.splat_u32s(values.len() as u32 - 2);
            let at = cast(self.min_u32s(at, last));
            let from = values.as_ptr();
            // SAFETY: there are at least two values, so that the last place has one behind it; places fit 31 bits.
            let [low, high] = unsafe {
                [
                    self.avx2._mm256_i32gather_ps::<4>(from, at),
                    self.avx2._mm256_i32gather_ps::<4>(from.add(1), at),
                ]
            };
            [cast(low), cast(high)]
        }

        #[inline(always)]
        fn prefetch(self, codes: &[u16]) {
            for line in codes.chunks(LINE) {
                self.sse._mm_prefetch::<_MM_HINT_T1>(line.as_ptr().cast());
            }
        }
    }

    impl Level for V4 {
        /// Two pairs of floats are read as one float64: half as many reads.
        #[inline(always)]
        #[allow(unsafe_code, reason = "gathers take addresses")]
        fn pairs(self, values: &[f32], at: Self::u32s) -> [Self::f32s; 2] {
            assert!((2..1 << 31).contains(&values.len()), "{} values", values.len());
            let last = self.splat_u32s(values.len() as u32 - 2);
            let at = cast(self.min_u32s(at, last));
            let first = self.avx512f._mm512_castsi512_si256(at);
            let second = self.avx512f._mm512_extracti64x4_epi64::<1>(at);
            let from = values.as_ptr().cast();
            // SAFETY: there are at least two values, so that the last place has one behind it; places fit 31 bits.
            let [first, second] = unsafe {
                [
                    self.avx512f._mm512_i32gather_pd::<4>(first, from),
                    self.avx512f._mm512_i32gather_pd::<4>(second, from),
                ]
            };
            let [first, second] = [cast(first), cast(second)];
            // No closures: they are compiled for the lowest level when they are not inlined.
            [
                cast(self.avx512f._mm512_permutex2var_ps(first, cast(EVEN), second)),
                cast(self.avx512f._mm512_permutex2var_ps(first, cast(ODD), second)),
            ]
        }

        #[inline(always)]
        fn near_pairs(self, values: &[f32; 2 * LANES], at: Self::u32s) -> [Self::f32s; 2] {
            let next = self.add_u32s(at, self.splat_u32s(1));
            let (a, b) = (cast(load::<Self>(values)), cast(load::<Self>(&values[LANES..])));
            [
                cast(self.avx512f._mm512_permutex2var_ps(a, cast(at), b)),
                cast(self.avx512f._mm512_permutex2var_ps(a, cast(next), b)),
            ]
        }

        #[inline(always)]
        fn prefetch(self, codes: &[u16]) {
            V3::prefetch(*self, codes);
        }
    }
}

/// Something to be done at any level.
pub(super) trait AtLevel {
    type Output;
    fn run<S: Level>(self, simd: S) -> Self::Output;
}

/// The levels, lowest first.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    /// What every machine has.
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    #[cfg(target_arch = "x86_64")]
    Avx512(pulp::x86::V4),
    #[cfg(target_arch = "aarch64")]
    Neon(pulp::aarch64::Neon),
}

impl Kind {
    /// Those of this machine.
    pub(super) fn available() -> Vec<Self> {
        let mut all = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(pulp::x86::V3::try_new().map(Self::Avx2));
            all.extend(pulp::x86::V4::try_new().map(Self::Avx512));
        }
        #[cfg(target_arch = "aarch64")]
        all.extend(pulp::aarch64::Neon::try_new().map(Self::Neon));
        all
    }

    /// The name, as in the environment variable `DRR_SIMD`.
    pub(super) fn name(self) -> &'static str {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Portable => "sse2",
            #[cfg(not(target_arch = "x86_64"))]
            Self::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => "avx512",
            #[cfg(target_arch = "aarch64")]
            Self::Neon(_) => "neon",
        }
    }

    /// The best, or the one that `DRR_SIMD` names if it is there.
    pub(super) fn chosen() -> Self {
        static CHOSEN: LazyLock<Kind> = LazyLock::new(|| {
            let all = Kind::available();
            let wanted = std::env::var("DRR_SIMD").unwrap_or_default();
            *all.iter().find(|kind| kind.name() == wanted).unwrap_or(&all[all.len() - 1])
        });
        *CHOSEN
    }

    /// Does it at this level.
    pub(super) fn dispatch<W: AtLevel>(self, work: W) -> W::Output {
        match self {
            Self::Portable => work.run(Scalar128b),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(simd) => simd.vectorize(x86::With(simd, work)),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(simd) => simd.vectorize(x86::With(simd, work)),
            #[cfg(target_arch = "aarch64")]
            Self::Neon(simd) => work.run(simd),
        }
    }
}
