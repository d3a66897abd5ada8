//! What a call returns.

use runtime::ElementError;
use runtime::assembly::AssemblyError;
use runtime::friction::FrictionError;
use runtime::interface::InterfaceError;
use runtime::neighbourhood::NeighbourhoodError;
use runtime::surface::{SurfaceError, WindowError};

use crate::message;

/// What became of a call. Everything but DC_OK, DC_FROZEN and DC_NO_CONTACT is for the caller to mend; unless the call says otherwise,
/// nothing has changed then, neither behind the handle nor in the caller's arrays. dc_message() is the sentence to it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum dc_status {
    /// Done.
    DC_OK = 0,
    /// dc_refresh or dc_follow of a frozen interface: the positions were taken over, the pairing was left as it is.
    DC_FROZEN = 1,
    /// The element has no result; the outcome and the message say why. Not an error of the call.
    DC_NO_CONTACT = 2,
    /// A pointer is NULL or not aligned, or two arrays overlap of which one is written.
    DC_BAD_POINTER = 3,
    /// An array is too short, a count is not the one of the interface, or the field `size` of a structure is not that of
    /// any version of it.
    DC_BAD_SIZE = 4,
    /// The handle is not one of a live object: never made, or destroyed.
    DC_BAD_HANDLE = 5,
    /// Another thread is in a call with this handle.
    DC_BUSY = 6,
    /// An option or another number is out of its range, or none of the named ones.
    DC_BAD_OPTION = 7,
    /// A position, a gap or another input is NaN, infinite or beyond 1e75.
    DC_NOT_FINITE = 8,
    /// An index of a node or a slave is out of range.
    DC_OUT_OF_RANGE = 9,
    /// The facets are no surface: a facet with equal nodes or without area, an edge with three facets, ...
    DC_BAD_SURFACE = 10,
    /// A slave is listed twice, lies on the master, or has no slave facet although areas are asked for.
    DC_BAD_SLAVES = 11,
    /// There is no pairing yet, or no evaluation at the positions and for the pairing of the moment, or one with too few derivatives.
    DC_NOT_EVALUATED = 12,
    /// The pattern belongs to another pairing or to other equations: make a new one.
    DC_PATTERN_MISMATCH = 13,
    /// A result is too large for a number. What was being summed holds anything.
    DC_OVERFLOW = 14,
    /// No memory, or more of something than 32-bit indices can name.
    DC_TOO_LARGE = 15,
    /// An error inside the library. The handle can only be destroyed. Please report it.
    DC_INTERNAL = 16,
}

pub use dc_status::*;

/// Why a call failed.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    pub status: dc_status,
    /// One sentence, with the numbers.
    pub message: String,
}

impl Failure {
    pub fn new(status: dc_status, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }
}

/// A sentence that opens with the stable code of the Rust crate.
fn coded(code: &str, sentence: &dyn std::fmt::Display) -> String {
    format!("{code}: {sentence}")
}

/// The status for a stable code; `otherwise` for those that are of the callee's kind.
fn status_of(code: &str, otherwise: dc_status) -> dc_status {
    match code {
        "non-finite-position" | "non-finite-input" | "invalid-gap" | "invalid-slip" => DC_NOT_FINITE,
        "node-out-of-range" | "slave-out-of-range" | "unknown-node" | "unknown-equation"
        | "foreign-carrier" => DC_OUT_OF_RANGE,
        "wrong-number-of-positions"
        | "too-few-positions"
        | "multiplier-count"
        | "output-length"
        | "anchor-count" => DC_BAD_SIZE,
        "derivative-length" | "no-slip" | "not-derived" | "not-refreshed" => DC_NOT_EVALUATED,
        "pattern-mismatch" => DC_PATTERN_MISMATCH,
        "too-many" | "too-many-nodes" | "too-large" | "out-of-memory" => DC_TOO_LARGE,
        "repeated-slave" | "slave-on-master" | "slave-without-area" | "slave-behind-symmetry" => {
            DC_BAD_SLAVES
        }
        "overflow" => DC_OVERFLOW,
        "invalid-option" | "invalid-support-radius" | "invalid-frame" | "no-kernels" => DC_BAD_OPTION,
        _ => otherwise,
    }
}

impl From<SurfaceError> for Failure {
    fn from(error: SurfaceError) -> Self {
        Self::new(status_of(error.code(), DC_BAD_SURFACE), coded(error.code(), &error))
    }
}

impl From<InterfaceError> for Failure {
    fn from(error: InterfaceError) -> Self {
        let otherwise =
            if matches!(error, InterfaceError::Surface(_)) { DC_BAD_SURFACE } else { DC_BAD_OPTION };
        Self::new(status_of(error.code(), otherwise), coded(error.code(), &error))
    }
}

impl From<WindowError> for Failure {
    fn from(error: WindowError) -> Self {
        Self::new(DC_BAD_OPTION, coded(error.code(), &error))
    }
}

impl From<AssemblyError> for Failure {
    fn from(error: AssemblyError) -> Self {
        Self::new(status_of(error.code(), DC_BAD_OPTION), coded(error.code(), &error))
    }
}

impl From<FrictionError> for Failure {
    fn from(error: FrictionError) -> Self {
        Self::new(DC_BAD_OPTION, coded(error.code(), &error))
    }
}

/// Of input that no kernel can repair, and of an element without result.
impl From<ElementError> for Failure {
    fn from(error: ElementError) -> Self {
        let status = match error {
            ElementError::TooFewNodes { .. } | ElementError::FacetCorners { .. } => DC_BAD_SIZE,
            _ => match status_of(error.code(), DC_NO_CONTACT) {
                DC_OVERFLOW => DC_NO_CONTACT,
                status => status,
            },
        };
        Self::new(status, coded(error.code(), &error))
    }
}

impl From<NeighbourhoodError> for Failure {
    fn from(error: NeighbourhoodError) -> Self {
        let status = match status_of(error.code(), DC_NO_CONTACT) {
            DC_OVERFLOW => DC_NO_CONTACT,
            status => status,
        };
        Self::new(status, coded(error.code(), &error))
    }
}

/// The name of a status, such as "bad-handle"; "unknown" for a number that is none. A constant text.
#[unsafe(no_mangle)]
pub extern "C" fn dc_status_name(status: i32) -> *const std::ffi::c_char {
    const NAMES: [&std::ffi::CStr; 17] = [
        c"ok",
        c"frozen",
        c"no-contact",
        c"bad-pointer",
        c"bad-size",
        c"bad-handle",
        c"busy",
        c"bad-option",
        c"not-finite",
        c"out-of-range",
        c"bad-surface",
        c"bad-slaves",
        c"not-evaluated",
        c"pattern-mismatch",
        c"overflow",
        c"too-large",
        c"internal",
    ];
    usize::try_from(status).ok().and_then(|status| NAMES.get(status)).unwrap_or(&c"unknown").as_ptr()
}

/// The sentence to the last status of this thread that was not DC_OK, with the numbers that led to it; it opens with a
/// stable code, such as "repeated-node: ". Never NULL; empty before the first. It holds until the thread's next call.
#[unsafe(no_mangle)]
pub extern "C" fn dc_message() -> *const std::ffi::c_char {
    message::pointer()
}
