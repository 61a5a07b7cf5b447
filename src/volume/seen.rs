//! Which codes occur.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::builder::PIECE;

/// Codes that are looked up together.
const BLOCK: usize = 64;

/// A flag for each 16-bit code.
#[derive(Debug)]
pub(super) struct Seen(Box<[AtomicBool; 1 << 16]>);

impl Seen {
    /// None of them.
    pub(super) fn none() -> Self {
        let flags: Vec<_> = (0..1 << 16).map(|_| AtomicBool::new(false)).collect();
        let flags = flags.into_boxed_slice().try_into();
        Self(flags.unwrap_or_else(|_| unreachable!("there is one flag per 16-bit code")))
    }

    /// Notes the codes that occur here.
    pub(super) fn note(&self, codes: &[u16]) {
        codes.par_chunks(PIECE).for_each(|piece| {
            let (blocks, rest) = piece.as_chunks::<BLOCK>();
            for block in blocks {
                self.note_block(block);
            }
            self.note_block(rest);
        });
    }

    /// One scan has few codes: nearly always all are known, which is asked without a branch for each.
    fn note_block(&self, codes: &[u16]) {
        let known = |code: u16| self.has(code);
        if !codes.iter().fold(true, |all, &code| all & known(code)) {
            // Threads share the cache lines: write only what changes.
            for &code in codes.iter().filter(|&&code| !known(code)) {
                self.0[usize::from(code)].store(true, Ordering::Relaxed);
            }
        }
    }

    pub(super) fn has(&self, code: u16) -> bool {
        self.0[usize::from(code)].load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_occurs_is_noted_and_nothing_else() {
        // More than a piece, the end not a whole block; each rare code once, where blocks and pieces begin and end.
        let mut codes = vec![7; PIECE + BLOCK + 5];
        let rare = [0, BLOCK - 1, BLOCK, PIECE - 1, PIECE, PIECE + BLOCK - 1, PIECE + BLOCK, codes.len() - 1];
        let code = |n: usize| u16::MAX - n as u16;
        rare.iter().enumerate().for_each(|(n, &at)| codes[at] = code(n));
        let seen = Seen::none();
        seen.note(&codes);
        seen.note(&[]);
        let expected: Vec<u16> = [7].into_iter().chain((0..rare.len()).rev().map(code)).collect();
        assert_eq!((0..=u16::MAX).filter(|&code| seen.has(code)).collect::<Vec<_>>(), expected);
    }
}
