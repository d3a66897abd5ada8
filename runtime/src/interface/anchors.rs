//! The history of friction: where each slave stuck to the master.
//!
//! An anchor changes only when a step is [accepted](super::ContactInterface::accept): until then a host may go back to where it
//! began and try again. Its nodes are listed with the slave's masters, so that derivatives by the anchor become derivatives by listed
//! nodes, and the assembly of forces and tangents has no more to know.

use rayon::prelude::*;

use super::evaluate::{ElementScratch, Evaluator};
use super::fold::{AnchorSource, Source};
use super::pairings::{Paired, Pairings};
use super::scratch::Pool;
use super::{ContactElement, InterfaceError};
use crate::affine::Carrier;
use crate::assembly::ContactLaw;
use crate::friction::{Coulomb, FrictionState};
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
/// and weight of each carrier; −1 for a slave without an anchor.
pub fn to_numbers(anchors: &[Option<Anchor>]) -> Vec<f64> {
    let mut numbers = Vec::new();
    for anchor in anchors {
        let Some(Anchor { point, opening }) = anchor else {
            numbers.push(-1.0);
            continue;
        };
        numbers.extend([point.terms().len() as f64, *opening]);
        for &(Carrier { node, image }, weight) in point.terms() {
            numbers.extend([f64::from(node), image.map_or(-1.0, f64::from), weight]);
        }
    }
    numbers
}

/// What [`to_numbers`] made numbers of. The error is the place of the first number that is none of a history.
pub fn from_numbers(numbers: &[f64]) -> Result<Vec<Option<Anchor>>, usize> {
    let index = |place: usize| {
        let value = numbers.get(place).copied().ok_or(place)?;
        let is_index = value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0;
        if is_index { Ok(value as u32) } else { Err(place) }
    };
    let mut anchors = Vec::new();
    let mut place = 0;
    while place < numbers.len() {
        if numbers[place] == -1.0 {
            anchors.push(None);
            place += 1;
            continue;
        }
        let count = index(place)? as usize;
        let opening = numbers.get(place + 1).copied().filter(|opening| *opening >= 0.0).ok_or(place + 1)?;
        let start = place + 2;
        let mut terms = Vec::new();
        for at in (0..count).map(|k| start + 3 * k) {
            let image = if numbers.get(at + 1) == Some(&-1.0) { None } else { Some(index(at + 1)?) };
            let weight = numbers.get(at + 2).copied().ok_or(at + 2)?;
            terms.push((Carrier { node: index(at)?, image }, weight));
        }
        let point = AffinePoint::new(terms).map_err(|_| place)?;
        anchors.push(Some(Anchor { point, opening }));
        place = start + 3 * count;
    }
    Ok(anchors)
}

/// The slip of one slave at an evaluation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tracked {
    pub is_anchored: bool,
    /// q
    pub half_square: f64,
    pub opening: f64,
}

/// What friction did in a step that was accepted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionReport {
    /// Contacts that stick.
    pub stuck: usize,
    /// Contacts that slide.
    pub sliding: usize,
    /// Work of the tractions over what slid in the step, energy: Σ μ p Δs.
    pub dissipated: f64,
}

/// An anchor of the next step, and what the contact did in the last.
struct Accepted {
    anchor: Option<Anchor>,
    state: FrictionState,
    dissipated: f64,
}

impl Accepted {
    const APART: Self = Self { anchor: None, state: FrictionState::Open, dissipated: 0.0 };
}

impl FrictionReport {
    fn add(&mut self, accepted: &Accepted) {
        match accepted.state {
            FrictionState::Open => {}
            FrictionState::Stick => self.stuck += 1,
            FrictionState::Slip => self.sliding += 1,
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
        sources.extend(anchor.point.terms().iter().filter_map(|&(Carrier { node, image }, weight)| {
            // A refresh lists the carriers of all anchors; what is accepted has no others.
            let listed = paired.masters.binary_search(&node).ok()? as u32;
            Some(AnchorSource { source: Source { listed, image }, weight })
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
        let accepted: Vec<Accepted> = pairings
            .all()
            .into_par_iter()
            .map(|k| {
                pool.with(ElementScratch::default, |scratch| {
                    self.accept_one(pairings, k, weight, law, friction, scratch).unwrap_or(Accepted::APART)
                })
            })
            .collect();
        let mut report = FrictionReport::default();
        accepted.iter().for_each(|one| report.add(one));
        Ok((accepted.into_iter().map(|one| one.anchor).collect(), report))
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
            anchor: Some(Anchor { point, opening: if is_open { gap.max(0.0) } else { 0.0 } }),
            state: force.map_or(FrictionState::Open, |force| force.state),
            dissipated: force.map_or(0.0, |force| force.dissipated(slip.length())),
        })
    }
}
