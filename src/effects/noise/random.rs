//! The random numbers of a row of pixels.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

/// What keeps these numbers apart from any other use of the same seed.
const DOMAIN: [u8; 8] = *b"drrnoise";

/// The uniform numbers of one row of one layer of one view, pixel after pixel: the same whatever was drawn before, on
/// every machine.
///
/// `ChaCha8` (D. J. Bernstein, Workshop Record of SASC 2008) as a function of a counter: its 256-bit key is the seed,
/// the view, the layer and a constant, its 64-bit nonce the row, so that no two rows share a stream.
#[derive(Debug)]
pub(crate) struct RowRandom {
    words: ChaCha8Rng,
}

impl RowRandom {
    pub(crate) fn new(seed: u64, view: usize, layer: usize, row: usize) -> Self {
        let mut key = [0; 32];
        let parts = [seed, view as u64, layer as u64].map(u64::to_le_bytes);
        key.chunks_exact_mut(8).zip(parts.iter().chain([&DOMAIN])).for_each(|(k, p)| k.copy_from_slice(p));
        let mut words = ChaCha8Rng::from_seed(key);
        words.set_stream(row as u64);
        Self { words }
    }

    /// Three uniform numbers in the open interval (0, 1) for the next pixel.
    pub(crate) fn draws(&mut self) -> [f64; 3] {
        [(); 3].map(|()| uniform(self.words.next_u64()))
    }
}

/// The middle of one of 2⁵² equal parts of (0, 1): both ends are kept out without a test, and u and 1 − u are alike.
fn uniform(word: u64) -> f64 {
    // 52 bits and a half are the 53 of a float64.
    ((word >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cipher_is_the_published_one() {
        // J. Strombergson, draft-strombergson-chacha-test-vectors-01 (2013), TC1: key and IV 0, 8 rounds, 256 bits.
        let published = "3e00ef2f895f40d67f5bb8e81f09a5a12c840ec3ce9a7f3b181be188ef711a1e\
                         984ce172b9216f419f445367456d5619314a42a3da86b001387bfdb80e0cfe42";
        let mut block = [0; 64];
        ChaCha8Rng::from_seed([0; 32]).fill_bytes(&mut block);
        assert_eq!(block.map(|byte| format!("{byte:02x}")).concat(), published);
    }

    #[test]
    fn the_numbers_are_the_same_everywhere() {
        // Words 0, 1, 2 and 30, 31, 32 of a ChaCha8 written for this from Bernstein's paper.
        let mut random = RowRandom::new(0x0123_4567_89ab_cdef, 70_000, 1, 32_768 * 16 - 1);
        let first = random.draws();
        let eleventh = (0..10).map(|_| random.draws()).last().unwrap();
        assert_eq!(first, [0.114_346_861_967_072_78, 0.478_098_234_918_737_15, 0.221_056_144_323_355_52]);
        assert_eq!(eleventh, [0.951_129_439_229_471, 0.991_038_933_565_855_5, 0.429_003_409_064_468_43]);
    }

    #[test]
    fn both_ends_are_out_and_the_halves_mirror_each_other() {
        assert_eq!([uniform(0), uniform(u64::MAX)], [0.5_f64.powi(53), 1.0 - 0.5_f64.powi(53)]);
        for word in [0, 1 << 12, 0x1234_5678_9abc_def0] {
            assert_eq!(uniform(word), 1.0 - uniform(!word));
        }
    }

    #[test]
    fn rows_are_drawn_in_any_order() {
        let row = |row: usize| {
            let mut random = RowRandom::new(7, 3, 0, row);
            [(); 50].map(|()| random.draws())
        };
        let forward: Vec<_> = (0..20).map(row).collect();
        let mut backward: Vec<_> = (0..20).rev().map(row).collect();
        backward.reverse();
        assert_eq!(forward, backward);
    }

    #[test]
    fn no_two_rows_share_numbers() {
        let mut seen = std::collections::HashSet::new();
        for seed in [0, 1, 1 << 32, u64::MAX] {
            for view in [0, 1, 2, 255, 256, 65_535, 65_536, 1 << 20] {
                for layer in 0..2 {
                    for row in [0, 1, 2, 32_767, 32_768, 32_768 * 16 - 1] {
                        let first = RowRandom::new(seed, view, layer, row).draws();
                        assert!(seen.insert(first.map(f64::to_bits)), "{seed}, {view}, {layer}, {row}");
                    }
                }
            }
        }
    }
}
