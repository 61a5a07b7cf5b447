//! Codes to densities without a table: lines between a few codes.

use crate::engine::cpu::level::{LANES, Level, Wide, load, store};
use crate::volume::Voxel;

/// Most pieces of a table that are told apart one by one.
const MOST: usize = 48;
/// What the lines may be off by, as a part of the table's densities.
const TOLERANCE: f64 = 1e-7;

/// `density + slope·(code − first)`, g/cm³, from this code on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub first: f32,
    pub density: f32,
    pub slope: f32,
}

/// The density of one material at every code, 0 where the code has another material: pieces, in ascending order. Before the
/// first it is 0.
#[derive(Debug, Clone, Default)]
pub(super) struct Densities {
    pub pieces: Vec<Piece>,
}

impl Densities {
    /// Of each label; `None` where lines do not say what the table says.
    pub(super) fn of(table: &[Voxel], labels: &[u8]) -> Option<Vec<Self>> {
        let mut all = Vec::new();
        for &own in labels {
            let value = |code: usize| if table[code].label == own { table[code].density } else { 0.0 };
            let label = |code: usize| table[code].label == own;
            let mut pieces = Vec::new();
            let mut first = 0;
            while first < table.len() {
                let density = value(first);
                let mut end = first + 1;
                let mut slope = 0.0;
                if end < table.len() && label(end) == label(first) {
                    slope = value(end) - density;
                    let fits = |code: usize| {
                        let line = density + slope * (code - first) as f64;
                        let exact = value(code);
                        label(code) == label(first) && (line - exact).abs() <= 0.1 * TOLERANCE * exact
                    };
                    while end < table.len() && fits(end) {
                        end += 1;
                    }
                }
                let piece = Piece { first: first as f32, density: density as f32, slope: slope as f32 };
                let zero = |p: &Piece| p.density == 0.0 && p.slope == 0.0;
                if !(zero(&piece) && pieces.last().is_none_or(zero)) {
                    pieces.push(piece);
                }
                if pieces.len() > MOST {
                    return None;
                }
                first = end;
            }
            let densities = Self { pieces };
            let right = |code: usize| {
                let exact = value(code);
                (f64::from(densities.at(code as f32)) - exact).abs() <= 2.0 * TOLERANCE * exact
            };
            if !(0..table.len()).all(right) {
                return None;
            }
            all.push(densities);
        }
        Some(all)
    }

    fn at(&self, code: f32) -> f32 {
        let mut density = 0.0;
        for piece in &self.pieces {
            if code >= piece.first {
                density = piece.slope.mul_add(code - piece.first, piece.density);
            }
        }
        density
    }

    /// Those of some codes, a whole number of chunks.
    #[inline(always)]
    pub(super) fn decode<S: Level>(&self, simd: S, codes: &[u16], out: &mut [f32]) {
        match self.pieces.len() {
            0 => out.fill(0.0),
            1 => decode::<S, 1>(simd, &self.pieces, codes, out),
            2 => decode::<S, 2>(simd, &self.pieces, codes, out),
            3 => decode::<S, 3>(simd, &self.pieces, codes, out),
            4 => decode::<S, 4>(simd, &self.pieces, codes, out),
            _ => decode::<S, MOST>(simd, &self.pieces, codes, out),
        }
    }
}

#[inline(always)]
fn decode<S: Level, const N: usize>(simd: S, pieces: &[Piece], codes: &[u16], out: &mut [f32]) {
    let pieces = &pieces[..N.min(pieces.len())];
    for (codes, out) in codes.as_chunks::<LANES>().0.iter().zip(out.as_chunks_mut::<LANES>().0) {
        let code: Wide = std::array::from_fn(|i| f32::from(codes[i]));
        for n in 0..LANES / S::F32_LANES {
            let at = n * S::F32_LANES;
            let code = load::<S>(&code[at..]);
            let mut density = simd.splat_f32s(0.0);
            for piece in pieces {
                let first = simd.splat_f32s(piece.first);
                let line = simd.times_plus(
                    simd.splat_f32s(piece.slope),
                    simd.sub_f32s(code, first),
                    simd.splat_f32s(piece.density),
                );
                density = simd.select_f32s(simd.greater_than_or_equal_f32s(code, first), line, density);
            }
            store::<S>(&mut out[at..], density);
        }
    }
}
