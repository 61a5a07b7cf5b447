//! Which part is on top along a line.

use std::collections::BinaryHeap;

use glam::DVec3;

use super::Part;

/// The stretch of a line inside one part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    /// Index of the part.
    pub(super) part: usize,
    /// How much of the stretch no later part hides, in units of the line's parameter.
    pub(super) visible: f64,
    start: f64,
    end: f64,
}

/// Finds visible lengths; keeps its buffers from line to line.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    spans: Vec<Span>,
    /// (part, index of its span) of all spans that are open at the current position, highest part first.
    open: BinaryHeap<(usize, usize)>,
}

impl Sweep {
    /// The parts that the piece `range` of the line `origin + t * direction` meets, with their visible lengths.
    /// `direction` is a unit vector, and `origin` not far from the parts.
    pub(super) fn run<'a>(
        &mut self,
        parts: impl Iterator<Item = (usize, &'a Part)>,
        origin: DVec3,
        direction: DVec3,
        range: [f64; 2],
    ) -> &[Span] {
        self.collect(parts, origin, direction, range);
        self.resolve();
        &self.spans
    }

    fn collect<'a>(
        &mut self,
        parts: impl Iterator<Item = (usize, &'a Part)>,
        origin: DVec3,
        direction: DVec3,
        range: [f64; 2],
    ) {
        self.spans.clear();
        for (part, Part { shape, .. }) in parts {
            let miss_squared = (shape.centre() - origin).cross(direction).length_squared();
            // Most parts are far from the line. The margin is for the rounding of this test alone.
            if miss_squared > (1.0 + 1e-9) * shape.reach().powi(2) {
                continue;
            }
            let Some([enter, leave]) = shape.interval(origin, direction) else { continue };
            let (start, end) = (enter.max(range[0]), leave.min(range[1]));
            if start < end {
                self.spans.push(Span { part, visible: 0.0, start, end });
            }
        }
        self.spans.sort_unstable_by(|a, b| a.start.total_cmp(&b.start));
    }

    /// Walks from cut to cut; every step goes to the highest part that is open there.
    fn resolve(&mut self) {
        let Self { spans, open } = self;
        open.clear();
        let mut position = f64::NEG_INFINITY;
        let mut next = 0;
        loop {
            while next < spans.len() && spans[next].start <= position {
                open.push((spans[next].part, next));
                next += 1;
            }
            while open.peek().is_some_and(|&(_, index)| spans[index].end <= position) {
                open.pop();
            }
            let begins = spans.get(next).map(|span| span.start);
            match (open.peek(), begins) {
                (Some(&(_, top)), _) => {
                    let until = spans[top].end.min(begins.unwrap_or(f64::INFINITY));
                    spans[top].visible += until - position;
                    position = until;
                }
                (None, Some(start)) => position = start,
                (None, None) => break,
            }
        }
    }
}
