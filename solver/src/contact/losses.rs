//! Slaves that lose their contact element under load.

use diffuse_contact::interface::NoContact;

use super::ContactError;

/// Of each slave of a pass: whether it carried force in the increment on its way or right before it, and whether it may go
/// without its element from there on.
#[derive(Clone, Debug, Default)]
pub struct Losses {
    carried: Vec<bool>,
    excused: Vec<bool>,
}

/// A slave that carried force and has no contact element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostContact {
    /// The slave node.
    pub node: usize,
    /// What keeps it from having one.
    pub reason: NoContact,
    /// Whether it had none as soon as it was paired at the increment's start: no shorter increment helps.
    pub from_start: bool,
}

/// Whether an element that should be there is not: a slave too far away or beyond a border has none by right.
pub const fn is_failure(reason: NoContact) -> bool {
    !matches!(
        reason,
        NoContact::TooFar { .. } | NoContact::BeyondBorder { .. } | NoContact::NothingOver { .. }
    )
}

impl Losses {
    /// At the beginning of an increment. `loaded`: places of the slaves that carry force there.
    ///
    /// # Errors
    /// [`ContactError::OtherPasses`] if there is no such slave.
    pub fn begin(&mut self, slaves: usize, loaded: &[u32]) -> Result<(), ContactError> {
        if let Some(&last) = loaded.iter().max().filter(|&&last| last as usize >= slaves) {
            return Err(ContactError::OtherPasses { found: last as usize + 1, expected: slaves });
        }
        self.carried.clear();
        self.carried.resize(slaves, false);
        for &k in loaded {
            self.carried[k as usize] = true;
        }
        self.excused.clear();
        self.excused.resize(slaves, false);
        Ok(())
    }

    /// The slave in place `k` carries force.
    pub fn note(&mut self, k: usize) {
        if let Some(carried) = self.carried.get_mut(k) {
            *carried = true;
        }
    }

    /// The slave in place `k` has no element for this reason at the increment's start.
    pub fn excuse(&mut self, k: usize, reason: NoContact) {
        if let Some(excused) = self.excused.get_mut(k) {
            *excused = is_failure(reason);
        }
    }

    /// Whether the slave in place `k`, which has no element for this reason, is one that was lost.
    pub fn judge(&self, k: usize, node: usize, reason: NoContact) -> Option<LostContact> {
        let is_lost = self.carried.get(k).copied().unwrap_or(false) && is_failure(reason);
        is_lost.then(|| LostContact { node, reason, from_start: self.excused[k] })
    }
}
