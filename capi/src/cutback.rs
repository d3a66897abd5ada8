//! What dc_cutback says: the runtime's rule, with the caller's limit.

use runtime::interface::{ContactInterface, Cutback, InterfaceError};

use crate::status::{DC_BAD_OPTION, Failure};

/// Deepest penetration that is not too deep, in support radii.
pub const DEFAULT_LIMIT: f64 = 0.25;

/// The rule and its limit.
#[derive(Clone, Debug)]
pub struct Hint {
    limit: f64,
    cutback: Cutback,
}

impl Hint {
    pub fn new(limit: f64, slaves: usize) -> Result<Self, Failure> {
        if limit > 0.0 && limit.is_finite() {
            return Ok(Self { limit, cutback: Cutback::new(slaves) });
        }
        let message = format!("invalid-option: cutback_penetration must be positive and finite, not {limit}");
        Err(Failure::new(DC_BAD_OPTION, message))
    }

    /// Begins an increment at the positions of the refresh that has just been made.
    pub fn begin(&mut self, interface: &ContactInterface) -> Result<(), InterfaceError> {
        self.cutback.begin(interface)
    }

    /// Books the evaluation that has just been made.
    pub fn book(&mut self, interface: &ContactInterface) {
        self.cutback.book(interface.contacts());
    }

    /// The factor for the increment, from 0.1 to 1.
    pub fn factor(&self, interface: &ContactInterface) -> f64 {
        self.cutback.hint(interface, self.limit).factor
    }
}
