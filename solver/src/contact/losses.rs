//! Slaves that lose their contact under load.

use diffuse_contact::interface::{NoContact, Outcome};

use super::ContactError;
use super::tracks::{Parted, Tracks};

/// Of each slave of a pass: whether it carried force in the increment on its way or right before it, whether it was over the master when
/// the increment began, and whether it may go without its element from there on.
#[derive(Clone, Debug, Default)]
pub struct Losses {
    /// Who carried force right before the increment.
    before: Vec<bool>,
    carried: Vec<bool>,
    /// Who had an element when the increment began.
    over: Vec<bool>,
    excused: Vec<bool>,
}

/// A slave that has no contact, although it carried force and has not left its master, or was over it and went through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostContact {
    /// The slave node.
    pub node: usize,
    /// How it was lost.
    pub loss: Loss,
    /// Whether it had none as soon as it was paired at the increment's start: no shorter increment helps.
    pub from_start: bool,
}

/// How a slave comes to have no contact.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum Loss {
    /// Its element has no result.
    #[error("{0}")]
    Element(NoContact),
    /// It went through the master, deeper than masters are looked for.
    #[error(
        "it, or a face around it, went through the master and lies {depth:e} below the facet that was there when the increment began"
    )]
    Through { depth: f64 },
}

/// Whether an element that should be there is not: a slave too far away or beyond a border has none by right, unless it went through.
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
            let found = last as usize + 1;
            return Err(ContactError::OtherPasses { what: "loaded slaves", found, expected: slaves });
        }
        self.before.clear();
        self.before.resize(slaves, false);
        for &k in loaded {
            self.before[k as usize] = true;
        }
        self.carried.clone_from(&self.before);
        for of_slaves in [&mut self.over, &mut self.excused] {
            of_slaves.clear();
            of_slaves.resize(slaves, false);
        }
        Ok(())
    }

    /// The slave in place `k` carries force.
    pub fn note(&mut self, k: usize) {
        if let Some(carried) = self.carried.get_mut(k) {
            *carried = true;
        }
    }

    /// The slave in place `k` has an element at the increment's start.
    pub fn starts_over(&mut self, k: usize) {
        if let Some(over) = self.over.get_mut(k) {
            *over = true;
        }
    }

    /// The slave in place `k` has no element for this reason at the increment's start.
    pub fn excuse(&mut self, k: usize, reason: NoContact) {
        if let Some(excused) = self.excused.get_mut(k) {
            *excused = is_failure(reason);
        }
    }

    /// Whether the slave in place `k` carries force or did so since the increment began.
    pub fn carried(&self, k: usize) -> bool {
        self.carried.get(k).copied().unwrap_or(false)
    }

    /// Whether the slave in place `k` is one that was lost: it has no element, or faces around it lie over nothing any more.
    pub fn judge(
        &self,
        k: usize,
        node: usize,
        outcome: Outcome,
        tracks: &mut Tracks<'_>,
    ) -> Option<LostContact> {
        let reason = match outcome {
            Outcome::None(reason) => Some(reason),
            Outcome::Contact { .. } => None,
        };
        let carried = self.carried(k);
        // An open slave may lose its element by right. Through the master it goes by right as little as another one: a long step takes it
        // from above to below.
        let failure = reason.filter(|&reason| is_failure(reason));
        if !carried && (failure.is_some() || !self.over.get(k).copied().unwrap_or(false)) {
            return None;
        }
        let loss = if let Some(reason) = failure {
            Loss::Element(reason)
        } else if let Parted::Through { depth } = tracks.parted(k, node, reason) {
            Loss::Through { depth }
        } else {
            return None;
        };
        Some(LostContact { node, loss, from_start: self.excused[k] })
    }

    /// Whether the slave in place `k` carried force when the increment began, has nothing over it now for this reason, and has not risen
    /// from its master.
    pub fn vanished(&self, k: usize, node: usize, reason: NoContact, tracks: &mut Tracks<'_>) -> bool {
        let before = self.before.get(k).copied().unwrap_or(false);
        before && (is_failure(reason) || tracks.parted(k, node, Some(reason)) != Parted::Opened)
    }
}
