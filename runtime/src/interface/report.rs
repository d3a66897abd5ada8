//! What a refresh of the pairing did.

use std::collections::BTreeMap;

use super::NoContact;
use crate::neighbourhood::Fallback;

/// What [`refresh_pairing`](super::ContactInterface::refresh_pairing) did, in numbers of slave nodes.
///
/// `paired` is the sum of `kept`, `renewed`, `changed` and `gained`; with those in `without` it makes up all
/// slaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RefreshReport {
    /// With a pairing now.
    pub paired: usize,
    /// Of these: kept by hysteresis.
    pub kept: usize,
    /// Of these: paired anew with the same masters; support radius and basis may differ.
    pub renewed: usize,
    /// Of these: paired with other masters than before.
    pub changed: usize,
    /// Of these: without a pairing before.
    pub gained: usize,
    /// Without a pairing now, but with one before.
    pub lost: usize,
    /// Without a pairing now, by [`NoContact::code`].
    pub without: BTreeMap<&'static str, usize>,
    /// What the searches of the paired had to give up.
    pub fallbacks: FallbackCounts,
    /// Where the refresh changed the gap most, if it changed any. Slaves that have no gap before or after do not
    /// take part.
    pub largest_gap_jump: Option<GapJump>,
}

/// Numbers of paired slave nodes by [`Fallback`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FallbackCounts {
    /// Nothing was given up.
    pub none: usize,
    /// More layers or nodes than asked for.
    pub extended: usize,
    /// The linear basis.
    pub linear: usize,
}

/// The gap of one slave by the old and by the new pairing, at the positions of the refresh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapJump {
    /// The slave node.
    pub slave: usize,
    /// The gap by the old pairing, length.
    pub before: f64,
    /// The gap by the new pairing, length.
    pub after: f64,
}

impl GapJump {
    /// |after − before|
    #[must_use]
    pub fn size(&self) -> f64 {
        (self.after - self.before).abs()
    }
}

impl RefreshReport {
    pub(super) fn count_without(&mut self, reason: NoContact) {
        *self.without.entry(reason.code()).or_default() += 1;
    }

    pub(super) fn count_fallback(&mut self, fallback: Fallback) {
        match fallback {
            Fallback::None => self.fallbacks.none += 1,
            Fallback::Extended { .. } => self.fallbacks.extended += 1,
            Fallback::Linear { .. } => self.fallbacks.linear += 1,
        }
    }

    /// Of jumps of equal size that of the node with the lowest index stays.
    pub(super) fn meet_jump(&mut self, jump: GapJump) {
        let is_larger = match self.largest_gap_jump {
            None => jump.size() > 0.0,
            Some(largest) => {
                jump.size() > largest.size() || (jump.size() == largest.size() && jump.slave < largest.slave)
            }
        };
        if is_larger {
            self.largest_gap_jump = Some(jump);
        }
    }

    /// Adds what was done for other slaves.
    pub(super) fn append(&mut self, next: &Self) {
        self.paired += next.paired;
        self.kept += next.kept;
        self.renewed += next.renewed;
        self.changed += next.changed;
        self.gained += next.gained;
        self.lost += next.lost;
        for (code, count) in &next.without {
            *self.without.entry(code).or_default() += count;
        }
        self.fallbacks.none += next.fallbacks.none;
        self.fallbacks.extended += next.fallbacks.extended;
        self.fallbacks.linear += next.fallbacks.linear;
        if let Some(jump) = next.largest_gap_jump {
            self.meet_jump(jump);
        }
    }
}
