//! What became of an element, as a number.

use std::ffi::{CStr, c_char};

use runtime::interface::Outcome;
use runtime::neighbourhood::Fallback;

/// Whether a slave node has a contact element with a result, and why not. Only DC_CONTACT comes with numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum dc_outcome {
    /// Gap, foot and normal are valid, and the derivatives asked for. A positive gap is no touch.
    DC_CONTACT = 0,
    /// No facet was found for the slave in the last refresh.
    DC_NOT_PAIRED = 1,
    /// Beyond distance_limit.
    DC_TOO_FAR = 2,
    /// Too few masters on the slave's side of sharp edges, or masters that carry no fit.
    DC_NO_CANDIDATE = 3,
    /// Never set: masters on a line or on a conic are DC_NO_CANDIDATE.
    DC_ILL_CONDITIONED = 4,
    /// The foot lies beyond the border of the master, or beyond a sharp edge.
    DC_BEYOND_BORDER = 5,
    /// The masters of the pairing no longer determine the surface, or too few of them are within reach: refresh.
    DC_SINGULAR_FIT = 6,
    /// The iteration for the foot did not converge.
    DC_FOOT_DIVERGED = 7,
    /// The foot lies outside the domain of influence.
    DC_FOOT_OUTSIDE = 8,
    /// The slave lies on a centre of curvature: the foot is not unique.
    DC_CENTRE_OF_CURVATURE = 9,
    /// The slave lies beyond one: the foot is not the nearest point.
    DC_BEYOND_CENTRE_OF_CURVATURE = 10,
    /// The masters lie on a line or are as thick as wide.
    DC_NO_AVERAGE_PLANE = 11,
    /// The direction that is to be outside lies in the plane of the masters.
    DC_AMBIGUOUS_OUTWARD = 12,
    /// Node to facet: the facet has no normal at the foot.
    DC_DEGENERATE_FACET = 13,
    /// The results are no numbers: coordinates too large or too small.
    DC_ELEMENT_OVERFLOW = 14,
    /// dc_gap_batch only: the input of this element is refused. dc_gap says why.
    DC_REFUSED = 15,
    /// With DC_DOMAINS: no place of the slave among the first positions of the masters was found, as near its centre of curvature.
    DC_NOT_MATERIAL_PLACE = 16,
    /// The slave has a window of the master only, and its result may depend on what is not in it: make a new window.
    DC_BEYOND_WINDOW = 17,
    /// Over faces and in self contact: no facet of the master lies over the faces around the node within the limit.
    DC_NOTHING_OVER = 18,
}

/// What the neighbour search had to give up for a contact.
#[repr(C)]
pub enum dc_fallback {
    /// Nothing.
    DC_NO_FALLBACK = 0,
    /// More layers or nodes than asked for.
    DC_EXTENDED = 1,
    /// The linear basis: the gap is off by up to about k R^2/2 on a curvature k.
    DC_LINEAR_BASIS = 2,
}

/// Outcomes by their stable code.
const OUTCOMES: [(&CStr, dc_outcome); 19] = [
    (c"contact", dc_outcome::DC_CONTACT),
    (c"not-paired", dc_outcome::DC_NOT_PAIRED),
    (c"too-far", dc_outcome::DC_TOO_FAR),
    (c"no-candidate", dc_outcome::DC_NO_CANDIDATE),
    (c"ill-conditioned", dc_outcome::DC_ILL_CONDITIONED),
    (c"beyond-border", dc_outcome::DC_BEYOND_BORDER),
    (c"singular-fit", dc_outcome::DC_SINGULAR_FIT),
    (c"foot-diverged", dc_outcome::DC_FOOT_DIVERGED),
    (c"foot-outside", dc_outcome::DC_FOOT_OUTSIDE),
    (c"centre-of-curvature", dc_outcome::DC_CENTRE_OF_CURVATURE),
    (c"beyond-centre-of-curvature", dc_outcome::DC_BEYOND_CENTRE_OF_CURVATURE),
    (c"no-average-plane", dc_outcome::DC_NO_AVERAGE_PLANE),
    (c"ambiguous-outward", dc_outcome::DC_AMBIGUOUS_OUTWARD),
    (c"degenerate-facet", dc_outcome::DC_DEGENERATE_FACET),
    (c"overflow", dc_outcome::DC_ELEMENT_OVERFLOW),
    (c"refused", dc_outcome::DC_REFUSED),
    (c"not-material-place", dc_outcome::DC_NOT_MATERIAL_PLACE),
    (c"beyond-window", dc_outcome::DC_BEYOND_WINDOW),
    (c"nothing-over", dc_outcome::DC_NOTHING_OVER),
];

/// The outcome with a stable code of the runtime; that of refused input for any other.
pub fn with_code(code: &str) -> dc_outcome {
    let found = OUTCOMES.iter().find(|(name, _)| name.to_bytes() == code.as_bytes());
    found.map_or(dc_outcome::DC_REFUSED, |(_, outcome)| *outcome)
}

pub fn of(outcome: &Outcome) -> dc_outcome {
    match outcome.code() {
        // Lists that are held have lost a slave that slides far.
        "too-few-nodes" => dc_outcome::DC_SINGULAR_FIT,
        code => with_code(code),
    }
}

pub fn fallback_number(fallback: Fallback) -> i32 {
    (match fallback {
        Fallback::None => dc_fallback::DC_NO_FALLBACK,
        Fallback::Linear { .. } => dc_fallback::DC_LINEAR_BASIS,
        _ => dc_fallback::DC_EXTENDED,
    }) as i32
}

/// The stable code of an outcome, such as "foot-outside", the same in all languages; "unknown" for a number that is
/// none. A constant text.
#[unsafe(no_mangle)]
pub extern "C" fn dc_outcome_code(outcome: i32) -> *const c_char {
    let found = OUTCOMES.iter().find(|(_, known)| *known as i32 == outcome);
    found.map_or(c"unknown", |(name, _)| name).as_ptr()
}
