//! What a refresh of the pairing did.

use std::collections::BTreeMap;

use super::NoContact;
use crate::neighbourhood::Fallback;

/// What [`refresh_pairing`](super::ContactInterface::refresh_pairing) did, in numbers of slave nodes.
///
/// `paired` is the sum of `kept`, `renewed`, `changed` and `gained`; with those in `without` it makes up all
/// slaves.
///
/// A pairing alone is no contact: its element may have no result, or a foot beyond the border. What an
/// evaluation right before the refresh would have given, at the same positions, is compared with what one gives right
/// after it: either there is a gap in both, whose largest change is `largest_gap_jump`, or a contact is lost or gained. Of what following
/// did before only the contacts that it lost are told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RefreshReport {
    /// With a pairing now.
    pub paired: usize,
    /// Of these: with nodal domains, those whose list stays.
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
    /// Of the paired: deeper below the closest facet than a tenth of its size, the root of its area, when they were paired. All of them
    /// are where the master is inside out.
    pub deep: usize,
    /// With a gap by the old pairing at these positions, but none by the new or without one: their forces vanish. Those that
    /// [`follow`](super::ContactInterface::follow) lost in this way since the refresh before count too, unless they have a gap again.
    pub contacts_lost: usize,
    /// With a gap now, but none by the old pairing at these positions or without one: forces may appear.
    pub contacts_gained: usize,
    /// Of the contacts lost, that with the smallest gap when it was lost: the deepest penetration, if it is negative.
    pub smallest_gap_lost: Option<SlaveGap>,
    /// Of the contacts gained, that with the smallest gap.
    pub smallest_gap_gained: Option<SlaveGap>,
    /// Where the refresh changed the gap most, if it changed any. Slaves that have no gap before or after do not
    /// take part: they are contacts gained or lost.
    pub largest_gap_jump: Option<GapJump>,
    /// With nodal domains: whether lists were made anew, as something had moved by more than half their skin. Elsewhere every
    /// refresh pairs anew.
    pub rebuilt: bool,
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

/// The gap of one slave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveGap {
    /// The slave node.
    pub slave: usize,
    /// Its gap, length.
    pub gap: f64,
}

impl SlaveGap {
    /// The smaller gap; of equal ones that of the node with the lower index.
    fn smallest(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        let order = |a: &Self, b: &Self| a.gap.total_cmp(&b.gap).then(a.slave.cmp(&b.slave));
        one.into_iter().chain(other).min_by(order)
    }
}

impl GapJump {
    /// |after − before|
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

    /// Books the gap of a slave by the old and by the new pairing, as far as there is one.
    pub(super) fn compare(&mut self, slave: usize, before: Option<f64>, after: Option<f64>) {
        match (before, after) {
            (Some(before), Some(after)) => self.meet_jump(GapJump { slave, before, after }),
            (Some(gap), None) => self.count_lost(slave, gap),
            (None, Some(gap)) => {
                self.contacts_gained += 1;
                self.smallest_gap_gained =
                    SlaveGap::smallest(self.smallest_gap_gained, Some(SlaveGap { slave, gap }));
            }
            (None, None) => {}
        }
    }

    /// Books a contact that is lost, with its gap by the old pairing.
    pub(super) fn count_lost(&mut self, slave: usize, gap: f64) {
        self.contacts_lost += 1;
        self.smallest_gap_lost = SlaveGap::smallest(self.smallest_gap_lost, Some(SlaveGap { slave, gap }));
    }

    /// Of jumps of equal size that of the node with the lowest index stays.
    fn meet_jump(&mut self, jump: GapJump) {
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
        self.deep += next.deep;
        self.contacts_lost += next.contacts_lost;
        self.contacts_gained += next.contacts_gained;
        self.smallest_gap_lost = SlaveGap::smallest(self.smallest_gap_lost, next.smallest_gap_lost);
        self.smallest_gap_gained = SlaveGap::smallest(self.smallest_gap_gained, next.smallest_gap_gained);
        if let Some(jump) = next.largest_gap_jump {
            self.meet_jump(jump);
        }
    }
}
