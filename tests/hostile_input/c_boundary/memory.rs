//! What a caller passes pointers to.

use super::input::Input;

/// Finite and below every valid output, so that what is written shows.
const UNTOUCHED: f64 = -77_777.25;
/// Values before and after a place that must stay untouched in any case.
const MARGIN: usize = 4;

/// Array elements that can be marked.
pub(super) trait Element: Copy + PartialEq + Into<f64> {
    fn mark() -> Self;
}

impl Element for f32 {
    fn mark() -> Self {
        UNTOUCHED as f32
    }
}

impl Element for f64 {
    fn mark() -> Self {
        UNTOUCHED
    }
}

/// How a pointer is passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum How {
    Good,
    Null,
    Misaligned,
}

impl How {
    /// Good for most bytes, 0 among them.
    pub(super) fn of(input: &mut Input<'_>) -> Self {
        match input.byte() {
            ..240 => Self::Good,
            240..248 => Self::Null,
            248.. => Self::Misaligned,
        }
    }

    /// `pointer`, passed this way. One that is misaligned is refused before it is read, so its end does not matter.
    pub(super) fn pass<T>(self, pointer: *const T) -> *const T {
        match self {
            Self::Good => pointer,
            Self::Null => std::ptr::null(),
            Self::Misaligned => pointer.wrapping_byte_add(1),
        }
    }
}

/// An array that a call writes, with marks in and around it.
pub(super) struct Place<T> {
    how: How,
    values: Vec<T>,
}

impl<T: Element> Place<T> {
    pub(super) fn new(how: How, count: usize) -> Self {
        let count = if how == How::Null { 0 } else { count };
        Self { how, values: vec![T::mark(); count + 2 * MARGIN] }
    }

    pub(super) fn pointer(&mut self) -> *mut T {
        let place = self.values[MARGIN..].as_mut_ptr();
        self.how.pass(place.cast_const()).cast_mut()
    }

    /// The values, if the call was given a place for them.
    pub(super) fn written(&self) -> &[T] {
        let (before, rest) = self.values.split_at(MARGIN);
        let (values, after) = rest.split_at(rest.len() - MARGIN);
        let untouched = |values: &[T]| values.iter().all(|&value| value == T::mark());
        assert!(untouched(before) && untouched(after), "written outside an array");
        values
    }

    pub(super) fn assert_untouched(&self) {
        assert!(self.written().iter().all(|&value| value == T::mark()), "written by a call that failed");
    }
}
