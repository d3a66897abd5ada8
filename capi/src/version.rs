//! Version, and the vector instructions in use.

use std::ffi::{CStr, c_char};

use diffuse_contact_kernels::support::Isa;

use crate::border;
use crate::status::{DC_BAD_OPTION, DC_BAD_POINTER, Failure, dc_status};

/// The version of the library, such as "0.1.0". A constant text.
#[unsafe(no_mangle)]
pub extern "C" fn dc_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}

/// Chooses the vector instructions for the whole process: "scalar", "avx2", "avx512" or "neon". To be called before
/// the first evaluation; without it the widest are used that the machine has, or those that the environment variable
/// DIFFUSE_CONTACT_ISA names. Results with different instructions differ by rounding.
///
/// DC_BAD_OPTION if the machine does not have them, or others have been in use before.
///
/// # Safety
/// `name` is NULL or a text that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_set_isa(name: *const c_char) -> dc_status {
    border::call(|| {
        if name.is_null() {
            return Err(Failure::new(DC_BAD_POINTER, "bad-pointer: name is NULL"));
        }
        // SAFETY: of the caller; not NULL (above).
        let name = unsafe { CStr::from_ptr(name) }.to_string_lossy();
        let Some(isa) = Isa::named(&name) else {
            let known: Vec<&str> = Isa::available().map(Isa::name).collect();
            let message =
                format!("invalid-option: \"{name}\" is none of {}, which there are", known.join(", "));
            return Err(Failure::new(DC_BAD_OPTION, message));
        };
        isa.prefer().map_err(|used| {
            let message = format!("invalid-option: \"{used}\" is in use already, \"{name}\" comes too late");
            Failure::new(DC_BAD_OPTION, message)
        })
    })
}

/// The vector instructions in use, such as "avx2". A constant text.
#[unsafe(no_mangle)]
pub extern "C" fn dc_isa() -> *const c_char {
    let names = [c"scalar", c"avx2", c"avx512", c"neon"];
    let used = Isa::best().name();
    names.into_iter().find(|name| name.to_bytes() == used.as_bytes()).unwrap_or(c"unknown").as_ptr()
}
