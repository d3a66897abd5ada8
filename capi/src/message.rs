//! The sentence of the last failure, one per thread.

use std::cell::RefCell;
use std::ffi::{CString, c_char};

thread_local! {
    static MESSAGE: RefCell<CString> = RefCell::new(CString::default());
}

/// Replaces the thread's sentence.
pub fn set(text: &str) {
    // No text of ours has a zero byte; what a panic says may have one.
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    // While a thread ends there is no place for it any more.
    let _ = MESSAGE.try_with(|message| message.replace(text));
}

/// The thread's sentence.
pub fn pointer() -> *const c_char {
    MESSAGE.try_with(|message| message.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}
