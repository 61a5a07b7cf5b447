//! Fingerprints: whether two runs were made of the same.

use drr::volume::{Volume, Voxel, Voxels};
use drr::{Projector, Scene};
use rayon::prelude::*;

/// Values that threads work on at a time.
const BLOCK: usize = 1 << 20;

/// FNV-1a of 128 bits (Fowler, Noll and Vo), of a word at a time: tells what differs by mistake, not by intent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fingerprint(u128);

impl Fingerprint {
    const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

    /// Of everything that a projector's images depend on but the views: the same for the same bytes, whether a tolerance
    /// or the user chose the method, and whatever views were expected.
    pub(crate) fn of(projector: &Projector) -> Self {
        let (plan, scene) = (projector.plan(), projector.scene());
        let effects = plan.effects.clone();
        let scene = Scene {
            tolerance: None,
            expected_views: Vec::new(),
            method: plan.method,
            effects,
            ..scene.clone()
        };
        let focus = plan.focus.as_ref().map(|choice| choice.focus);
        // What is written for debugging has every field, and floats to the last bit.
        let text = format!("{} {:?} {scene:?} {:?} {focus:?}", drr::VERSION, plan.engine, plan.quadrature);
        Self::of_volume(projector.volume()).with(letters(&text))
    }

    fn of_volume(volume: &Volume) -> Self {
        let grid = format!("{:?} {:?}", volume.grid(), volume.classes());
        let meaning = |table: &[Voxel]| {
            blocks(table, |voxels| voxels.iter().flat_map(|v| [v.density.to_bits(), u64::from(v.label)]))
        };
        let parts = match volume.voxels() {
            Voxels::Coded { codes, table } => [blocks(codes, four_in_a_word), meaning(table)],
            Voxels::Dense { density, label } => [
                blocks(density, |values| values.iter().map(|x| u64::from(x.to_bits()))),
                blocks(label, |values| values.iter().map(|&label| u64::from(label))),
            ],
            // The command has none; the texels would be the GPU's.
            Voxels::Texture { table, .. } => [meaning(table), Vec::new()],
        };
        let parts = parts.iter().flatten().flat_map(|part| [part.0 as u64, (part.0 >> 64) as u64]);
        Self(Self::OFFSET).with(letters(&grid)).with(parts)
    }

    fn with(self, words: impl IntoIterator<Item = u64>) -> Self {
        let one = |hash: u128, word| (hash ^ u128::from(word)).wrapping_mul(Self::PRIME);
        Self(words.into_iter().fold(self.0, one))
    }
}

/// As the method has it.
fn letters(text: &str) -> impl Iterator<Item = u64> {
    text.bytes().map(u64::from)
}

/// Fewer steps than of each code alone: each waits for the one before.
fn four_in_a_word(codes: &[u16]) -> impl Iterator<Item = u64> {
    codes.chunks(4).map(|four| four.iter().fold(0, |word, &code| word << 16 | u64::from(code)))
}

/// Of each block, in order.
fn blocks<'a, T: Sync, W: Iterator<Item = u64>>(
    values: &'a [T],
    words: impl Fn(&'a [T]) -> W + Sync,
) -> Vec<Fingerprint> {
    let of_block = |block| Fingerprint(Fingerprint::OFFSET).with(words(block));
    values.par_chunks(BLOCK).map(of_block).collect()
}

/// 32 hexadecimal digits.
impl std::fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one() {
        let of = |text: &str| Fingerprint(Fingerprint::OFFSET).with(letters(text)).to_string();
        assert_eq!(of(""), "6c62272e07bb014262b821756295c58d");
        assert_eq!(of("a"), "d228cb696f1a8caf78912b704e4a8964");
        assert_eq!(of("foobar"), "343e1662793c64bf6f0d3597ba446f18");
    }
    #[test]
    fn every_voxel_and_its_place_count() {
        let of = |codes: &[u16]| blocks(codes, four_in_a_word);
        let mut codes = vec![7; BLOCK + 5];
        let plain = of(&codes);
        for place in [0, 3, 4, BLOCK - 1, BLOCK, BLOCK + 4] {
            codes[place] ^= 1 << 15;
            assert_ne!(of(&codes), plain, "{place}");
            codes.swap(place, place.saturating_sub(1));
            assert_ne!(of(&codes), plain, "{place}");
            codes.fill(7);
        }
    }
}
