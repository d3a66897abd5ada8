//! All elements in parallel, each into its own slot.

use diffuse_contact_kernels::support::ElementInputs;

use super::anchors::{Anchor, anchor_sources};
use super::contacts::{Layout, SlipSlot, Slot, Slots, Tracked};
use super::evaluator::Evaluator;
use super::fold::{AnchorSource, Source, fold, fold_with_anchor};
use super::pairings::{Paired, Pairings};
use super::scratch::ElementScratch;
use super::within_reach::WithinReach;
use super::{ContactElement, NoContact, Outcome};
use crate::batch::{Asked, GapSlot, Waiting, contact_point, evaluate};
use crate::facet::{SlipNumbers, facet_slip};
use crate::kernels::frame_rule;
use crate::neighbourhood::Fallback;
use crate::scratch::{Pool, recycled};
use crate::surface::Symmetry;
use crate::{ContactPoint, FacetElement, FrameDerivative, Generated, Mode, Weight};

/// Slaves that one thread evaluates in a row: enough for full vectors although numbers of masters differ.
pub const CHUNK: usize = 256;

/// What is asked of an evaluation.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    pub mode: Mode,
    /// Whether the slave with this index carries force at this gap: others get no derivatives. `None`: all get them.
    pub is_loaded: Option<&'a (dyn Fn(usize, f64) -> bool + Sync)>,
}

impl Request<'_> {
    /// All derivatives of all slaves.
    pub const fn all(mode: Mode) -> Self {
        Self { mode, is_loaded: None }
    }
}

/// Whether feet may lie beyond the border.
#[derive(Clone, Copy)]
enum Border {
    /// They are tested, which takes as long as the gap.
    Tested,
    /// They have been, at the same positions.
    Met,
}

/// What the elements of one piece of work have in common.
#[derive(Clone, Copy)]
struct Run<'s> {
    evaluator: &'s Evaluator<'s>,
    pairings: &'s Pairings,
    weight: Weight,
    mode: Mode,
    /// With nodal domains.
    within_reach: Option<&'s WithinReach>,
}

impl<'s> Run<'s> {
    /// The anchor that the slip of a slot is derived from.
    fn anchor_of(&self, slot: &Slot<'_>) -> Option<&'s Anchor> {
        let is_tracked = slot.slip.is_some() && self.mode >= Mode::Gradient;
        if is_tracked { self.evaluator.anchor(slot.index) } else { None }
    }

    /// Entries of derivatives by images, by auxiliary points, and by an anchor, which have a place of their own before they go to the nodes.
    fn room(&self, place: usize, slot: &Slot<'_>) -> Option<(usize, usize)> {
        let own = self.within_reach.and_then(|all| all.elements[place].as_ref().ok());
        let points = own.map_or(0, |own| own.range.len());
        if self.anchor_of(slot).is_some() {
            return Some(slip_derivatives(self.mode, points));
        }
        let has_others = self.pairings.get(slot.index).is_ok_and(|paired| paired.has_others());
        has_others.then(|| derivatives(self.mode, points))
    }

    /// How the frame follows, and what a kernel reads.
    fn inputs(
        &self,
        place: usize,
        paired: &Paired<'s>,
    ) -> Result<(FrameDerivative, ElementInputs<'s>), NoContact> {
        let Self { evaluator, weight, .. } = *self;
        if let Some(all) = self.within_reach {
            let element = all.elements[place].as_ref().map_err(|reason| *reason)?;
            let inputs = all.inputs(evaluator.positions[paired.slave], element, weight);
            return Ok((element.frame.derivative, inputs));
        }
        let frame = evaluator.current_frame(paired)?;
        Ok((frame.derivative, evaluator.inputs(paired, &frame, weight)))
    }

    /// An element that waits; its derivatives go to the slot, or into `free` first.
    fn element<'r, 'w: 'r, 'f: 'r>(
        &self,
        place: usize,
        paired: &Paired<'s>,
        slot: &mut Slot<'w>,
        free: &mut &'f mut [f64],
    ) -> Result<Waiting<'s, 'r>, NoContact> {
        let (derivative, inputs) = self.inputs(place, paired)?;
        let ((gradient, hessian), places) = match self.room(place, slot) {
            None => {
                let gradient = wanted(&mut slot.gradient, self.mode >= Mode::Gradient);
                let hessian = wanted(&mut slot.hessian, self.mode >= Mode::Hessian);
                ((gradient, hessian), self.within_reach.map_or(&[][..], |all| all.listed(place)))
            }
            Some((gradient, hessian)) => {
                let (own, rest) = std::mem::take(free).split_at_mut(gradient + hessian);
                *free = rest;
                (own.split_at_mut(gradient), &[][..])
            }
        };
        let anchor = self.anchor_of(slot).map(|anchor| self.evaluator.anchor_position(anchor));
        Ok(Waiting {
            weight: self.weight,
            frame: frame_rule(derivative, &inputs.domains),
            basis: paired.record.basis,
            inputs: ElementInputs { anchor: anchor.unwrap_or(inputs.anchor), ..inputs },
            has_slip: anchor.is_some(),
            slot: GapSlot { gradient, hessian },
            places,
            is_sound: true,
        })
    }

    /// Adds up the derivatives by images, by auxiliary points, and by an anchor, in the slot.
    fn fold(
        &self,
        place: usize,
        paired: &Paired<'_>,
        (contact, half_square, numbers): (&ContactPoint, f64, (&[f64], &[f64])),
        slot: &mut Slot<'_>,
        (carriers, rows): (&mut Vec<AnchorSource>, &mut Vec<f64>),
    ) {
        let (Some(nodal), Some(all)) = (self.evaluator.nodal, self.within_reach) else { return };
        let Ok(own) = &all.elements[place] else { return };
        let (sources, symmetry) = (&all.sources[own.range.clone()], &nodal.symmetry);
        if let Some(anchor) = self.anchor_of(slot) {
            anchor_sources(paired, anchor, carriers);
            let tracked = self.evaluator.tracked(anchor, half_square, contact);
            fold_both(numbers, tracked, slot, (sources, carriers), symmetry, rows);
        } else if paired.has_others() {
            fold(numbers, (slot.gradient, slot.hessian), sources, symmetry);
        }
    }
}

impl Evaluator<'_> {
    /// Fills the slots of consecutive slaves. Which thread fills a slot, and after which others, makes no
    /// difference to what it gets.
    pub fn fill(
        &self,
        pairings: &Pairings,
        request: Request<'_>,
        slots: Slots<'_>,
        pool: &Pool<ElementScratch>,
    ) {
        let layout: &Layout = &pairings.layout;
        if slots.len() > CHUNK {
            let half = slots.len().div_ceil(2 * CHUNK) * CHUNK;
            let (first, second) = slots.split(layout, half);
            rayon::join(
                || self.fill(pairings, request, first, pool),
                || self.fill(pairings, request, second, pool),
            );
            return;
        }
        pool.with(ElementScratch::default, |scratch| match self.options.element {
            ContactElement::Diffuse { weight, .. } => {
                self.fill_side_by_side(pairings, request, slots, weight, scratch);
            }
            ContactElement::NodeToFacet => slots.for_each(layout, |mut slot| {
                let is_derived = request.is_loaded.is_none_or(|is_loaded| {
                    self.fill_facet(pairings, Mode::Value, &mut slot, scratch);
                    slot.outcome.is_contact() && is_loaded(slot.index, slot.point.gap)
                });
                *slot.derived = is_derived;
                if is_derived {
                    self.fill_facet(pairings, request.mode, &mut slot, scratch);
                }
            }),
        });
    }

    /// An element of a node and a facet. Derivatives by the corners come first, those by the carriers of an anchor after them.
    fn fill_facet(&self, pairings: &Pairings, mode: Mode, slot: &mut Slot<'_>, scratch: &mut ElementScratch) {
        if let Some(slip) = &mut slot.slip {
            *slip.tracked = Tracked::default();
        }
        let result = pairings.get(slot.index).and_then(|paired| {
            let point = self.element(&paired, mode, slot.gradient, slot.hessian, scratch)?;
            let own = derivatives(mode, self.corners_of(&paired).len());
            let by_carriers = [slot.gradient.get_mut(own.0..), slot.hessian.get_mut(own.1..)];
            by_carriers.into_iter().flatten().for_each(|entries| entries.fill(0.0));
            if let (Some(slip), Some(anchor)) = (&mut slot.slip, self.anchor(slot.index))
                && mode >= Mode::Gradient
            {
                self.fill_slip_of_facet(&paired, (anchor, &point), mode, slip, scratch)?;
            }
            Ok((point, paired.record.fallback))
        });
        write(result, slot.outcome, slot.point);
    }

    /// The slip of such an element, by the nodes listed for its slave.
    fn fill_slip_of_facet(
        &self,
        paired: &Paired<'_>,
        (anchor, contact): (&Anchor, &ContactPoint),
        mode: Mode,
        slip: &mut SlipSlot<'_>,
        scratch: &mut ElementScratch,
    ) -> Result<(), NoContact> {
        let element = FacetElement {
            slave: self.positions[paired.slave],
            corners: self.gather_corners(paired, scratch),
        };
        let mut numbers = SlipNumbers::default();
        let half_square = facet_slip(&element, self.anchor_position(anchor), mode, &mut numbers)?;
        let count = element.corners.len();
        let ElementScratch { carriers, rows, .. } = scratch;
        anchor_sources(paired, anchor, carriers);
        let sources: [Source; 4] = std::array::from_fn(|k| Source::node(k as u32, None));
        let (gradient, hessian) = derivatives(mode, count + 1);
        fold_with_anchor(
            (&numbers.gradient[..gradient], &numbers.hessian[..hessian]),
            (slip.gradient, slip.hessian),
            (&sources[..count], carriers),
            &Symmetry::default(),
            rows,
        );
        *slip.tracked = self.tracked(anchor, half_square, contact);
        Ok(())
    }

    /// Diffuse elements, those with the same number of masters side by side.
    fn fill_side_by_side(
        &self,
        pairings: &Pairings,
        request: Request<'_>,
        slots: Slots<'_>,
        weight: Weight,
        scratch: &mut ElementScratch,
    ) {
        let mut all = recycled(std::mem::take(&mut scratch.lists.slots));
        slots.for_each(&pairings.layout, |slot| all.push(slot));
        let mut slots = all;
        let mut within_reach = std::mem::take(&mut scratch.within_reach);
        if self.nodal.is_some() {
            let paired = slots.iter().map(|slot| pairings.get(slot.index));
            self.gather_within_reach(paired, weight, &mut within_reach);
        }
        let within = self.nodal.map(|_| &within_reach);
        let run = Run { evaluator: self, pairings, weight, mode: request.mode, within_reach: within };
        let mut border = Border::Tested;
        if request.is_loaded.is_some() {
            self.side_by_side(Run { mode: Mode::Value, ..run }, border, &mut slots, scratch, |_| true);
            border = Border::Met;
        }
        for slip in slots.iter_mut().filter_map(|slot| slot.slip.as_mut()) {
            *slip.tracked = Tracked::default();
        }
        self.side_by_side(run, border, &mut slots, scratch, |slot| {
            *slot.derived = request
                .is_loaded
                .is_none_or(|is_loaded| slot.outcome.is_contact() && is_loaded(slot.index, slot.point.gap));
            *slot.derived
        });
        scratch.lists.slots = recycled(slots);
        scratch.within_reach = within_reach;
    }

    /// Evaluates the slots that `choose` chooses. Their gradients and Hessians are used up by a mode that fills them.
    fn side_by_side(
        &self,
        run: Run<'_>,
        tests: Border,
        slots: &mut [Slot<'_>],
        scratch: &mut ElementScratch,
        choose: impl Fn(&mut Slot<'_>) -> bool,
    ) {
        let ElementScratch { border, batch, lists, chosen, by_points, carriers, rows, .. } = scratch;
        let mut waiting = recycled(std::mem::take(&mut lists.waiting));
        let mut places = recycled(std::mem::take(&mut lists.places));
        chosen.clear();
        chosen.extend(slots.iter_mut().map(&choose));
        let of_chosen = slots.iter().enumerate().filter(|(place, _)| chosen[*place]);
        let rooms = of_chosen.filter_map(|(place, slot)| run.room(place, slot));
        let needed = rooms.map(|(gradient, hessian)| gradient + hessian).sum();
        by_points.resize(by_points.len().max(needed), 0.0);
        let mut free = &mut by_points[..];
        for (place, slot) in slots.iter_mut().enumerate().filter(|(place, _)| chosen[*place]) {
            let paired = run.pairings.get(slot.index);
            match paired.and_then(|paired| Ok((run.element(place, &paired, slot, &mut free)?, paired))) {
                Ok((element, paired)) => {
                    waiting.push(element);
                    places.push((place, paired));
                }
                Err(reason) => {
                    // A slave beyond the border may have too few nodes within reach: the border is the reason.
                    let reason = match (reason, paired) {
                        (NoContact::Element { error }, Ok(paired)) => {
                            self.within_border(&paired, Err(error), border).err().unwrap_or(reason)
                        }
                        _ => reason,
                    };
                    write(Err(reason), slot.outcome, slot.point);
                }
            }
        }
        let mut results = recycled(std::mem::take(&mut lists.results));
        results.resize(places.len(), Err(NoContact::NotPaired));
        evaluate(&Generated, Asked::Mode(run.mode), &mut waiting, batch, |index, element| {
            let (place, paired) = &places[index];
            let point = match tests {
                Border::Tested => self.within_border(paired, contact_point(&element.values), border),
                Border::Met => contact_point(&element.values).map_err(NoContact::from),
            };
            if let Ok(contact) = &point {
                let derivatives = (contact, element.values.slip, (&*element.gradient, &*element.hessian));
                run.fold(*place, paired, derivatives, &mut slots[*place], (carriers, rows));
            }
            results[index] = point.map(|point| (point, paired.record.fallback));
        });
        for ((place, _), result) in places.iter().zip(&results) {
            let slot = &mut slots[*place];
            write(*result, slot.outcome, slot.point);
        }
        (lists.waiting, lists.places, lists.results) = (recycled(waiting), recycled(places), results);
    }

    /// The gap alone.
    pub fn gap(&self, paired: &Paired<'_>, scratch: &mut ElementScratch) -> Result<f64, NoContact> {
        if let (Some(_), ContactElement::Diffuse { weight, .. }) = (self.nodal, self.options.element) {
            let ElementScratch { border, within_reach: all, .. } = scratch;
            let found = match self.gather_one(paired, weight, all) {
                Err(NoContact::Element { error }) => {
                    return self.within_border(paired, Err(error), border).map(|point| point.gap);
                }
                found => found?,
            };
            let element = self.element_of(paired, all, &found, weight);
            let point = Generated.gap_into(&element, Mode::Value, &mut [], &mut []);
            return self.within_border(paired, point, border).map(|point| point.gap);
        }
        self.element(paired, Mode::Value, &mut [], &mut [], scratch).map(|point| point.gap)
    }
}

/// Entries of N and of the packed M of an element with so many points.
const fn derivatives(mode: Mode, points: usize) -> (usize, usize) {
    let freedoms = 3 * (points + 1);
    match mode {
        Mode::Value => (0, 0),
        Mode::Gradient => (freedoms, 0),
        Mode::Hessian => (freedoms, freedoms * (freedoms + 1) / 2),
    }
}

/// The same of an element with an anchor, with those of the slip and the weights of the foot.
const fn slip_derivatives(mode: Mode, points: usize) -> (usize, usize) {
    let (of_gap, of_slip) = (derivatives(mode, points), derivatives(mode, points + 1));
    let weights = if of_gap.0 > 0 { points } else { 0 };
    (of_gap.0 + of_slip.0 + weights, of_gap.1 + of_slip.1)
}

/// Derivatives of gap and slip by an element's points and its anchor, as those by the listed nodes.
fn fold_both(
    (gradients, hessians): (&[f64], &[f64]),
    tracked: Tracked,
    slot: &mut Slot<'_>,
    (sources, carriers): (&[Source], &[AnchorSource]),
    symmetry: &Symmetry,
    rows: &mut Vec<f64>,
) {
    let mode = if hessians.is_empty() { Mode::Gradient } else { Mode::Hessian };
    let of_gap = derivatives(mode, sources.len());
    let of_slip = derivatives(mode, sources.len() + 1);
    let (gap_gradient, rest) = gradients.split_at(of_gap.0);
    let (gap_hessian, slip_hessian) = hessians.split_at(of_gap.1);
    fold((gap_gradient, gap_hessian), (slot.gradient, slot.hessian), sources, symmetry);
    if let Some(slip) = &mut slot.slip {
        let numbers = (&rest[..of_slip.0], slip_hessian);
        fold_with_anchor(numbers, (slip.gradient, slip.hessian), (sources, carriers), symmetry, rows);
        *slip.tracked = tracked;
    }
}

/// The numbers, taken out, if they are wanted.
fn wanted<'s>(numbers: &mut &'s mut [f64], are_wanted: bool) -> &'s mut [f64] {
    if are_wanted { std::mem::take(numbers) } else { &mut [] }
}

fn write(
    result: Result<(ContactPoint, Fallback), NoContact>,
    outcome: &mut Outcome,
    point: &mut ContactPoint,
) {
    (*outcome, *point) = match result {
        Ok((point, fallback)) => (Outcome::Contact { fallback }, point),
        Err(reason) => (Outcome::None(reason), ContactPoint::default()),
    };
}
