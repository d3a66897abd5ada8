//! Memory that goes from one piece of parallel work to the next.

use std::fmt;
use std::sync::{Mutex, PoisonError};

/// An empty vector in the memory of another one, whose elements differ in nothing but lifetimes.
pub fn recycled<Old, New>(mut old: Vec<Old>) -> Vec<New> {
    old.clear();
    // Collecting a vector's own elements reuses its memory if they are as large.
    old.into_iter().map(|_| unreachable!("the vector is empty")).collect()
}

/// Scratch objects not in use. There are never more than threads that worked at once.
pub struct Pool<T>(Mutex<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

/// A copy has no memory yet.
impl<T> Clone for Pool<T> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<T> fmt::Debug for Pool<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Pool")
    }
}

impl<T> Pool<T> {
    /// Runs `work` with a scratch object, made by `make` if none is free.
    pub fn with<R>(&self, make: impl FnOnce() -> T, work: impl FnOnce(&mut T) -> R) -> R {
        // What a panicking thread had in its hands is not in the pool: the rest is sound.
        let free = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut scratch = free.unwrap_or_else(make);
        let result = work(&mut scratch);
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(scratch);
        result
    }
}
