//! Between C and Rust: pointers become slices, and panics a status.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::message;
use crate::status::{
    DC_BAD_OPTION, DC_BAD_POINTER, DC_BAD_SIZE, DC_INTERNAL, DC_OK, DC_TOO_LARGE, Failure, dc_status,
};

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

/// Types of C of which any bits are a value, zeros among them.
///
/// # Safety
/// No padding that is read, no pointer that is followed, no bits that are invalid.
pub unsafe trait Plain: Copy {}

// SAFETY: numbers.
unsafe impl Plain for f64 {}
unsafe impl Plain for i32 {}
unsafe impl Plain for i64 {}
unsafe impl Plain for usize {}
// SAFETY: a handle is a number, which nobody follows.
unsafe impl<T> Plain for *mut T {}

#[inline]
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

/// Where an array of the caller lies.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    name: &'static str,
    start: usize,
    end: usize,
    is_written: bool,
}

impl Span {
    /// Whether it is the same array, empty ones aside.
    pub fn is_same(&self, other: &Self) -> bool {
        (self.start, self.end) == (other.start, other.end)
    }
}

/// An array that is read.
#[inline]
pub fn read<T>(name: &'static str, pointer: *const T, count: usize) -> Span {
    let start = pointer.addr();
    let bytes = if pointer.is_null() { 0 } else { count.saturating_mul(size_of::<T>()) };
    Span { name, start, end: start.saturating_add(bytes), is_written: false }
}

/// An array that is read and added to.
#[inline]
pub fn written<T>(name: &'static str, pointer: *const T, count: usize) -> Span {
    Span { is_written: true, ..read(name, pointer, count) }
}

/// Refuses arrays of which one is written and another lies in the same place.
#[inline]
pub fn disjoint<const N: usize>(spans: [Span; N]) -> Result<(), Failure> {
    for (k, one) in spans.iter().enumerate() {
        for other in &spans[..k] {
            // Empty ones lie nowhere.
            let first = one.start.max(other.start);
            let overlaps = first < one.end && first < other.end;
            if overlaps && (one.is_written || other.is_written) {
                return Err(overlapping(other.name, one.name));
            }
        }
    }
    Ok(())
}

#[cold]
fn overlapping(one: &str, other: &str) -> Failure {
    Failure::new(DC_BAD_POINTER, format!("bad-pointer: {one} and {other} overlap"))
}

/// An array of the caller; NULL if it is empty.
///
/// # Safety
/// `pointer` is NULL, or `count` entries may be read there until the call returns, which nobody writes.
#[inline]
pub unsafe fn input<'a, T: Plain>(name: &str, pointer: *const T, count: usize) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    check(name, pointer, count)?;
    // SAFETY: of the caller; not NULL, aligned and not too long (above).
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// An array of the caller that is added to; NULL if it is empty.
///
/// # Safety
/// `pointer` is NULL, or `count` numbers are there until the call returns, which nobody else looks at.
pub unsafe fn sums<'a, T: Plain>(name: &str, pointer: *mut T, count: usize) -> Result<&'a mut [T], Failure> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(name, pointer, count)?;
    // SAFETY: of the caller; not NULL, aligned, not too long (above), and it holds numbers.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// A place of the caller that is to be filled. It is checked, but neither read nor written yet: what is there need not be a value, and
/// stays if the call is refused.
#[derive(Debug)]
pub struct Target<T> {
    name: &'static str,
    pointer: *mut T,
    count: usize,
}

/// A place for `count` entries; NULL if there are none.
#[inline]
pub fn target<T: Plain>(name: &'static str, pointer: *mut T, count: usize) -> Result<Target<T>, Failure> {
    if count > 0 {
        check(name, pointer, count)?;
    }
    Ok(Target { name, pointer, count })
}

/// A place for `needed` entries, of which the caller says that it has room for `room`.
#[inline]
pub fn roomy<T: Plain>(
    name: &'static str,
    pointer: *mut T,
    room: usize,
    needed: usize,
) -> Result<Target<T>, Failure> {
    if room < needed {
        let message = format!("bad-size: {name} has room for {room} numbers, needs {needed}");
        return Err(Failure::new(DC_BAD_SIZE, message));
    }
    target(name, pointer, needed)
}

/// As [`roomy`]; NULL, and then without entries, where the caller does not want it.
#[inline]
pub fn wanted<T: Plain>(
    name: &'static str,
    pointer: *mut T,
    room: usize,
    needed: usize,
) -> Result<Target<T>, Failure> {
    if pointer.is_null() { target(name, pointer, 0) } else { roomy(name, pointer, room, needed) }
}

impl<T: Plain> Target<T> {
    #[inline]
    pub fn span(&self) -> Span {
        written(self.name, self.pointer, self.count)
    }

    /// Number of entries; 0 where it is not wanted.
    pub const fn len(&self) -> usize {
        self.count
    }

    /// The entries, set to zero first.
    ///
    /// # Safety
    /// The entries may be written until the call returns, and nobody else looks at them.
    pub unsafe fn zeroed<'a>(self) -> &'a mut [T] {
        if self.count > 0 {
            // SAFETY: of the caller; not NULL, aligned and not too long (when it was made).
            unsafe { self.pointer.write_bytes(0, self.count) };
        }
        // SAFETY: as the caller promises; zeros are a value of plain types.
        unsafe { self.slice() }
    }

    /// The entries with the bits that are there. To set a Hessian to zero first takes a tenth of the time of computing it.
    ///
    /// # Safety
    /// As [`zeroed`](Self::zeroed).
    #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
    #[inline]
    pub unsafe fn unspecified<'a>(self) -> &'a mut [T] {
        // There may have been no value before, and a slice has to have some. Any bits are one. For the compiler the instructions below,
        // of which there are none, write some at the pointer: it may not look into them, and must take them to.
        // SAFETY: no instruction.
        unsafe { std::arch::asm!("/* {0} */", in(reg) self.pointer, options(nostack, preserves_flags)) };
        // SAFETY: as the caller promises; the entries hold some bits.
        unsafe { self.slice() }
    }

    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    pub unsafe fn unspecified<'a>(self) -> &'a mut [T] {
        unsafe { self.zeroed() }
    }

    /// # Safety
    /// As [`zeroed`](Self::zeroed), and the entries hold values.
    #[inline]
    unsafe fn slice<'a>(self) -> &'a mut [T] {
        if self.count == 0 {
            return &mut [];
        }
        // SAFETY: of the caller; not NULL, aligned and not too long (when it was made).
        unsafe { std::slice::from_raw_parts_mut(self.pointer, self.count) }
    }

    /// Writes the first values, as many as there are entries.
    ///
    /// # Safety
    /// As [`zeroed`](Self::zeroed).
    #[inline]
    pub unsafe fn write(self, values: impl IntoIterator<Item = T>) {
        for (k, value) in values.into_iter().take(self.count).enumerate() {
            // SAFETY: of the caller; within the entries.
            unsafe { self.pointer.add(k).write(value) };
        }
    }
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

/// A structure of zeros, NULL where it has pointers.
pub const fn zeros<T: Versioned>() -> T {
    // SAFETY: any bits are a `T`.
    unsafe { std::mem::zeroed() }
}

#[cold]
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
#[inline]
pub unsafe fn read_sized<T: Versioned>(
    pointer: *const T,
    defaults: impl FnOnce() -> T,
) -> Result<T, Failure> {
    check(T::NAME, pointer, 1)?;
    // SAFETY: of the caller; the first field is the size.
    let size = unsafe { pointer.cast::<usize>().read() };
    if size == size_of::<T>() {
        // SAFETY: all of it is there, aligned (above), and any bits are a `T`.
        return Ok(unsafe { pointer.read() });
    }
    let size = known_size::<T>(size)?;
    let mut value = defaults();
    let target = std::ptr::from_mut(&mut value).cast::<u8>();
    // SAFETY: `size` bytes are there on both sides (above), and any bits are a `T`.
    unsafe { std::ptr::copy_nonoverlapping(pointer.cast::<u8>(), target, size) };
    Ok(value)
}

/// A structure of the caller that is to be filled as far as it knows it. Only its size has been read.
#[derive(Debug)]
pub struct SizedTarget<T> {
    pointer: *mut T,
    size: usize,
}

/// A place for a structure.
///
/// # Safety
/// `pointer` is NULL, or a size may be read there.
pub unsafe fn sized_target<T: Versioned>(pointer: *mut T) -> Result<SizedTarget<T>, Failure> {
    check(T::NAME, pointer, 1)?;
    // SAFETY: of the caller; the first field is the size.
    let size = known_size::<T>(unsafe { pointer.cast::<usize>().read() })?;
    Ok(SizedTarget { pointer, size })
}

impl<T: Versioned> SizedTarget<T> {
    pub fn span(&self) -> Span {
        written(T::NAME, self.pointer.cast::<u8>(), self.size)
    }

    /// Writes the fields that the caller knows; its `size` stays.
    ///
    /// # Safety
    /// As many bytes as its size may be written.
    pub unsafe fn write(self, value: &T) {
        let (skip, source) = (size_of::<usize>(), std::ptr::from_ref(value).cast::<u8>());
        let (target, size) = (self.pointer.cast::<u8>(), self.size);
        // SAFETY: `size` bytes are there on both sides, the caller's by its promise; any bits of `T` are valid.
        unsafe { std::ptr::copy_nonoverlapping(source.add(skip), target.add(skip), size - skip) };
    }
}

/// A report of the caller, NULL if it is not wanted, beside the positions that it is of.
///
/// # Safety
/// As [`sized_target`].
pub unsafe fn wanted_report<T: Versioned>(
    report: *mut T,
    positions: &[[f64; 3]],
) -> Result<Option<SizedTarget<T>>, Failure> {
    if report.is_null() {
        return Ok(None);
    }
    let report = unsafe { sized_target(report)? };
    disjoint([read("positions", positions.as_ptr(), positions.len()), report.span()])?;
    Ok(Some(report))
}

/// Writes the handle of a new object; NULL where it cannot be made.
///
/// # Safety
/// `handle` is NULL or may be written.
pub unsafe fn hand_out<T>(
    name: &'static str,
    handle: *mut *mut T,
    make: impl FnOnce() -> Result<usize, Failure>,
) -> Result<(), Failure> {
    unsafe { target(name, handle, 1)?.write([std::ptr::null_mut()]) };
    let made = make()?;
    unsafe { target(name, handle, 1)?.write([std::ptr::without_provenance_mut(made)]) };
    Ok(())
}

/// Room for `count` entries.
pub fn reserve<T>(what: &str, count: usize) -> Result<Vec<T>, Failure> {
    let mut vector = Vec::new();
    vector
        .try_reserve_exact(count)
        .map_err(|_| Failure::new(DC_TOO_LARGE, format!("out-of-memory: no room for {count} {what}")))?;
    Ok(vector)
}

/// A field that is to be 0 until a later version gives it a meaning.
#[inline]
pub fn reserved(structure: &str, value: i32) -> Result<(), Failure> {
    if value == 0 {
        return Ok(());
    }
    let message = format!("invalid-option: {structure}.reserved is {value}, but must be 0");
    Err(Failure::new(DC_BAD_OPTION, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_in_one_place_are_refused_if_one_is_written() {
        let mut numbers = [0.0_f64; 6];
        let pointer = numbers.as_mut_ptr();
        let at = |k| pointer.wrapping_add(k);
        assert!(disjoint([read("a", at(0), 4), read("b", at(2), 4)]).is_ok(), "both are read");
        assert!(disjoint([written("a", at(0), 3), written("b", at(3), 3)]).is_ok());
        assert!(disjoint([written("a", at(1), 0), written("b", at(0), 6)]).is_ok(), "empty");
        assert!(disjoint([written("a", std::ptr::null::<f64>(), 6), written("b", at(0), 6)]).is_ok());
        let failure = disjoint([read("a", at(0), 4), written("b", at(3), 1)]).unwrap_err();
        assert_eq!(failure, Failure::new(DC_BAD_POINTER, "bad-pointer: a and b overlap"));
        assert!(disjoint([written("a", at(0), usize::MAX), read("b", at(5), 1)]).is_err());
    }

    #[test]
    fn what_there_is_no_room_for_is_told() {
        let failure = reserve::<f64>("numbers", usize::MAX / 16).unwrap_err();
        assert_eq!(failure.status, DC_TOO_LARGE);
    }
}
