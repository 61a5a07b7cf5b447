//! The caller's memory: arrays that are read, places that are written.

use std::ffi::{CStr, c_char};

use crate::allocation::collected;
use crate::error::{Error, Result};

/// Checks a pointer to `count` values of type `T`.
pub(super) fn check<T>(argument: &str, pointer: *const T, count: usize) -> Result<()> {
    if pointer.is_null() {
        let valid = if count == 1 { "a pointer".into() } else { format!("a pointer to {count} values") };
        return Err(Error::invalid(argument, "NULL", valid));
    }
    if !pointer.is_aligned() {
        let valid = format!("aligned to {} bytes", align_of::<T>());
        return Err(Error::invalid(argument, format!("{pointer:p}"), valid));
    }
    let bytes = count.checked_mul(size_of::<T>()).filter(|&bytes| isize::try_from(bytes).is_ok());
    if bytes.is_none() {
        return Err(Error::invalid(
            argument,
            format!("{count} values"),
            "an array that fits the address space",
        ));
    }
    Ok(())
}

/// As [`check`], of a pointer that may be null.
pub(super) fn check_optional<T>(argument: &str, pointer: *const T, count: usize) -> Result<()> {
    if pointer.is_null() { Ok(()) } else { check(argument, pointer, count) }
}

/// The caller's array.
///
/// # Safety
/// Unless it is null or misaligned, `pointer` points to `count` initialised values that nobody writes during `'a`.
pub(super) unsafe fn read_array<'a, T: Copy>(
    argument: &str,
    pointer: *const T,
    count: usize,
) -> Result<&'a [T]> {
    check(argument, pointer, count)?;
    // SAFETY: not null, aligned, at most isize::MAX bytes; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// The caller's array, or `None` for null.
///
/// # Safety
/// As for [`read_array`].
pub(super) unsafe fn read_optional<'a, T: Copy>(
    argument: &str,
    pointer: *const T,
    count: usize,
) -> Result<Option<&'a [T]>> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise is the same.
    unsafe { read_array(argument, pointer, count) }.map(Some)
}

/// The caller's mask: any byte but 0 is true. `None` for null.
///
/// # Safety
/// As for [`read_array`].
pub(super) unsafe fn read_mask(mask: *const u8, count: usize) -> Result<Option<Vec<bool>>> {
    // SAFETY: the caller's promise is the same.
    let mask = unsafe { read_optional("mask", mask, count)? };
    mask.map(|mask| collected(mask.iter().map(|&byte| byte != 0), "the mask")).transpose()
}

/// Copies `values` to the caller's place, which [`check`] has seen. Nothing is copied for null.
///
/// # Safety
/// Unless it is null, `place` is aligned and `values.len()` values can be written there.
pub(super) unsafe fn write_array<T: Copy>(place: *mut T, values: &[T]) {
    if !place.is_null() {
        // SAFETY: by the caller's promise; `values` is the library's own memory, which the caller's cannot overlap.
        unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), place, values.len()) };
    }
}

/// Copies planes to the caller's place, one after the other.
///
/// # Safety
/// As for [`write_array`], of all planes.
pub(super) unsafe fn write_planes<T: Copy>(mut place: *mut T, planes: &[Vec<T>]) {
    for plane in planes {
        // SAFETY: by the caller's promise there is room for this plane and those that follow; the end of the last one is not
        // written to.
        unsafe {
            write_array(place, plane);
            place = place.add(plane.len());
        }
    }
}

/// The caller's string.
///
/// # Safety
/// Unless it is null, `text` points to a string that ends in NUL and that nobody writes during `'a`.
pub(super) unsafe fn read_text<'a>(argument: &str, text: *const c_char) -> Result<&'a str> {
    check(argument, text, 1)?;
    // SAFETY: not null; the rest is the caller's promise.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| Error::invalid(argument, text.to_string_lossy(), "UTF-8"))
}
