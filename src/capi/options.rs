//! Structs that may grow: they start with their size, and an initialiser fills them.
//!
//! A program finds the initialiser that knows its struct by name: when a struct grows, the new header says
//! `#define drr_x_init drr_x_init_2`, and the symbol `drr_x_init` goes on filling the old struct.

use crate::capi::memory;
use crate::error::{Error, Result};

/// A struct that may grow by fields at its end.
///
/// # Safety
/// `#[repr(C)]`, without padding, begins with `struct_size: usize`, and any initialised bytes are a value: the fields
/// are numbers, raw pointers, and `Option`s of function pointers. Of the last, null is `None`, and what others point to
/// is a promise to whoever calls them, not to whoever reads the struct.
pub(super) unsafe trait Options: Copy {
    /// The struct's size in each version of the header, ascending; the last is today's.
    const SIZES: &'static [usize];
    /// The defaults, with today's size.
    fn defaults() -> Self;
}

/// Fills the caller's struct with defaults.
///
/// # Safety
/// Unless it is null or misaligned, `place` can be written.
pub(super) unsafe fn init<T: Options>(argument: &str, place: *mut T) -> Result<()> {
    memory::check(argument, place, 1)?;
    // SAFETY: not null, aligned, and writable by the caller's promise.
    unsafe { place.write(T::defaults()) };
    Ok(())
}

/// The caller's struct; the fields that an older header does not have get their defaults.
///
/// # Safety
/// Unless it is null or misaligned, `place` points to a `struct_size` and as many initialised bytes as it says.
pub(super) unsafe fn read<T: Options>(argument: &str, place: *const T) -> Result<T> {
    memory::check(argument, place, 1)?;
    // SAFETY: not null, aligned; `T` begins with a `usize`.
    let struct_size = unsafe { place.cast::<usize>().read() };
    check_size::<T>(&format!("{argument}.struct_size"), struct_size)?;
    let mut value = T::defaults();
    // SAFETY: at most `size_of::<T>()` bytes, initialised by the caller's promise; any bytes make a `T`.
    unsafe {
        std::ptr::copy_nonoverlapping(place.cast::<u8>(), (&raw mut value).cast::<u8>(), struct_size);
    }
    Ok(value)
}

fn check_size<T: Options>(argument: &str, struct_size: usize) -> Result<()> {
    if T::SIZES.contains(&struct_size) {
        return Ok(());
    }
    let known: Vec<_> = T::SIZES.iter().map(ToString::to_string).collect();
    let valid = format!("{}, as set by the struct's init function", known.join(" or "));
    Err(Error::invalid(argument, struct_size, valid))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Clone, Copy, PartialEq)]
    #[repr(C)]
    struct Grown {
        struct_size: usize,
        old: u64,
        new: u64,
    }

    // SAFETY: repr(C), no padding, starts with its size, integers only.
    unsafe impl Options for Grown {
        const SIZES: &'static [usize] = &[16, 24];
        fn defaults() -> Self {
            Self { struct_size: 24, old: 1, new: 2 }
        }
    }

    #[test]
    fn an_older_struct_is_not_read_past_its_end() {
        let mut place = Grown { struct_size: 0, old: 77, new: 88 };
        // SAFETY: 24 bytes are there, initialised, of which 16 are claimed.
        unsafe {
            place.struct_size = 16;
            assert_eq!(read("place", &raw const place), Ok(Grown { struct_size: 16, old: 77, new: 2 }));
            init("place", &raw mut place).expect("a good place");
            assert_eq!(place, Grown { struct_size: 24, old: 1, new: 2 });
            for size in [0, 8, 20, 32, usize::MAX] {
                place.struct_size = size;
                let error = read("place", &raw const place).expect_err("an unknown size").to_string();
                assert!(error.starts_with("place.struct_size is ") && error.contains("16 or 24"), "{error}");
            }
            assert!(init("place", std::ptr::null_mut::<Grown>()).is_err());
            assert!(read("place", std::ptr::null::<Grown>()).is_err());
        }
    }
}
