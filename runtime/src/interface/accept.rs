//! A step that ends: the anchors of the next one, and what friction did.
//!
//! An anchor changes only when a step is [accepted](ContactInterface::accept): until then a host may go back to where it began and try
//! again. What [augmentation](ContactInterface::augment) makes of the anchors within a step is kept beside them.

use std::ops::AddAssign;

use rayon::prelude::*;

use super::anchors::{Anchor, check_anchors, from_numbers, to_numbers};
use super::evaluator::Evaluator;
use super::pairings::{Paired, Pairings};
use super::scratch::ElementScratch;
use super::{ContactElement, ContactInterface, InterfaceError, NoContact};
use crate::affine::Carrier;
use crate::assembly::{AssemblyError, ContactLaw};
use crate::friction::{FrictionForce, FrictionState};
use crate::scratch::Pool;
use crate::surface::Symmetry;
use crate::vector::Vector3;
use crate::{AffinePoint, Backend, FacetElement, Generated, Mode, Point, Slip, Weight};

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
    /// Work of the tractions over what slid in the step, energy: Σ μ p Δs by the trapezoidal rule, with the p of both ends. What closed and
    /// opened within the step, or left the master in it, is not counted.
    pub dissipated: f64,
    /// Σ μ p of the contacts over nodes that slide, with a shear limit Σ min(μ p, τ A), force.
    pub limit: f64,
    /// What their forces are below that, force: where the surface turns by Δθ under a slave within the step, its force is μ p cos Δθ.
    pub short: f64,
}

/// An anchor of the next step, and what the contact did in the last.
struct Accepted {
    anchor: Anchor,
    state: Option<FrictionState>,
    is_open: bool,
    dissipated: f64,
    /// μ p and the force on the slave, if it slides.
    sliding: Option<[f64; 2]>,
}

impl AddAssign for FrictionReport {
    fn add_assign(&mut self, other: Self) {
        self.stuck += other.stuck;
        self.sliding += other.sliding;
        self.unanchored += other.unanchored;
        self.dropped += other.dropped;
        self.dissipated += other.dissipated;
        self.limit += other.limit;
        self.short += other.short;
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
        if let Some([limit, force]) = accepted.sliding {
            self.limit += limit;
            self.short += (limit - force).max(0.0);
        }
    }
}

impl ContactInterface {
    /// Accepts the state at the positions of the moment as the end of a step: friction of the next one is measured from here.
    ///
    /// Without friction in the law all slaves slide freely: where there is a history their feet become their anchors, and all counts are 0.
    /// Without a history nothing happens then.
    ///
    /// To be called once before the first step, after a refresh, and then whenever a step has converged, with the multipliers that it was
    /// solved with: before they are updated. Until then nothing of the history changes: a host that cuts a step back has only to go on from
    /// the positions it began with. A slave that sticks and was closed before keeps its anchor. One that slides, or closed within the step,
    /// draws it along; of one that is open the foot becomes it. A slave whose result is not known, [`NoContact::BeyondWindow`], keeps what
    /// it had.
    ///
    /// # Errors
    /// As [`check_friction`](Self::check_friction); [`InterfaceError::Law`] for a law that is none; [`InterfaceError::NotRefreshed`]
    /// before the first refresh. The history then stays.
    pub fn accept(&mut self, law: &ContactLaw<'_>) -> Result<FrictionReport, InterfaceError> {
        if law.friction.is_none() && self.anchors.is_none() {
            return Ok(FrictionReport::default());
        }
        self.check_accepted(law)?;
        self.check_refreshed()?;
        let (anchors, report) = self.evaluator().accept(&self.pairings, law, &self.elements)?;
        self.anchors = Some(anchors);
        self.augmented = None;
        Ok(if law.friction.is_some() { report } else { FrictionReport::default() })
    }

    fn check_accepted(&self, law: &ContactLaw<'_>) -> Result<(), InterfaceError> {
        self.check_friction()?;
        law.validate(self.slaves().len())?;
        Ok(())
    }

    /// A round of Uzawa's iteration for friction: the traction of each slave that carries force becomes its multiplier, so that the next
    /// equilibrium has less slip where it sticks, and a traction that is closer to opposite where it slides. To be called in an
    /// equilibrium whose [`slip_errors`](Self::slip_errors) are too large, with the law that it was solved with; then evaluate again. Slaves
    /// of which `moves` says no stay as they are: there no multiplier can help. Without friction in the law nothing happens.
    ///
    /// The multipliers are part of the step on its way. [`accept`](Self::accept) takes them over, [`roll_back`](Self::roll_back) forgets them.
    ///
    /// # Errors
    /// As [`accept`](Self::accept); [`AssemblyError::NoAugmentation`] for friction without
    /// [augmentation](crate::Coulomb::with_augmentation). Nothing is changed then.
    pub fn augment(
        &mut self,
        law: &ContactLaw<'_>,
        moves: impl Fn(usize) -> bool + Sync,
    ) -> Result<(), InterfaceError> {
        let (anchors, _) = self.augmented(law, moves)?;
        if let Some(anchors) = anchors {
            self.augmented = Some(anchors);
        }
        Ok(())
    }

    /// How far each slave is from Coulomb's law without ε_T, length: its slip since it stuck where it sticks, and what of it is not along
    /// the traction where it slides; 0 without force, anchor or friction.
    ///
    /// # Errors
    /// As [`augment`](Self::augment).
    pub fn slip_errors(&self, law: &ContactLaw<'_>) -> Result<Vec<f64>, InterfaceError> {
        self.augmented(law, |_| true).map(|(_, errors)| errors)
    }

    /// Forgets what [`augment`](Self::augment) did since the last accepted step. If that is anything, all pairings end: refresh them.
    pub fn roll_back(&mut self) {
        if self.augmented.take().is_some() {
            self.end_pairings();
        }
    }

    /// The anchors of now with another round, and the errors.
    #[allow(clippy::type_complexity)]
    fn augmented(
        &self,
        law: &ContactLaw<'_>,
        moves: impl Fn(usize) -> bool + Sync,
    ) -> Result<(Option<Vec<Option<Anchor>>>, Vec<f64>), InterfaceError> {
        let Some(friction) = law.friction else {
            law.validate(self.slaves().len())?;
            return Ok((None, vec![0.0; self.slaves().len()]));
        };
        if !friction.is_augmented() {
            return Err(AssemblyError::NoAugmentation.into());
        }
        self.check_accepted(law)?;
        let Some(committed) = &self.anchors else { return Ok((None, vec![0.0; self.slaves().len()])) };
        self.check_refreshed()?;
        let evaluator = self.evaluator();
        let round = |slave: &Sticking<'_>| evaluator.augment_one(slave, &moves);
        let rounds = evaluator.of_all(&self.pairings, law, &self.elements, round)?;
        let errors = rounds.iter().map(|round| round.as_ref().map_or(0.0, |round| round.error)).collect();
        let next = rounds.into_iter().zip(committed).map(|(round, committed)| match round {
            Some(round) => Some(round.anchor),
            None => committed.clone(),
        });
        Ok((Some(next.collect()), errors))
    }

    /// Whether there can be friction.
    ///
    /// # Errors
    /// [`AssemblyError::NoAnchors`] for a diffuse element with another neighbour rule than domains of influence;
    /// [`AssemblyError::NoFrictionKernels`] for one without the feature `friction`. Assembly with such a law is refused as well.
    pub fn check_friction(&self) -> Result<(), AssemblyError> {
        self.options.check_friction()
    }

    /// The history of friction as plain numbers, for a restart; empty before a state was [accepted](Self::accept). Nodes have their numbers
    /// in the whole surface, in an interface of a [window](crate::surface::window), too: histories go with slaves from window to window,
    /// [slave by slave](super::split_history).
    pub fn history(&self) -> Vec<f64> {
        self.numbers_of(self.anchors.as_deref())
    }

    /// The history that friction is measured from at the moment: [`history`](Self::history) with the rounds of [`augment`](Self::augment)
    /// since the last accepted step.
    pub fn augmented_history(&self) -> Vec<f64> {
        self.numbers_of(self.present_anchors())
    }

    fn numbers_of(&self, anchors: Option<&[Option<Anchor>]>) -> Vec<f64> {
        anchors.map_or_else(Vec::new, |anchors| {
            to_numbers(anchors, |node| match &self.known {
                Some(known) => known.number_of(node).map_or(f64::NAN, |number| number as f64),
                None => f64::from(node),
            })
        })
    }

    /// Whether a state was [accepted](Self::accept) since the history began.
    pub const fn has_history(&self) -> bool {
        self.anchors.is_some()
    }

    /// Goes on from a [`history`](Self::history), bit for bit; no numbers are no history. If it is another one than the present, all
    /// pairings end: refresh them.
    ///
    /// # Errors
    /// [`InterfaceError::InvalidHistory`]; [`InterfaceError::CarrierBeyondWindow`] for a node that is not in the window of this interface;
    /// and as [`set_anchors`](Self::set_anchors). The history of before then stays.
    pub fn set_history(&mut self, history: &[f64]) -> Result<(), InterfaceError> {
        if history.is_empty() {
            return self.set_anchors(None);
        }
        let anchors = from_numbers(history, |index, number| match &self.known {
            Some(known) => {
                let node = known.node_of(number);
                node.map(Some).ok_or(InterfaceError::CarrierBeyondWindow { index, node: number })
            }
            None => Ok(u32::try_from(number).ok()),
        });
        self.set_anchors(Some(anchors?))
    }

    /// The anchors that friction is measured from: those of the last accepted step, or what augmentation made of them.
    pub(super) fn present_anchors(&self) -> Option<&[Option<Anchor>]> {
        self.augmented.as_deref().or(self.anchors.as_deref())
    }

    /// The history of friction, one entry per slave; `None` before a state was [accepted](Self::accept).
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
            // Facets have no images.
            let without = Symmetry::default();
            let symmetry = self.nodal.as_ref().map_or(&without, |nodal| &nodal.symmetry);
            check_anchors(anchors, self.slaves().len(), &self.master, symmetry)?;
        }
        if self.anchors != anchors || self.augmented.is_some() {
            self.anchors = anchors;
            self.augmented = None;
            self.end_pairings();
        }
        Ok(())
    }
}

impl Evaluator<'_> {
    /// The anchors of all slaves after a step that ended here, and what friction did in it.
    pub fn accept(
        &self,
        pairings: &Pairings,
        law: &ContactLaw<'_>,
        pool: &Pool<ElementScratch>,
    ) -> Result<(Vec<Option<Anchor>>, FrictionReport), InterfaceError> {
        let is_augmented = law.friction.is_some_and(|friction| friction.is_augmented());
        let accepted = self.of_all(pairings, law, pool, |slave| accept_one(slave, is_augmented))?;
        let mut report = FrictionReport::default();
        let mut anchors = Vec::with_capacity(accepted.len());
        for (k, one) in accepted.into_iter().enumerate() {
            let committed = self.committed.and_then(|anchors| anchors[k].as_ref());
            if let (None, Err(NoContact::BeyondWindow { .. })) = (&one, pairings.get(k)) {
                anchors.push(committed.cloned());
                continue;
            }
            let was_closed = committed.is_some_and(|anchor| anchor.opening == 0.0);
            report.add(one.as_ref(), was_closed);
            anchors.push(one.map(|one| one.anchor));
        }
        Ok((anchors, report))
    }

    /// Something of each slave with contact.
    fn of_all<T: Send>(
        &self,
        pairings: &Pairings,
        law: &ContactLaw<'_>,
        pool: &Pool<ElementScratch>,
        f: impl Fn(&Sticking<'_>) -> Option<T> + Sync,
    ) -> Result<Vec<Option<T>>, InterfaceError> {
        let all = pairings.all().into_par_iter();
        let all: Vec<_> = all
            .map(|k| pool.with(ElementScratch::default, |scratch| self.of_one(pairings, k, law, scratch, &f)))
            .collect();
        // Of several errors that of the first slave, for any number of threads.
        all.into_iter().collect()
    }

    fn of_one<T>(
        &self,
        pairings: &Pairings,
        k: usize,
        law: &ContactLaw<'_>,
        scratch: &mut ElementScratch,
        f: impl Fn(&Sticking<'_>) -> Option<T>,
    ) -> Result<Option<T>, InterfaceError> {
        let Ok(paired) = pairings.get(k) else { return Ok(None) };
        let old = self.anchor(k);
        let from = old.map_or(self.positions[paired.slave], |old| self.anchor_position(old));
        let found = match self.options.element {
            ContactElement::Diffuse { weight, .. } => self.slip_of_fit(&paired, weight, from, scratch),
            ContactElement::NodeToFacet => self.slip_of_facet(&paired, from, scratch),
        };
        let Ok((slip, terms)) = found else { return Ok(None) };
        let (gap, area) = (slip.contact.gap, pairings.layout.area(k));
        let pressed = law.checked_normal_force(k, gap, area)?;
        let force = old.and_then(|old| law.friction_by(pressed, area, (slip.half_square, old.opening)));
        if let (Some(force), Some(old)) = (force, old)
            && force.check().is_err()
        {
            let slip = (slip.half_square, old.opening);
            return Err(law.invalid_friction_by(k, pressed, area, slip).into());
        }
        let is_open = !(pressed.force > 0.0);
        let opening = if is_open { law.opening(k, gap)? } else { 0.0 };
        // Without what a multiplier is worth.
        let way = match old.and_then(|old| old.origin.as_ref()) {
            Some(origin) if is_open => self.slip_from(origin, &slip.contact.point()).norm(),
            _ => slip.length(),
        };
        let limit = match (force, &law.friction) {
            (Some(force), _) if force.state == FrictionState::Slip => force.factor * slip.length(),
            (_, Some(friction)) => friction.over(area).limit(pressed.force),
            (_, None) => 0.0,
        };
        Ok(f(&Sticking { k, old, is_open, opening, limit, force, way, slip: &slip, terms }))
    }

    /// The slip of a diffuse element, and the carriers of its foot.
    fn slip_of_fit(
        &self,
        paired: &Paired<'_>,
        weight: Weight,
        from: Point,
        scratch: &mut ElementScratch,
    ) -> Result<(Slip, Vec<(Carrier, f64)>), NoContact> {
        let ElementScratch { within_reach: all, border, .. } = scratch;
        let found = self.gather_one(paired, weight, all)?;
        let element = self.element_of(paired, all, &found, weight);
        let slip = Generated.slip(&element, from, Mode::Gradient)?;
        self.within_border(paired, Ok(slip.contact.point()), border)?;
        let points = all.sources[found.range].iter().map(|source| source.point(paired.masters));
        let terms = points.zip(&slip.foot_weights).flat_map(|(point, weight)| {
            point.carriers().map(move |(carrier, part)| (carrier, part * weight))
        });
        let terms = terms.collect();
        Ok((slip, terms))
    }

    /// The same of a node-to-facet element.
    fn slip_of_facet(
        &self,
        paired: &Paired<'_>,
        from: Point,
        scratch: &mut ElementScratch,
    ) -> Result<(Slip, Vec<(Carrier, f64)>), NoContact> {
        self.element(paired, Mode::Value, &mut [], &mut [], scratch)?;
        let slave = self.positions[paired.slave];
        let element = FacetElement { slave, corners: self.gather_corners(paired, scratch) };
        let slip = Generated.facet_slip(&element, from, Mode::Gradient)?;
        let carriers = self.corners_of(paired).iter().map(|&node| Carrier::from(node));
        let terms = carriers.zip(slip.foot_weights.iter().copied()).collect();
        Ok((slip, terms))
    }

    /// The next anchor of a slave in an equilibrium that is not the last one of its step.
    fn augment_one(&self, slave: &Sticking<'_>, moves: impl Fn(usize) -> bool) -> Option<Round> {
        let (Some(old), Some(force), false) = (slave.old, slave.force, slave.is_open) else { return None };
        if !moves(slave.k) {
            return Some(Round { anchor: old.clone(), error: 0.0 });
        }
        let foot = slave.foot()?;
        let at = slave.slip.contact.point();
        let slip_from = |point: &AffinePoint| self.slip_from(point, &at);
        let sliding = force.sliding();
        let error = sliding.error(slip_from(&old.point), slip_from(old.stuck_at()));
        // From the place of touch on the contact is one that was closed.
        let origin = old.stuck_at().towards(&foot, 1.0 - sliding.share);
        let parts = [(&origin, 1.0), (&old.point, sliding.kept), (&foot, -sliding.kept)];
        let point = AffinePoint::combined(&parts);
        let Anchor { limit, slid, .. } = *old;
        let anchor = Anchor { point, opening: 0.0, limit, slid, origin: Some(origin) };
        Some(Round { anchor, error })
    }
}

/// A slave with contact at the end of a step, or of a round of it.
struct Sticking<'a> {
    k: usize,
    old: Option<&'a Anchor>,
    is_open: bool,
    /// How far an open contact is from carrying force, length; else 0.
    opening: f64,
    /// The largest friction that it can bear, force; 0 if it is open.
    limit: f64,
    force: Option<FrictionForce>,
    /// What it slid, length; of one that opens since where it stuck.
    way: f64,
    slip: &'a Slip,
    /// The foot's carriers and weights.
    terms: Vec<(Carrier, f64)>,
}

impl Sticking<'_> {
    /// The weights add up to one but for rounding: the check of it finds what is no number.
    fn foot(&self) -> Option<AffinePoint> {
        AffinePoint::new(self.terms.iter().copied()).ok()
    }
}

/// What a round of augmentation makes of a slave.
struct Round {
    anchor: Anchor,
    /// Length.
    error: f64,
}

fn accept_one(slave: &Sticking<'_>, is_augmented: bool) -> Option<Accepted> {
    let &Sticking { old, is_open, opening, limit, force, way, slip, .. } = slave;
    let kept = force.map_or(0.0, |force| force.kept);
    let (point, origin) = match old {
        Some(old) if kept == 1.0 && !is_open => {
            (old.point.clone(), old.origin.clone().filter(|_| is_augmented))
        }
        _ => {
            let foot = slave.foot()?;
            let slides = force.is_some_and(|force| force.state == FrictionState::Slip);
            let origin = (slides && is_augmented).then(|| foot.clone());
            let dragged = old.filter(|_| !is_open && force.is_some());
            (dragged.map_or_else(|| foot.clone(), |old| old.point.towards(&foot, 1.0 - kept)), origin)
        }
    };
    let sliding = force.filter(|force| force.state == FrictionState::Slip);
    Some(Accepted {
        anchor: Anchor { point, opening, limit, slid: sliding.is_some(), origin },
        state: force.map(|force| force.state),
        is_open,
        dissipated: force.zip(old).map_or(0.0, |(force, old)| force.dissipated(way, old.before_step())),
        sliding: sliding.map(|force| {
            let of_slave = Vector3::from([slip.gradient[0], slip.gradient[1], slip.gradient[2]]);
            [slip.length(), of_slave.norm()].map(|length| force.factor * length)
        }),
    })
}
