//! The slices that a ray passes, and how much of it is in each.

use std::ops::Range;

use crate::raycast::Span;

/// The slices of the driving axis that a span touches, of those given, each with the length of [k−½, k+½] inside the span, which
/// is above 0. Over all slices lengths sum to the span's. The hot loops of `ray_transform` and `pose_gradient` say the same by
/// themselves: through such an iterator the march took three times as long.
#[inline(always)]
pub(crate) fn slices(span: Span, within: Range<i32>) -> impl Iterator<Item = (i32, f64)> {
    // Not negative, so that cutting is rounding down.
    let first = ((span.enter + 0.5).max(0.0) as i32).max(within.start);
    (first..within.end)
        .map(move |slice| {
            let s = f64::from(slice);
            (slice, span.leave.min(s + 0.5) - span.enter.max(s - 0.5))
        })
        .take_while(|(_, length)| *length > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPAN: Span = Span { enter: 1.25, leave: 4.75 };

    #[test]
    fn slices_hold_the_span() {
        let all: Vec<_> = slices(SPAN, 0..10).collect();
        assert_eq!(all, [(1, 0.25), (2, 1.0), (3, 1.0), (4, 1.0), (5, 0.25)]);
        assert_eq!(slices(SPAN, 0..3).chain(slices(SPAN, 3..10)).collect::<Vec<_>>(), all);
        assert_eq!(slices(Span { enter: -0.5, leave: 0.5 }, 0..1).collect::<Vec<_>>(), [(0, 1.0)]);
    }
}
