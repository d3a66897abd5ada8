//! One element at the positions of the moment, and all of them in parallel.

use diffuse_contact_kernels::support::{ElementInputs, Masters};

use super::contacts::{Layout, Slot, Slots};
use super::pairings::{Paired, Pairings};
use super::scratch::{Pool, recycled};
use super::{ContactElement, InterfaceOptions, NoContact, Outcome};
use crate::batch::{BatchScratch, GapSlot, Waiting, contact_point, evaluate};
use crate::element::nearest_in_plane;
use crate::generated::frame_rule;
use crate::neighbourhood::Fallback;
use crate::surface::{BorderScratch, Creases, MasterSurface};
use crate::{
    ContactPoint, Element, ElementError, FacetElement, Frame, FrameDerivative, Generated, Mode, Point, Weight,
};

/// Slaves that one thread evaluates in a row: enough for full vectors although numbers of masters differ.
pub const CHUNK: usize = 256;

/// What every element of an interface has in common.
#[derive(Clone, Copy, Debug)]
pub struct Evaluator<'a> {
    pub surface: &'a MasterSurface,
    pub creases: &'a Creases,
    /// Of all nodes.
    pub positions: &'a [Point],
    pub options: &'a InterfaceOptions,
}

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

/// Memory of lists that are empty between evaluations.
#[derive(Debug, Default)]
struct Lists {
    slots: Vec<Slot<'static>>,
    waiting: Vec<Waiting<'static, 'static>>,
    places: Vec<(usize, Paired<'static>)>,
}

/// A copy has no memory yet.
impl Clone for Lists {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Memory kept from one element to the next.
#[derive(Clone, Debug, Default)]
pub struct ElementScratch {
    masters: Vec<Point>,
    /// Nodes of a facet, ascending.
    corners: Vec<u32>,
    /// Facets around it.
    patch: Vec<u32>,
    border: BorderScratch,
    batch: BatchScratch,
    lists: Lists,
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
            ContactElement::NodeToFacet => slots.for_each(layout, |slot| {
                let Slot { index, outcome, point, derived, gradient, hessian } = slot;
                let mut at = |mode, gradient: &mut [f64], hessian: &mut [f64]| {
                    let result = pairings.get(index).and_then(|paired| {
                        let point = self.element(&paired, mode, gradient, hessian, scratch)?;
                        Ok((point, paired.record.fallback))
                    });
                    write(result, outcome, point);
                    outcome.is_contact().then_some(point.gap)
                };
                *derived = request.is_loaded.is_none_or(|is_loaded| {
                    at(Mode::Value, &mut [], &mut []).is_some_and(|gap| is_loaded(index, gap))
                });
                if *derived {
                    at(request.mode, gradient, hessian);
                }
            }),
        });
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
        let mut border = Border::Tested;
        if request.is_loaded.is_some() {
            self.side_by_side(pairings, (Mode::Value, border), &mut slots, weight, scratch, |_| true);
            border = Border::Met;
        }
        self.side_by_side(pairings, (request.mode, border), &mut slots, weight, scratch, |slot| {
            *slot.derived = request
                .is_loaded
                .is_none_or(|is_loaded| slot.outcome.is_contact() && is_loaded(slot.index, slot.point.gap));
            *slot.derived
        });
        scratch.lists.slots = recycled(slots);
    }

    /// Evaluates the slots that `choose` chooses. Their gradients and Hessians are used up by a mode that fills them.
    fn side_by_side<'s>(
        &'s self,
        pairings: &'s Pairings,
        (mode, tests): (Mode, Border),
        slots: &mut [Slot<'s>],
        weight: Weight,
        scratch: &mut ElementScratch,
        choose: impl Fn(&mut Slot<'s>) -> bool,
    ) {
        let ElementScratch { border, batch, lists, .. } = scratch;
        let mut waiting = recycled(std::mem::take(&mut lists.waiting));
        let mut places = recycled(std::mem::take(&mut lists.places));
        for (place, slot) in slots.iter_mut().enumerate() {
            if !choose(slot) {
                continue;
            }
            let paired = pairings.get(slot.index);
            let with_frame = paired.and_then(|paired| Ok((paired, self.current_frame(&paired)?)));
            match with_frame {
                Ok((paired, frame)) => {
                    let wanted = |numbers: &mut &'s mut [f64], from: Mode| {
                        if mode >= from { std::mem::take(numbers) } else { &mut [] }
                    };
                    let gradient = wanted(&mut slot.gradient, Mode::Gradient);
                    let hessian = wanted(&mut slot.hessian, Mode::Hessian);
                    waiting.push(Waiting {
                        weight,
                        frame: frame_rule(frame.derivative),
                        basis: paired.record.basis,
                        inputs: self.inputs(&paired, &frame, weight),
                        slot: GapSlot { gradient, hessian },
                        is_sound: true,
                    });
                    places.push((place, paired));
                }
                Err(reason) => write(Err(reason), slot.outcome, slot.point),
            }
        }
        evaluate(&Generated, mode, &mut waiting, batch, |index, values| {
            let (place, paired) = &places[index];
            let point = match tests {
                Border::Tested => self.within_border(paired, contact_point(values), border),
                Border::Met => contact_point(values).map_err(NoContact::from),
            };
            let slot = &mut slots[*place];
            write(point.map(|point| (point, paired.record.fallback)), slot.outcome, slot.point);
        });
        (lists.waiting, lists.places) = (recycled(waiting), recycled(places));
    }

    /// What a kernel reads of a paired slave.
    fn inputs<'s>(&'s self, paired: &Paired<'s>, frame: &Frame, weight: Weight) -> ElementInputs<'s> {
        let slave = self.positions[paired.slave];
        let support_radius = paired.record.support_radius;
        let anchor = match weight {
            Weight::CubicInterpolating => {
                nearest_in_plane(slave, self.masters(paired), frame, |_| support_radius)
            }
            Weight::Cubic | Weight::WendlandC2 => 0,
        };
        ElementInputs {
            slave,
            masters: Masters::Indexed { positions: self.positions, nodes: paired.masters },
            domains: crate::Domains::Shared,
            plane_reach: frame.reach,
            t1: frame.t1,
            t2: frame.t2,
            normal: frame.normal,
            support_radius,
            point: [0.0; 2],
            anchor,
        }
    }

    /// Positions of the masters.
    fn masters<'s>(&'s self, paired: &Paired<'s>) -> impl ExactSizeIterator<Item = Point> + Clone + 's {
        paired.masters.iter().map(|&node| self.positions[node as usize])
    }

    /// The gap alone.
    pub fn gap(&self, paired: &Paired<'_>, scratch: &mut ElementScratch) -> Result<f64, NoContact> {
        self.element(paired, Mode::Value, &mut [], &mut [], scratch).map(|point| point.gap)
    }

    /// One element, N into `gradient` and M into `hessian` as far as the mode asks for them.
    pub fn element(
        &self,
        paired: &Paired<'_>,
        mode: Mode,
        gradient: &mut [f64],
        hessian: &mut [f64],
        scratch: &mut ElementScratch,
    ) -> Result<ContactPoint, NoContact> {
        let slave = self.positions[paired.slave];
        let (point, beyond) = match self.options.element {
            ContactElement::Diffuse { weight, .. } => {
                let (frame, masters) = self.frame(paired, scratch)?;
                let (support_radius, basis) = (paired.record.support_radius, paired.record.basis);
                let element =
                    Element::new(slave, masters, frame, support_radius).with_basis(basis).with_weight(weight);
                let point = Generated.gap_into(&element, mode, gradient, hessian);
                return self.within_border(paired, point, &mut scratch.border);
            }
            ContactElement::NodeToFacet => {
                let element = FacetElement { slave, corners: self.gather(paired, scratch) };
                let found = Generated.facet_gap_into(&element, mode, gradient, hessian)?;
                // Off its facet, the foot may lie over a neighbour or beyond the neighbour's end.
                let beyond = if element.contains(found.natural, 0.0) {
                    0.0
                } else {
                    let ElementScratch { corners, patch, border, .. } = scratch;
                    corners.clear();
                    corners.extend_from_slice(paired.masters);
                    corners.sort_unstable();
                    self.creases.patch(self.surface, paired.record.facet, corners, patch);
                    self.creases.beyond(self.surface, self.positions, patch, found.point.foot, border)
                };
                (found.point, beyond)
            }
        };
        self.check_border(beyond)?;
        Ok(point)
    }

    /// The result of a diffuse element, if its foot lies on its patch.
    fn within_border(
        &self,
        paired: &Paired<'_>,
        point: Result<ContactPoint, ElementError>,
        border: &mut BorderScratch,
    ) -> Result<ContactPoint, NoContact> {
        if !paired.patch.is_empty() {
            // A slave that has slid far beyond the border has no fit any more: the border is the reason.
            let foot = match &point {
                Ok(point) => point.foot,
                Err(error @ ElementError::BeyondCentreOfCurvature { .. }) => return Err((*error).into()),
                Err(_) => self.positions[paired.slave],
            };
            let beyond = self.creases.beyond(self.surface, self.positions, paired.patch, foot, border);
            self.check_border(beyond)?;
        }
        point.map_err(NoContact::from)
    }

    fn check_border(&self, beyond: f64) -> Result<(), NoContact> {
        let tolerance = self.options.border_tolerance;
        if beyond > tolerance { Err(NoContact::BeyondBorder { distance: beyond, tolerance }) } else { Ok(()) }
    }

    /// The frame of a diffuse element: the one that is held, or the average plane of the masters, outward where the
    /// slave's facet is now.
    fn current_frame(&self, paired: &Paired<'_>) -> Result<Frame, NoContact> {
        if let Some(frame) = paired.frame {
            return Ok(*frame);
        }
        let facet = self.surface.shape(paired.record.facet as usize, self.positions);
        Ok(Frame::average_plane_of(self.masters(paired).map(|x| (x, 1.0)), 0.0, facet.normal().into())?)
    }

    /// The frame of a diffuse element: the one that is held, or the average plane of the masters, outward where the
    /// slave's facet is now. With it the masters' positions.
    pub fn frame<'s>(
        &self,
        paired: &Paired<'_>,
        scratch: &'s mut ElementScratch,
    ) -> Result<(Frame, &'s [Point]), NoContact> {
        Ok((self.current_frame(paired)?, self.gather(paired, scratch)))
    }

    pub fn gather<'s>(&self, paired: &Paired<'_>, scratch: &'s mut ElementScratch) -> &'s [Point] {
        scratch.masters.clear();
        scratch.masters.extend(paired.masters.iter().map(|&node| self.positions[node as usize]));
        &scratch.masters
    }

    /// What stands in the place of the held frame of a slave without a pairing, so that frames are found by the
    /// number of the slave.
    pub fn stand_in_frame(&self) -> Option<Frame> {
        let [t1, t2, normal] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        self.holds_frames().then_some(Frame {
            origin: [0.0; 3],
            t1,
            t2,
            normal,
            derivative: FrameDerivative::Frozen,
            reach: 0.0,
        })
    }

    /// The frame that is held from now on for these masters, if frames are held.
    pub fn held_frame(
        &self,
        paired: &Paired<'_>,
        scratch: &mut ElementScratch,
    ) -> Result<Option<Frame>, NoContact> {
        if !self.holds_frames() {
            return Ok(None);
        }
        let (frame, _) = self.frame(&Paired { frame: None, ..*paired }, scratch)?;
        Ok(Some(frame.frozen()))
    }

    const fn holds_frames(&self) -> bool {
        matches!(self.options.element, ContactElement::Diffuse { frame: FrameDerivative::Frozen, .. })
    }
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
