//! Which handles are live. A handle is a number, not an address: nothing is found at it.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock, TryLockError};

use crate::border;
use crate::status::{DC_BAD_HANDLE, DC_BUSY, DC_INTERNAL, DC_TOO_LARGE, Failure, dc_status};

/// Bits that no address of a program has, where pointers have 64 bits: neither a pointer nor a small number is
/// taken for a handle.
#[cfg(target_pointer_width = "64")]
const MARK: usize = 0x5dc1 << 48;
#[cfg(not(target_pointer_width = "64"))]
const MARK: usize = 0;
/// Handles are even numbers apart, so that one that is off by little is none.
const STRIDE: usize = 16;

/// A live object; `None` once it is destroyed, for a thread that found it just before.
type Entry<T> = Arc<Mutex<Option<T>>>;

/// The live objects of one kind.
#[derive(Debug)]
pub struct Registry<T> {
    /// What they are called in messages.
    what: &'static str,
    /// Objects of different kinds have different remainders by the stride.
    kind: usize,
    made: AtomicUsize,
    live: RwLock<BTreeMap<usize, Entry<T>>>,
}

impl<T> Registry<T> {
    /// `kind` is a number below 16 that no other registry has.
    pub const fn new(what: &'static str, kind: usize) -> Self {
        Self { what, kind, made: AtomicUsize::new(0), live: RwLock::new(BTreeMap::new()) }
    }

    /// The handle of a new object: one that has never been given out before.
    pub fn insert(&self, object: T) -> Result<usize, Failure> {
        let number = self.made.fetch_add(1, Ordering::Relaxed) + 1;
        let too_many =
            || Failure::new(DC_TOO_LARGE, format!("too-many: no handle left for the {}", self.what));
        let handle = number.checked_mul(STRIDE).filter(|&x| x & MARK == 0).ok_or_else(too_many)?;
        let handle = MARK | handle | self.kind;
        let mut live = self.live.write().unwrap_or_else(PoisonError::into_inner);
        live.insert(handle, Arc::new(Mutex::new(Some(object))));
        Ok(handle)
    }

    fn find(&self, handle: usize) -> Result<Entry<T>, Failure> {
        let live = self.live.read().unwrap_or_else(PoisonError::into_inner);
        live.get(&handle).map(Arc::clone).ok_or_else(|| self.unknown(handle))
    }

    fn unknown(&self, handle: usize) -> Failure {
        let what = self.what;
        let message = if handle == 0 {
            format!("bad-handle: the handle of the {what} is NULL")
        } else {
            format!("bad-handle: {handle:#x} is no live {what}: never made, or destroyed")
        };
        Failure::new(DC_BAD_HANDLE, message)
    }

    /// Works with the object, if no other thread does.
    pub fn with<R>(
        &self,
        handle: usize,
        work: impl FnOnce(&mut T) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        let entry = self.find(handle)?;
        let mut object = match entry.try_lock() {
            Ok(object) => object,
            Err(TryLockError::WouldBlock) => return Err(self.busy()),
            Err(TryLockError::Poisoned(_)) => {
                let message = format!(
                    "internal: an earlier call failed inside; the {} can only be destroyed",
                    self.what
                );
                return Err(Failure::new(DC_INTERNAL, message));
            }
        };
        work(object.as_mut().ok_or_else(|| self.unknown(handle))?)
    }

    /// A call that works with the object of a handle.
    pub fn call<H>(&self, handle: *mut H, work: impl FnOnce(&mut T) -> Result<(), Failure>) -> dc_status {
        border::call(|| self.with(handle.addr(), work))
    }

    fn busy(&self) -> Failure {
        Failure::new(DC_BUSY, format!("busy: another thread is in a call with this {}", self.what))
    }

    /// A call that destroys the object of a handle; of NULL there is none to destroy.
    pub fn destroy<H>(&self, handle: *mut H) -> dc_status {
        border::call(|| if handle.is_null() { Ok(()) } else { self.remove(handle.addr()) })
    }

    /// Destroys the object, if no other thread works with it.
    fn remove(&self, handle: usize) -> Result<(), Failure> {
        let entry = self.find(handle)?;
        let object = match entry.try_lock() {
            Ok(mut object) => object.take(),
            Err(TryLockError::Poisoned(object)) => object.into_inner().take(),
            Err(TryLockError::WouldBlock) => return Err(self.busy()),
        };
        let mut live = self.live.write().unwrap_or_else(PoisonError::into_inner);
        live.remove(&handle);
        drop(live);
        object.map(drop).ok_or_else(|| self.unknown(handle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_handle_is_good_for_one_object_while_it_lives() {
        let registry = Registry::new("number", 1);
        let (first, second) = (registry.insert(7).unwrap(), registry.insert(8).unwrap());
        assert_eq!(registry.with(first, |x| Ok(*x)), Ok(7));
        registry.remove(first).unwrap();
        assert_eq!(registry.remove(first).unwrap_err().status, DC_BAD_HANDLE);
        assert_eq!(registry.with(first, |x| Ok(*x)).unwrap_err().status, DC_BAD_HANDLE);
        // Memory may be used again, the number is not.
        assert_ne!(registry.insert(9).unwrap(), first);
        assert_eq!(registry.with(second, |x| Ok(*x)), Ok(8));
        for garbage in [0, 1, second + 1, second ^ STRIDE << 20, std::ptr::from_ref(&registry) as usize] {
            assert_eq!(registry.with(garbage, |x| Ok(*x)).unwrap_err().status, DC_BAD_HANDLE);
        }
    }

    #[test]
    fn an_object_at_work_is_busy_and_one_that_broke_can_be_destroyed() {
        let registry = Registry::new("number", 1);
        let handle = registry.insert(7).unwrap();
        let inside = registry.with(handle, |_| {
            assert_eq!(registry.remove(handle).unwrap_err().status, DC_BUSY);
            registry.with(handle, |x| Ok(*x))
        });
        assert_eq!(inside.unwrap_err().status, DC_BUSY);
        let broken = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            registry.with(handle, |_| -> Result<(), Failure> { panic!("on purpose") })
        }));
        assert!(broken.is_err());
        assert_eq!(registry.with(handle, |x| Ok(*x)).unwrap_err().status, DC_INTERNAL);
        registry.remove(handle).unwrap();
        assert_eq!(registry.with(handle, |x| Ok(*x)).unwrap_err().status, DC_BAD_HANDLE);
    }
}
