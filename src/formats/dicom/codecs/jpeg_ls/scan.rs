//! Decoding the pixels of a scan, one after the other (annex A).

use super::bits::Bits;
use super::context::Context;
use super::header::Header;
use crate::allocation::reserved;
use crate::formats::Checked;

/// Contexts of regular mode, the first of which is unused.
const REGULAR: usize = 365;
/// The orders of the codes of a run's length (A.2.1).
const J: [u32; 32] =
    [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13, 14, 15];

struct Decoder<'a> {
    header: &'a Header,
    range: i32,
    qbpp: u32,
    limit: u32,
    bits: Bits<'a>,
    contexts: [Context; REGULAR],
    /// Where a run is interrupted: by a pixel unlike that above it, or like it.
    interruptions: [Context; 2],
    run_index: usize,
}

/// The pixels, row by row.
pub(super) fn decode(header: &Header, scan: &[u8]) -> Checked<Vec<u32>> {
    let range = header.range();
    let mut decoder = Decoder {
        header,
        range,
        qbpp: header.qbpp(),
        limit: header.limit(),
        bits: Bits::new(scan),
        contexts: [Context::new(range); REGULAR],
        interruptions: [Context::new(range); 2],
        run_index: 0,
    };
    let [columns, rows] = header.size;
    let mut pixels = reserved(columns * rows, "the pixels of a slice").map_err(|e| e.to_string())?;
    // A pixel more at either end (A.2.1): left of a row, the pixel above its first; right of it, its last.
    let [mut above, mut row] = [vec![0; columns + 2], vec![0; columns + 2]];
    for _ in 0..rows {
        row[0] = above[1];
        decoder.row(&above, &mut row)?;
        row[columns + 1] = row[columns];
        pixels.extend(row[1..=columns].iter().map(|&pixel| pixel as u32));
        std::mem::swap(&mut above, &mut row);
    }
    Ok(pixels)
}

impl Decoder<'_> {
    fn row(&mut self, above: &[i32], row: &mut [i32]) -> Checked<()> {
        let mut at = 1;
        let end = row.len() - 1;
        while at < end {
            let (a, b, c, d) = (row[at - 1], above[at], above[at - 1], above[at + 1]);
            let gradients = [d - b, b - c, c - a];
            if gradients.iter().all(|g| g.abs() <= self.header.near) {
                at += self.run(&mut row[at..end], a)?;
                if at < end {
                    row[at] = self.interruption(a, above[at])?;
                    at += 1;
                }
            } else {
                row[at] = self.regular(gradients, a, b, c)?;
                at += 1;
            }
        }
        Ok(())
    }

    /// A pixel in regular mode (A.3 to A.6).
    fn regular(&mut self, gradients: [i32; 3], a: i32, b: i32, c: i32) -> Checked<i32> {
        let [q1, q2, q3] = gradients.map(|gradient| self.quantised(gradient));
        let index = (9 * q1 + q2) * 9 + q3;
        let sign = index.signum();
        let context = &mut self.contexts[index.unsigned_abs() as usize];
        let predicted = if c >= a.max(b) {
            a.min(b)
        } else if c <= a.min(b) {
            a.max(b)
        } else {
            a + b - c
        };
        let predicted = (predicted + sign * context.c).clamp(0, self.header.maxval);
        let k = context.k(context.a);
        let mapped = self.bits.golomb(k, self.limit, self.qbpp)?;
        check(mapped, self.range)?;
        let error = context.error(mapped, k, self.header.near);
        context.learn(error, self.header.near, self.header.reset);
        Ok(self.reconstructed(predicted, sign * error))
    }

    /// A run of pixels like `a` (A.7.1): how many.
    fn run(&mut self, rest: &mut [i32], a: i32) -> Checked<usize> {
        let mut length = 0;
        while length < rest.len() && self.bits.bit()? == 1 {
            length += 1 << J[self.run_index];
            if length <= rest.len() {
                self.run_index = (self.run_index + 1).min(J.len() - 1);
            }
        }
        if length < rest.len() {
            length += self.bits.bits(J[self.run_index])? as usize;
            if length >= rest.len() {
                return Err("a run is longer than its row".to_owned());
            }
        }
        let length = length.min(rest.len());
        rest[..length].fill(a);
        Ok(length)
    }

    /// The pixel after a run of pixels like `a`, below `b` (A.7.2).
    fn interruption(&mut self, a: i32, b: i32) -> Checked<i32> {
        let alike = (a - b).abs() <= self.header.near;
        let kind = i32::from(alike);
        let context = &mut self.interruptions[usize::from(alike)];
        let k = context.k(if alike { context.a + (context.n >> 1) } else { context.a });
        let limit = self.limit.saturating_sub(J[self.run_index] + 1);
        let mapped = self.bits.golomb(k, limit, self.qbpp)?;
        check(mapped, self.range)?;
        let error = context.interrupting_error(mapped, k, kind);
        context.learn_interruption(error, mapped, kind, self.header.reset);
        self.run_index = self.run_index.saturating_sub(1);
        let sign = if !alike && a > b { -1 } else { 1 };
        Ok(self.reconstructed(if alike { a } else { b }, sign * error))
    }

    /// A gradient's class, −4 … 4 (A.3.3).
    fn quantised(&self, gradient: i32) -> i32 {
        let size = gradient.abs();
        let [t1, t2, t3] = self.header.thresholds;
        let class = if size <= self.header.near {
            0
        } else {
            1 + [t1, t2, t3].iter().filter(|&&t| size >= t).count()
        };
        gradient.signum() * class as i32
    }

    /// The pixel of a prediction and its error (A.4.5, A.5.1 inverted).
    fn reconstructed(&self, predicted: i32, error: i32) -> i32 {
        let Header { near, maxval, .. } = *self.header;
        let step = 2 * near + 1;
        let period = self.range * step;
        let pixel = predicted + error * step;
        let pixel = if pixel < -near {
            pixel + period
        } else if pixel > maxval + near {
            pixel - period
        } else {
            pixel
        };
        pixel.clamp(0, maxval)
    }
}

/// No encoder makes larger errors; sums of them stay small.
fn check(mapped: i32, range: i32) -> Checked<()> {
    if (0..=2 * range).contains(&mapped) {
        Ok(())
    } else {
        Err("an error is larger than pixels can be".to_owned())
    }
}
