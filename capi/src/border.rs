//! Between C and Rust: pointers become slices, and panics a status.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::message;
use crate::status::{DC_BAD_POINTER, DC_BAD_SIZE, DC_INTERNAL, DC_OK, Failure, dc_status};

/// Runs a call. What it says on failure is the thread's message.
pub fn call(work: impl FnOnce() -> Result<(), Failure>) -> dc_status {
    // What a panic leaves half done is behind a lock that is poisoned then.
    let result = catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|payload| Err(Failure::new(DC_INTERNAL, format!("internal: {}", said(&*payload)))));
    match result {
        Ok(()) => DC_OK,
        Err(Failure { status, message }) => {
            message::set(&message);
            status
        }
    }
}

/// What a panic said.
fn said(payload: &(dyn Any + Send)) -> &str {
    let owned = payload.downcast_ref::<String>().map(String::as_str);
    owned.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("a panic without words")
}

/// Types of C of which any bits are a value.
///
/// # Safety
/// No padding that is read, no pointer that is followed, no bits that are invalid.
pub unsafe trait Plain: Copy {}

// SAFETY: numbers.
unsafe impl Plain for f64 {}
unsafe impl Plain for i32 {}
unsafe impl Plain for usize {}
// SAFETY: a structure of numbers, no padding.
unsafe impl Plain for crate::element::dc_point {}

fn check<T>(name: &str, pointer: *const T, count: usize) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::new(DC_BAD_POINTER, format!("bad-pointer: {name} is NULL")));
    }
    if !pointer.is_aligned() {
        let message = format!("bad-pointer: {name} is not aligned to {} bytes", align_of::<T>());
        return Err(Failure::new(DC_BAD_POINTER, message));
    }
    if count > isize::MAX as usize / size_of::<T>().max(1) {
        let message = format!("bad-size: {name} cannot have {count} entries");
        return Err(Failure::new(DC_BAD_SIZE, message));
    }
    Ok(())
}

/// An array of the caller; NULL if it is empty.
///
/// # Safety
/// `pointer` is NULL, or `count` entries may be read there until the call returns, which nobody writes.
pub unsafe fn input<'a, T: Plain>(name: &str, pointer: *const T, count: usize) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    check(name, pointer, count)?;
    // SAFETY: of the caller; not NULL, aligned and not too long (above).
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// An array of the caller to be filled.
///
/// # Safety
/// `pointer` is NULL, or `count` entries may be written there until the call returns, which nobody else looks at.
pub unsafe fn output<'a, T: Plain>(
    name: &str,
    pointer: *mut T,
    count: usize,
) -> Result<&'a mut [T], Failure> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(name, pointer, count)?;
    // SAFETY: of the caller; not NULL, aligned and not too long (above).
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// As [`output`], of which the first `needed` entries are to be filled; NULL, and so `None`, where the caller does not want it.
///
/// # Safety
/// As [`output`].
pub unsafe fn wanted<'a, T: Plain>(
    name: &str,
    pointer: *mut T,
    count: usize,
    needed: usize,
) -> Result<Option<&'a mut [T]>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    if count < needed {
        let message = format!("bad-size: {name} has room for {count} numbers, needs {needed}");
        return Err(Failure::new(DC_BAD_SIZE, message));
    }
    // SAFETY: as the caller promises.
    Ok(Some(unsafe { output(name, pointer, needed)? }))
}

/// One value to be written.
///
/// # Safety
/// `pointer` is NULL, or a `T` may be written there until the call returns.
pub unsafe fn single<'a, T>(name: &str, pointer: *mut T) -> Result<&'a mut T, Failure> {
    check(name, pointer, 1)?;
    // SAFETY: of the caller; not NULL and aligned (above).
    Ok(unsafe { &mut *pointer })
}

/// A structure that opens with `size`, its length in bytes as the caller knows it.
///
/// # Safety
/// Repr C, the first field a `usize`, any bits valid.
pub unsafe trait Versioned: Copy {
    /// Its name in C.
    const NAME: &'static str;
    /// Its length in the first version of the library: up to the end of the field that was the last then.
    const FIRST: usize;
}

fn known_size<T: Versioned>(size: usize) -> Result<usize, Failure> {
    if (T::FIRST..=size_of::<T>()).contains(&size) && size.is_multiple_of(align_of::<T>()) {
        return Ok(size);
    }
    let message = format!(
        "bad-size: the field size of {} is {size}; set it to sizeof({0}), from {} to {} here",
        T::NAME,
        T::FIRST,
        size_of::<T>()
    );
    Err(Failure::new(DC_BAD_SIZE, message))
}

/// A structure of the caller, `defaults` in the fields that it does not know.
///
/// # Safety
/// `pointer` is NULL, or as many bytes as its first field says may be read there.
pub unsafe fn read_sized<T: Versioned>(pointer: *const T, defaults: T) -> Result<T, Failure> {
    check(T::NAME, pointer, 1)?;
    // SAFETY: of the caller; the first field is the size.
    let size = known_size::<T>(unsafe { pointer.cast::<usize>().read() })?;
    let mut value = defaults;
    let target = std::ptr::from_mut(&mut value).cast::<u8>();
    // SAFETY: `size` bytes are there on both sides (above), and any bits are a `T`.
    unsafe { std::ptr::copy_nonoverlapping(pointer.cast::<u8>(), target, size) };
    Ok(value)
}

/// Fills a structure of the caller as far as it knows it; its `size` stays.
///
/// # Safety
/// `pointer` is NULL, or as many bytes as its first field says may be read and written there.
pub unsafe fn write_sized<T: Versioned>(pointer: *mut T, value: &T) -> Result<(), Failure> {
    check(T::NAME, pointer, 1)?;
    // SAFETY: of the caller; the first field is the size.
    let size = known_size::<T>(unsafe { pointer.cast::<usize>().read() })?;
    let (skip, source) = (size_of::<usize>(), std::ptr::from_ref(value).cast::<u8>());
    // SAFETY: `size` bytes are there on both sides (above).
    unsafe { std::ptr::copy_nonoverlapping(source.add(skip), pointer.cast::<u8>().add(skip), size - skip) };
    Ok(())
}
