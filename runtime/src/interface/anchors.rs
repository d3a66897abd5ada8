//! The history of friction: where each slave stuck to the master.
//!
//! An anchor changes only when a step is [accepted](super::ContactInterface::accept): until then a host may go back to where it
//! began and try again. Its nodes are listed with the slave's masters, so that derivatives by the anchor become derivatives by listed
//! nodes, and the assembly of forces and tangents has no more to know.

use std::ops::AddAssign;

use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::support::KernelSet;
use rayon::prelude::*;

use super::evaluate::{ElementScratch, Evaluator};
use super::fold::{AnchorSource, Source};
use super::pairings::{Paired, Pairings};
use super::scratch::Pool;
use super::{ContactElement, ContactInterface, InterfaceError, NoContact};
use crate::affine::Carrier;
use crate::assembly::ContactLaw;
use crate::friction::{Coulomb, FrictionState};
use crate::surface::window::LARGEST_NUMBER;
use crate::surface::{MasterSurface, NONE, Symmetry};
use crate::{AffinePoint, Backend, ContactPoint, Gap, Generated, Mode, Point, Weight};

/// Where a slave was on the master when the last step was accepted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Anchor {
    /// The material point of the master that the slip is measured from: where the slave stuck, or its foot if it was open.
    pub point: AffinePoint,
    /// The gap if the contact was open, length; else 0. The slip of a contact that closes begins at the place of touch.
    pub opening: f64,
}

/// Anchors as plain numbers, slave after slave: the number of carriers and the opening, then node, number of the image (−1: none)
/// and weight of each carrier; −1 for a slave without an anchor. `number_of`: what a node is called.
pub fn to_numbers(anchors: &[Option<Anchor>], number_of: impl Fn(u32) -> f64) -> Vec<f64> {
    let mut numbers = Vec::new();
    for anchor in anchors {
        let Some(Anchor { point, opening }) = anchor else {
            numbers.push(-1.0);
            continue;
        };
        numbers.extend([point.terms().len() as f64, *opening]);
        for &(Carrier { node, image }, weight) in point.terms() {
            numbers.extend([number_of(node), image.map_or(-1.0, f64::from), weight]);
        }
    }
    numbers
}

/// What [`to_numbers`] made numbers of. The error is the place of a number that is none of a history; of weights that do not add up to
/// one it is the first. `node_of`: the node of a number, if there is one.
pub fn from_numbers(
    numbers: &[f64],
    node_of: impl Fn(u64) -> Option<u32>,
) -> Result<Vec<Option<Anchor>>, usize> {
    let number = |place: usize| {
        let value = numbers.get(place).copied().ok_or(place)?;
        let is_number = value >= 0.0 && value < LARGEST_NUMBER as f64 && value.fract() == 0.0;
        if is_number { Ok(value as u64) } else { Err(place) }
    };
    let index = |place: usize| u32::try_from(number(place)?).map_err(|_| place);
    let mut anchors = Vec::new();
    let mut place = 0;
    while place < numbers.len() {
        if numbers[place] == -1.0 {
            anchors.push(None);
            place += 1;
            continue;
        }
        let count = index(place)? as usize;
        let opening = numbers.get(place + 1).copied().ok_or(place + 1)?;
        let start = place + 2;
        let mut terms = Vec::new();
        for at in (0..count).map(|k| start + 3 * k) {
            let image = if numbers.get(at + 1) == Some(&-1.0) { None } else { Some(index(at + 1)?) };
            let weight = numbers.get(at + 2).copied().filter(|weight| weight.is_finite()).ok_or(at + 2)?;
            let node = node_of(number(at)?).ok_or(at)?;
            terms.push((Carrier { node, image }, weight));
        }
        // Of weights that do not add up to one any may be wrong.
        let point = AffinePoint::new(terms).map_err(|_| start + 2)?;
        anchors.push(Some(Anchor { point, opening }));
        place = start + 3 * count;
    }
    Ok(anchors)
}

/// The numbers of each slave in a [history](ContactInterface::history): one after another they are the history again. So histories go with
/// slaves from one interface to another.
///
/// # Errors
/// [`InterfaceError::InvalidHistory`].
pub fn split_history(history: &[f64]) -> Result<Vec<&[f64]>, InterfaceError> {
    let mut parts = Vec::new();
    let (mut rest, mut place) = (history, 0);
    while let Some(&count) = rest.first() {
        let length = if count == -1.0 { 1.0 } else { 2.0 + 3.0 * count };
        if !(length >= 1.0 && length <= rest.len() as f64 && length.fract() == 0.0) {
            return Err(InterfaceError::InvalidHistory { place });
        }
        let (own, after) = rest.split_at(length as usize);
        parts.push(own);
        (rest, place) = (after, place + own.len());
    }
    Ok(parts)
}

/// The slip of one slave at an evaluation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tracked {
    pub is_anchored: bool,
    /// q
    pub half_square: f64,
    pub opening: f64,
}

/// What friction did in a step that was accepted, in numbers of slaves, and its work.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FrictionReport {
    /// Contacts that stick.
    pub stuck: usize,
    /// Contacts that slide.
    pub sliding: usize,
    /// Contacts that carry force without friction: they had no gap, and so no anchor, when the step before was accepted. They have one now.
    pub unanchored: usize,
    /// Slaves that were closed when the step before was accepted, and have no contact element now: their history ends.
    pub dropped: usize,
    /// Work of the tractions over what slid in the step, energy: Σ μ p Δs.
    pub dissipated: f64,
}

/// An anchor of the next step, and what the contact did in the last.
struct Accepted {
    anchor: Anchor,
    state: Option<FrictionState>,
    is_open: bool,
    dissipated: f64,
}

impl AddAssign for FrictionReport {
    fn add_assign(&mut self, other: Self) {
        self.stuck += other.stuck;
        self.sliding += other.sliding;
        self.unanchored += other.unanchored;
        self.dropped += other.dropped;
        self.dissipated += other.dissipated;
    }
}

impl FrictionReport {
    /// `None`: there is no contact element; `was_closed` when the step before was accepted.
    fn add(&mut self, accepted: Option<&Accepted>, was_closed: bool) {
        let Some(accepted) = accepted else {
            self.dropped += usize::from(was_closed);
            return;
        };
        match accepted.state {
            None => self.unanchored += usize::from(!accepted.is_open),
            Some(FrictionState::Open) => {}
            Some(FrictionState::Stick) => self.stuck += 1,
            Some(FrictionState::Slip) => self.sliding += 1,
        }
        self.dissipated += accepted.dissipated;
    }
}

/// Checks anchors that were kept elsewhere.
pub fn check_anchors(
    anchors: &[Option<Anchor>],
    slaves: usize,
    surface: &MasterSurface,
    symmetry: &Symmetry,
) -> Result<(), InterfaceError> {
    if anchors.len() != slaves {
        return Err(InterfaceError::AnchorCount { found: anchors.len(), expected: slaves });
    }
    for (index, anchor) in anchors.iter().enumerate() {
        let Some(anchor) = anchor else { continue };
        if !(anchor.opening >= 0.0 && anchor.opening.is_finite()) {
            return Err(InterfaceError::InvalidOpening { index, value: anchor.opening });
        }
        for &(Carrier { node, image }, _) in anchor.point.terms() {
            let is_there = image.is_none_or(|number| number < symmetry.count());
            if !is_there || surface.nodes().binary_search(&node).is_err() {
                return Err(InterfaceError::ForeignCarrier { index, node });
            }
        }
    }
    Ok(())
}

/// Nodes that carry the anchor of a slave and are not among its masters join them, without a place: they take no part in its fit.
pub fn list_carriers(
    anchor: Option<&Anchor>,
    masters: &mut Vec<u32>,
    places: &mut Vec<u32>,
    images: &mut [u32],
) {
    let Some(anchor) = anchor else { return };
    for (Carrier { node, .. }, _) in anchor.point.terms() {
        if let Err(place) = masters.binary_search(node) {
            masters.insert(place, *node);
            places.insert(place, NONE);
            for [listed, _] in images.as_chunks_mut::<2>().0 {
                *listed += u32::from(*listed as usize >= place);
            }
        }
    }
}

impl ContactInterface {
    /// Accepts the state at the positions of the moment as the end of a step: friction of the next one is measured from here. Without
    /// friction in the law nothing happens.
    ///
    /// To be called once before the first step, after a refresh, and then whenever a step has converged, with the multipliers that it was
    /// solved with: before they are updated. Until then nothing of the history changes: a host that cuts a step back has only to go
    /// on from the positions it began with. A slave that sticks keeps its anchor; one that slides draws it along; of one that is open the
    /// foot becomes it.
    ///
    /// # Errors
    /// As [`check_friction`](Self::check_friction); [`InterfaceError::Law`] for a law that is none; [`InterfaceError::NotRefreshed`]
    /// before the first refresh. The history then stays.
    pub fn accept(&mut self, law: &ContactLaw<'_>) -> Result<FrictionReport, InterfaceError> {
        let Some(friction) = law.friction else { return Ok(FrictionReport::default()) };
        self.check_friction()?;
        law.validate(self.slaves().len())?;
        let is_refreshed =
            self.pairings.records.iter().any(|record| !matches!(record, Err(NoContact::NotPaired)));
        if !is_refreshed {
            return Err(InterfaceError::NotRefreshed);
        }
        let (anchors, report) = self.evaluator().accept(&self.pairings, law, &friction, &self.elements)?;
        self.anchors = Some(anchors);
        Ok(report)
    }

    /// Whether there can be friction.
    ///
    /// # Errors
    /// [`InterfaceError::NoAnchors`] for facets, and for other neighbour rules than domains of influence;
    /// [`InterfaceError::NoFrictionKernels`].
    pub fn check_friction(&self) -> Result<(), InterfaceError> {
        if self.nodal.is_none() {
            return Err(InterfaceError::NoAnchors);
        }
        if Cubic::FRICTION { Ok(()) } else { Err(InterfaceError::NoFrictionKernels) }
    }

    /// The history of friction as plain numbers, for a restart; empty before a state was [accepted](Self::accept). Nodes have their numbers
    /// in the whole surface, in an interface of a [window](crate::surface::window), too: histories go with slaves from window to window,
    /// [slave by slave](super::split_history).
    #[must_use]
    pub fn history(&self) -> Vec<f64> {
        self.anchors.as_deref().map_or_else(Vec::new, |anchors| {
            to_numbers(anchors, |node| match &self.known {
                Some(known) => known.number_of(node).map_or(f64::NAN, |number| number as f64),
                None => f64::from(node),
            })
        })
    }

    /// Goes on from a [`history`](Self::history), bit for bit; no numbers are no history. If it is another one than the present, all
    /// pairings end: refresh them.
    ///
    /// # Errors
    /// [`InterfaceError::InvalidHistory`], also for a node that is not in the window of this interface; and as
    /// [`set_anchors`](Self::set_anchors). The history of before then stays.
    pub fn set_history(&mut self, history: &[f64]) -> Result<(), InterfaceError> {
        if history.is_empty() {
            return self.set_anchors(None);
        }
        let anchors = from_numbers(history, |number| match &self.known {
            Some(known) => known.node_of(number),
            None => u32::try_from(number).ok(),
        });
        let anchors = anchors.map_err(|place| InterfaceError::InvalidHistory { place })?;
        self.set_anchors(Some(anchors))
    }

    /// The history of friction, one entry per slave; `None` before a state was [accepted](Self::accept).
    #[must_use]
    pub fn anchors(&self) -> Option<&[Option<Anchor>]> {
        self.anchors.as_deref()
    }

    /// Goes on from a history as [`anchors`](Self::anchors) gave it, or without any. If it is another one than the present, all pairings
    /// end: refresh them.
    ///
    /// # Errors
    /// [`InterfaceError::AnchorCount`], [`InterfaceError::InvalidOpening`], [`InterfaceError::ForeignCarrier`], and as
    /// [`check_friction`](Self::check_friction). The history of before then stays.
    pub fn set_anchors(&mut self, anchors: Option<Vec<Option<Anchor>>>) -> Result<(), InterfaceError> {
        if let Some(anchors) = &anchors {
            self.check_friction()?;
            let Some(nodal) = &self.nodal else { return Err(InterfaceError::NoAnchors) };
            check_anchors(anchors, self.slaves().len(), &self.master, &nodal.symmetry)?;
        }
        if self.anchors != anchors {
            self.anchors = anchors;
            self.end_pairings();
        }
        Ok(())
    }
}

impl Evaluator<'_> {
    /// The anchor of a slave, if it has one.
    pub fn anchor(&self, k: usize) -> Option<&Anchor> {
        self.anchors.and_then(|anchors| anchors[k].as_ref())
    }

    /// Where an anchor is now.
    pub fn anchor_position(&self, anchor: &Anchor) -> Point {
        anchor.point.position(|carrier| self.place_of(carrier))
    }

    /// The carriers of an anchor among the nodes listed for its slave.
    pub fn anchor_sources(paired: &Paired<'_>, anchor: &Anchor, sources: &mut Vec<AnchorSource>) {
        sources.clear();
        sources.extend(anchor.point.terms().iter().map(|&(Carrier { node, image }, weight)| {
            // A refresh lists the carriers of all anchors, what is accepted has no others, and other anchors end the pairing.
            let listed = paired.masters.binary_search(&node);
            let listed =
                listed.unwrap_or_else(|_| unreachable!("node {node} carries an anchor and is listed")) as u32;
            AnchorSource { source: Source { listed, image }, weight }
        }));
    }

    /// The anchors of all slaves after a step that ended here, and what friction did in it.
    pub fn accept(
        &self,
        pairings: &Pairings,
        law: &ContactLaw<'_>,
        friction: &Coulomb,
        pool: &Pool<ElementScratch>,
    ) -> Result<(Vec<Option<Anchor>>, FrictionReport), InterfaceError> {
        let ContactElement::Diffuse { weight, .. } = self.options.element else {
            return Err(InterfaceError::NoAnchors);
        };
        let accepted: Vec<Option<Accepted>> = pairings
            .all()
            .into_par_iter()
            .map(|k| {
                pool.with(ElementScratch::default, |scratch| {
                    self.accept_one(pairings, k, weight, law, friction, scratch)
                })
            })
            .collect();
        let mut report = FrictionReport::default();
        for (k, one) in accepted.iter().enumerate() {
            let was_closed = self.anchor(k).is_some_and(|anchor| anchor.opening == 0.0);
            report.add(one.as_ref(), was_closed);
        }
        Ok((accepted.into_iter().map(|one| Some(one?.anchor)).collect(), report))
    }

    /// `None` without contact.
    fn accept_one(
        &self,
        pairings: &Pairings,
        k: usize,
        weight: Weight,
        law: &ContactLaw<'_>,
        friction: &Coulomb,
        scratch: &mut ElementScratch,
    ) -> Option<Accepted> {
        let paired = pairings.get(k).ok()?;
        let ElementScratch { within_reach: all, border, .. } = scratch;
        all.clear();
        let found = self.gather_within_reach(&paired, weight, all).ok()?;
        let old = self.anchor(k);
        let from = old.map_or(self.positions[paired.slave], |old| self.anchor_position(old));
        let slip =
            Generated.slip(&self.element_of(&paired, all, &found, weight), from, Mode::Gradient).ok()?;
        let Gap { gap, foot, normal, .. } = slip.contact;
        self.within_border(&paired, Ok(ContactPoint { gap, foot, normal }), border).ok()?;
        let area = pairings.layout.area(k);
        let normal = law.normal(k, gap, area);
        let force = old.map(|old| friction.over(area).force_since(normal, slip.half_square, old.opening));
        let kept = force.map_or(0.0, |force| force.kept);
        let is_open = !(normal.force > 0.0);
        let point = match old {
            Some(old) if kept == 1.0 && !is_open => old.point.clone(),
            _ => {
                let carriers = all.sources.iter().map(|source| Carrier {
                    node: paired.masters[source.listed as usize],
                    image: source.image,
                });
                // The weights add up to one but for rounding: the check of it finds what is no number.
                let foot = AffinePoint::new(carriers.zip(slip.foot_weights.iter().copied())).ok()?;
                old.filter(|_| !is_open).map_or(foot.clone(), |old| old.point.towards(&foot, 1.0 - kept))
            }
        };
        Some(Accepted {
            anchor: Anchor { point, opening: if is_open { gap.max(0.0) } else { 0.0 } },
            state: force.map(|force| force.state),
            is_open,
            dissipated: force.map_or(0.0, |force| force.dissipated(slip.length())),
        })
    }
}
