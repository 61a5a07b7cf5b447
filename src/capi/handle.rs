//! Opaque handles: what a C program holds instead of a Rust value.

use std::ops::Deref;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};

/// An opaque type of the header, and what stands behind a pointer to it.
pub(super) trait Opaque {
    /// What the handle owns.
    type Value;
    /// The word at the handle's start by which it is known.
    const MAGIC: u64;
    /// The type's name in C.
    const NAME: &'static str;
}

#[repr(C)]
struct Handle<T> {
    magic: u64,
    /// Whether a call has panicked while it used the value.
    poisoned: AtomicBool,
    value: T,
}

/// What replaces the magic word of a destroyed handle.
const DESTROYED: u64 = u64::from_le_bytes(*b"drr dead");

/// Hands `value` to the caller.
pub(super) fn create<O: Opaque>(value: O::Value) -> *mut O {
    Box::into_raw(Box::new(Handle { magic: O::MAGIC, poisoned: AtomicBool::new(false), value })).cast()
}

/// The value behind a handle. A panic while it is borrowed poisons the handle, as it would a [`std::sync::Mutex`]:
/// a value that was in use when something impossible happened is not trusted again.
pub(super) struct Borrowed<'a, O: Opaque> {
    handle: &'a Handle<O::Value>,
    /// Whether the thread was unwinding already, for a reason that is not this call's.
    unwinding: bool,
}

impl<O: Opaque> Deref for Borrowed<'_, O> {
    type Target = O::Value;
    fn deref(&self) -> &O::Value {
        &self.handle.value
    }
}

impl<O: Opaque> Drop for Borrowed<'_, O> {
    fn drop(&mut self) {
        if std::thread::panicking() && !self.unwinding {
            self.handle.poisoned.store(true, Ordering::Relaxed);
        }
    }
}

/// The value behind a handle that is not poisoned.
///
/// # Safety
/// `handle` is null, or points to at least 8 readable bytes; if these are `O`'s magic word, the handle came from
/// [`create`] and is not destroyed during `'a`.
pub(super) unsafe fn borrow<'a, O: Opaque>(argument: &str, handle: *const O) -> Result<Borrowed<'a, O>> {
    // SAFETY: the caller's promise is the same.
    let borrowed = unsafe { borrow_even_poisoned(argument, handle)? };
    if borrowed.handle.poisoned.load(Ordering::Relaxed) {
        return Err(Error::Poisoned { argument: argument.to_owned() });
    }
    Ok(borrowed)
}

/// The value behind a handle, for what no panic can have spoilt.
///
/// # Safety
/// As for [`borrow`].
pub(super) unsafe fn borrow_even_poisoned<'a, O: Opaque>(
    argument: &str,
    handle: *const O,
) -> Result<Borrowed<'a, O>> {
    let handle = handle.cast::<Handle<O::Value>>();
    // SAFETY: the caller's promise is `check`'s.
    unsafe { check::<O>(argument, handle)? };
    // SAFETY: `check` found the magic word, so this is a live handle; only the atomic in it is ever written.
    Ok(Borrowed { handle: unsafe { &*handle }, unwinding: std::thread::panicking() })
}

/// Takes a handle back and drops its value. Nothing happens for null.
///
/// # Safety
/// As for [`borrow`]; and no other call uses the handle now or later.
pub(super) unsafe fn destroy<O: Opaque>(argument: &str, handle: *mut O) -> Result<()> {
    if handle.is_null() {
        return Ok(());
    }
    let handle = handle.cast::<Handle<O::Value>>();
    // SAFETY: the caller's promise is `check`'s.
    unsafe { check::<O>(argument, handle)? };
    // SAFETY: a live handle, whose box was given up by `create` and which nobody else uses. The write is volatile
    // because it is meant to be seen after the memory is freed.
    unsafe {
        std::ptr::write_volatile(&raw mut (*handle).magic, DESTROYED);
        drop(Box::from_raw(handle));
    }
    Ok(())
}

/// Whether `handle` looks like a live handle of type `O`. Finds null, another type's handle and, as long as its
/// memory has not been used again, a destroyed one.
///
/// # Safety
/// `handle` is null or misaligned, or 8 bytes can be read there.
unsafe fn check<O: Opaque>(argument: &str, handle: *const Handle<O::Value>) -> Result<()> {
    let valid = || format!("a {} that has not been destroyed", O::NAME);
    if handle.is_null() {
        return Err(Error::invalid(argument, "NULL", valid()));
    }
    if !handle.is_aligned() {
        return Err(Error::invalid(argument, format!("{handle:p}, misaligned"), valid()));
    }
    // SAFETY: not null, aligned, and readable by the caller's promise. Volatile: the memory may be a dead handle's.
    let magic = unsafe { std::ptr::read_volatile(&raw const (*handle).magic) };
    if magic != O::MAGIC {
        let found = if magic == DESTROYED { "a destroyed handle" } else { "no such handle" };
        return Err(Error::invalid(argument, found, valid()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::capi::boundary::guard;
    use crate::capi::status::{self, DRR_STATUS_INTERNAL, DRR_STATUS_OK};

    struct One;
    struct Two;

    impl Opaque for One {
        type Value = Arc<i32>;
        const MAGIC: u64 = 1;
        const NAME: &'static str = "One";
    }

    impl Opaque for Two {
        type Value = Arc<i32>;
        const MAGIC: u64 = 2;
        const NAME: &'static str = "Two";
    }

    #[test]
    fn a_handle_owns_its_value_and_knows_its_type() {
        let value = Arc::new(5);
        let one = create::<One>(value.clone());
        assert_eq!(Arc::strong_count(&value), 2);
        // SAFETY: `one` is live, and 8 bytes can be read at `one` as any type.
        unsafe {
            assert_eq!(**borrow("one", one).expect("live"), 5);
            let error = borrow::<Two>("two", one.cast()).err().expect("another type");
            assert_eq!(error.to_string(), "two is no such handle; valid: a Two that has not been destroyed");
            assert!(destroy::<Two>("two", one.cast()).is_err());
            assert!(borrow::<One>("one", one.cast::<u8>().add(4).cast()).is_err(), "misaligned");
        }
        assert_eq!(Arc::strong_count(&value), 2, "a refused destroy drops nothing");
        // SAFETY: `one` is live and not used again; null may be destroyed.
        unsafe {
            destroy("one", one).expect("live");
            destroy::<One>("one", std::ptr::null_mut()).expect("nothing to do");
            assert!(borrow::<One>("one", std::ptr::null()).is_err());
        }
        assert_eq!(Arc::strong_count(&value), 1);
    }

    /// Uses a handle in its destructor.
    struct Calls(*const One);

    impl Drop for Calls {
        fn drop(&mut self) {
            // SAFETY: the handle outlives this value.
            assert_eq!(guard(|| unsafe { borrow("unused", self.0) }.map(drop)), DRR_STATUS_OK);
        }
    }

    #[test]
    fn a_panic_poisons_what_it_had_borrowed_and_nothing_else() {
        let value = Arc::new(5);
        let (used, unused) = (create::<One>(value.clone()), create::<One>(value.clone()));
        // SAFETY: both handles are live until they are destroyed, once each, at the end.
        unsafe {
            let panics = || -> Result<()> {
                let _used = borrow("used", used)?;
                panic!("a defect");
            };
            assert_eq!(guard(panics), DRR_STATUS_INTERNAL);
            let error = borrow("used", used).err().expect("poisoned");
            assert_eq!(status::of(&error), DRR_STATUS_INTERNAL);
            assert!(error.to_string().starts_with("used is poisoned: "), "{error}");
            assert_eq!(**borrow_even_poisoned("used", used).expect("live"), 5);
            assert_eq!(**borrow("unused", unused).expect("not poisoned"), 5);

            // A thread that unwinds already is not what panicked.
            let unwinds = || -> Result<()> {
                let _calls = Calls(unused);
                panic!("elsewhere");
            };
            assert_eq!(guard(unwinds), DRR_STATUS_INTERNAL);
            assert!(borrow("unused", unused).is_ok());

            destroy("used", used).expect("a poisoned handle can be destroyed");
            destroy("unused", unused).expect("live");
        }
        assert_eq!(Arc::strong_count(&value), 1);
    }
}
