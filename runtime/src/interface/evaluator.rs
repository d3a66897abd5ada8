//! One element at the positions of the moment, and all of them in parallel.

use diffuse_contact_kernels::support::{ElementInputs, Masters};

use super::anchors::{Anchor, Tracked};
use super::contacts::{Layout, SlipSlot, Slot, Slots};
use super::fold::{AnchorSource, Source, fold, fold_with_anchor};
use super::nodal::Nodal;
use super::pairings::{Paired, Pairings};
use super::within_reach::WithinReach;
use super::{ContactElement, InterfaceOptions, NoContact, Outcome};
use crate::batch::{Asked, BatchScratch, GapSlot, Waiting, contact_point, evaluate};
use crate::element::nearest_in_plane;
use crate::facet::{SlipNumbers, facet_slip};
use crate::kernels::frame_rule;
use crate::neighbourhood::Fallback;
use crate::scratch::{Pool, recycled};
use crate::surface::{BorderScratch, Creases, MasterSurface, OwnSurface, Shape, Symmetry};
use crate::{
    ContactPoint, Domains, Element, ElementError, FacetElement, Frame, FrameDerivative, Generated, Mode,
    Point, Weight,
};

/// Slaves that one thread evaluates in a row: enough for full vectors although numbers of masters differ.
pub const CHUNK: usize = 256;

/// In facets: a slave as deep as this whose own place is as far beyond the border has no foot inside.
const FAR: f64 = 0.5;

/// What every element of an interface has in common.
#[derive(Clone, Copy, Debug)]
pub struct Evaluator<'a> {
    pub surface: &'a MasterSurface,
    pub creases: &'a Creases,
    /// Of all nodes.
    pub positions: &'a [Point],
    pub options: &'a InterfaceOptions,
    /// The domains of the surface's nodes, if the options ask for them.
    pub nodal: Option<&'a Nodal>,
    /// Where slaves stuck, if slips are tracked.
    pub anchors: Option<&'a [Option<Anchor>]>,
    /// Those of the last accepted step.
    pub committed: Option<&'a [Option<Anchor>]>,
    /// What slaves may touch, if the surface is in contact with itself.
    pub own: Option<&'a OwnSurface>,
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
    results: Vec<Result<(ContactPoint, Fallback), NoContact>>,
}

/// A copy has no memory yet.
impl Clone for Lists {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// What the elements of one piece of work have in common.
#[derive(Clone, Copy)]
struct Run<'s> {
    pairings: &'s Pairings,
    weight: Weight,
    /// With nodal domains.
    within_reach: Option<&'s WithinReach>,
}

/// Memory kept from one element to the next.
#[derive(Clone, Debug, Default)]
pub struct ElementScratch {
    masters: Vec<Point>,
    /// Nodes of a facet, ascending.
    corners: Vec<u32>,
    /// Facets around it.
    patch: Vec<u32>,
    pub border: BorderScratch,
    pub batch: BatchScratch,
    lists: Lists,
    pub within_reach: WithinReach,
    /// Which slots are evaluated.
    chosen: Vec<bool>,
    /// Derivatives by points some of which are images, or by an anchor.
    by_points: Vec<f64>,
    carriers: Vec<AnchorSource>,
    /// Rows of an anchor in a Hessian.
    rows: Vec<f64>,
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
        let result = pairings.get(slot.index).and_then(|paired| {
            let point = self.element(&paired, mode, slot.gradient, slot.hessian, scratch)?;
            let own = derivatives(mode, self.corners_of(&paired).len());
            let by_carriers = [slot.gradient.get_mut(own.0..), slot.hessian.get_mut(own.1..)];
            by_carriers.into_iter().flatten().for_each(|entries| entries.fill(0.0));
            if let Some(slip) = &mut slot.slip {
                *slip.tracked = Tracked::default();
                if let (Some(anchor), true) = (self.anchor(slot.index), mode >= Mode::Gradient) {
                    self.fill_slip_of_facet(&paired, anchor, mode, slip, scratch)?;
                }
            }
            Ok((point, paired.record.fallback))
        });
        write(result, slot.outcome, slot.point);
    }

    /// The slip of such an element, by the nodes listed for its slave.
    fn fill_slip_of_facet(
        &self,
        paired: &Paired<'_>,
        anchor: &Anchor,
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
        Self::anchor_sources(paired, anchor, carriers);
        let sources: [Source; 4] = std::array::from_fn(|k| Source { listed: k as u32, image: None });
        let (gradient, hessian) = derivatives(mode, count + 1);
        fold_with_anchor(
            (&numbers.gradient[..gradient], &numbers.hessian[..hessian]),
            (slip.gradient, slip.hessian),
            (&sources[..count], carriers),
            &Symmetry::default(),
            rows,
        );
        *slip.tracked = Tracked { is_anchored: true, half_square, opening: anchor.opening };
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
        let run = Run { pairings, weight, within_reach: self.nodal.map(|_| &within_reach) };
        let mut border = Border::Tested;
        if request.is_loaded.is_some() {
            self.side_by_side(run, (Mode::Value, border), &mut slots, scratch, |_| true);
            border = Border::Met;
        }
        for slip in slots.iter_mut().filter_map(|slot| slot.slip.as_mut()) {
            *slip.tracked = Tracked::default();
        }
        self.side_by_side(run, (request.mode, border), &mut slots, scratch, |slot| {
            *slot.derived = request
                .is_loaded
                .is_none_or(|is_loaded| slot.outcome.is_contact() && is_loaded(slot.index, slot.point.gap));
            *slot.derived
        });
        scratch.lists.slots = recycled(slots);
        scratch.within_reach = within_reach;
    }

    /// Evaluates the slots that `choose` chooses. Their gradients and Hessians are used up by a mode that fills them.
    fn side_by_side<'s>(
        &'s self,
        run: Run<'s>,
        (mode, tests): (Mode, Border),
        slots: &mut [Slot<'_>],
        scratch: &mut ElementScratch,
        choose: impl Fn(&mut Slot<'_>) -> bool,
    ) {
        let Run { pairings, weight, within_reach } = run;
        let ElementScratch { border, batch, lists, chosen, by_points, carriers, rows, .. } = scratch;
        let mut waiting = recycled(std::mem::take(&mut lists.waiting));
        let mut places = recycled(std::mem::take(&mut lists.places));
        chosen.clear();
        chosen.extend(slots.iter_mut().map(&choose));
        // Derivatives by images, and by an anchor, have a place of their own before they go to the nodes.
        let anchor_of = |slot: &Slot<'_>| {
            let is_tracked = slot.slip.is_some() && mode >= Mode::Gradient;
            if is_tracked { self.anchor(slot.index) } else { None }
        };
        let room = |place: usize, slot: &Slot<'_>| {
            let points =
                within_reach.map_or(0, |all| all.elements[place].as_ref().map_or(0, |own| own.range.len()));
            if anchor_of(slot).is_some() {
                return Some(slip_derivatives(mode, points));
            }
            let has_images = pairings.get(slot.index).is_ok_and(|paired| !paired.images.is_empty());
            has_images.then(|| derivatives(mode, points))
        };
        let of_chosen = slots.iter().enumerate().filter(|(place, _)| chosen[*place]);
        let needed = of_chosen
            .filter_map(|(place, slot)| room(place, slot))
            .map(|(gradient, hessian)| gradient + hessian)
            .sum();
        by_points.resize(by_points.len().max(needed), 0.0);
        let mut free = &mut by_points[..];
        for (place, slot) in slots.iter_mut().enumerate() {
            if !chosen[place] {
                continue;
            }
            let paired = pairings.get(slot.index);
            let with_inputs = paired.and_then(|paired| match within_reach {
                Some(all) => {
                    let element = all.elements[place].as_ref().map_err(|reason| *reason)?;
                    Ok((paired, element.frame.derivative, all.inputs(self, &paired, element, weight)))
                }
                None => {
                    let frame = self.current_frame(&paired)?;
                    Ok((paired, frame.derivative, self.inputs(&paired, &frame, weight)))
                }
            });
            match with_inputs {
                Ok((paired, derivative, inputs)) => {
                    let ((gradient, hessian), listed) = match room(place, slot) {
                        None => {
                            let gradient = wanted(&mut slot.gradient, mode >= Mode::Gradient);
                            let hessian = wanted(&mut slot.hessian, mode >= Mode::Hessian);
                            ((gradient, hessian), within_reach.map_or(&[][..], |all| all.listed(place)))
                        }
                        Some((gradient, hessian)) => {
                            let (own, rest) = std::mem::take(&mut free).split_at_mut(gradient + hessian);
                            free = rest;
                            (own.split_at_mut(gradient), &[][..])
                        }
                    };
                    let anchor = anchor_of(slot).map(|anchor| self.anchor_position(anchor));
                    waiting.push(Waiting {
                        weight,
                        frame: frame_rule(derivative, &inputs.domains),
                        basis: paired.record.basis,
                        inputs: ElementInputs { anchor: anchor.unwrap_or(inputs.anchor), ..inputs },
                        has_slip: anchor.is_some(),
                        slot: GapSlot { gradient, hessian },
                        places: listed,
                        is_sound: true,
                    });
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
        evaluate(&Generated, Asked::Mode(mode), &mut waiting, batch, |index, element| {
            let (place, paired) = &places[index];
            let point = match tests {
                Border::Tested => self.within_border(paired, contact_point(&element.values), border),
                Border::Met => contact_point(&element.values).map_err(NoContact::from),
            };
            if let (Some(nodal), Some(all)) = (self.nodal, within_reach)
                && let (Ok(own), Ok(_)) = (&all.elements[*place], &point)
            {
                let sources = &all.sources[own.range.clone()];
                if let Some(anchor) = anchor_of(&slots[*place]) {
                    Self::anchor_sources(paired, anchor, carriers);
                    let tracked = Tracked {
                        is_anchored: true,
                        half_square: element.values.slip,
                        opening: anchor.opening,
                    };
                    let numbers = (&*element.gradient, &*element.hessian);
                    fold_both(
                        numbers,
                        tracked,
                        &mut slots[*place],
                        (sources, carriers),
                        &nodal.symmetry,
                        rows,
                    );
                } else if !paired.images.is_empty() {
                    let Slot { gradient, hessian, .. } = &mut slots[*place];
                    fold((element.gradient, element.hessian), (gradient, hessian), sources, &nodal.symmetry);
                }
            }
            results[index] = point.map(|point| (point, paired.record.fallback));
        });
        for ((place, _), result) in places.iter().zip(&results) {
            let slot = &mut slots[*place];
            write(*result, slot.outcome, slot.point);
        }
        (lists.waiting, lists.places, lists.results) = (recycled(waiting), recycled(places), results);
    }

    /// What a kernel reads of a paired slave.
    pub fn inputs<'s>(&'s self, paired: &Paired<'s>, frame: &Frame, weight: Weight) -> ElementInputs<'s> {
        let slave = self.positions[paired.slave];
        let support_radius = paired.record.support_radius;
        let pole = if weight.is_interpolating() {
            nearest_in_plane(slave, self.masters(paired), frame, |_| support_radius)
        } else {
            0
        };
        ElementInputs {
            slave,
            masters: Masters::Indexed { positions: self.positions, nodes: paired.masters },
            domains: Domains::Shared,
            plane_reach: frame.reach,
            t1: frame.t1,
            t2: frame.t2,
            normal: frame.normal,
            support_radius,
            point: [0.0; 2],
            anchor: [0.0; 3],
            pole,
        }
    }

    /// Positions of the masters.
    fn masters<'s>(&'s self, paired: &Paired<'s>) -> impl ExactSizeIterator<Item = Point> + Clone + 's {
        paired.masters.iter().map(|&node| self.positions[node as usize])
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

    /// One element without nodal domains, N into `gradient` and M into `hessian` as far as the mode asks for them.
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
                let element = FacetElement { slave, corners: self.gather_corners(paired, scratch) };
                let found = Generated.facet_gap_into(&element, mode, gradient, hessian)?;
                // Off its facet, the foot may lie over a neighbour or beyond the neighbour's end.
                let beyond = if element.contains(found.natural, 0.0) {
                    0.0
                } else {
                    let ElementScratch { corners, patch, border, .. } = scratch;
                    corners.clear();
                    corners.extend_from_slice(self.corners_of(paired));
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
    pub fn within_border(
        &self,
        paired: &Paired<'_>,
        point: Result<ContactPoint, ElementError>,
        border: &mut BorderScratch,
    ) -> Result<ContactPoint, NoContact> {
        // The fit over a facet in front may lead back to the slave's own place.
        if let (Some(own), Ok(found)) = (self.own, &point)
            && !OwnSurface::faces(self.surface, self.positions, paired.slave, found.normal.into())
        {
            return Err(NoContact::NothingOver { limit: own.limit() });
        }
        if !paired.patch.is_empty() {
            let slave = self.positions[paired.slave];
            let mut beyond_border =
                |x: Point| self.creases.beyond(self.surface, self.positions, paired.patch, x, border);
            let beyond = match &point {
                Ok(point) if !self.is_over(paired, point) => beyond_border(slave),
                Ok(point) => {
                    let beyond = beyond_border(point.foot);
                    // The fit of a slave far beyond the border may come back and put the foot inside, far below the slave.
                    let is_deep = point.gap < -FAR * self.facet(paired).extent();
                    let own = if is_deep { beyond_border(slave) } else { 0.0 };
                    if own > FAR { beyond.max(own) } else { beyond }
                }
                Err(error @ ElementError::BeyondCentreOfCurvature { .. }) => return Err((*error).into()),
                // A slave that has slid far beyond the border has no fit any more: the border is the reason.
                Err(_) => beyond_border(slave),
            };
            self.check_border(beyond)?;
        }
        point.map_err(NoContact::from)
    }

    /// The facet of a pairing as it lies now.
    fn facet(&self, paired: &Paired<'_>) -> Shape {
        self.surface.shape(paired.record.facet as usize, self.positions)
    }

    /// Whether the surface at the foot looks where the slave's facet does, within the angle that ends a patch.
    fn is_over(&self, paired: &Paired<'_>, point: &ContactPoint) -> bool {
        self.facet(paired).normal().dot(&point.normal.into())
            >= self.options.feature_angle_degrees.to_radians().cos()
    }

    fn check_border(&self, beyond: f64) -> Result<(), NoContact> {
        let tolerance = self.options.border_tolerance;
        if beyond > tolerance { Err(NoContact::BeyondBorder { distance: beyond, tolerance }) } else { Ok(()) }
    }

    /// The frame of a diffuse element: the one that is held, or the average plane of the masters, outward where the
    /// slave's facet is now.
    pub fn current_frame(&self, paired: &Paired<'_>) -> Result<Frame, NoContact> {
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

    /// The corners of a node-to-facet element's facet among the listed nodes.
    pub fn corners_of<'s>(&self, paired: &Paired<'s>) -> &'s [u32] {
        &paired.masters[..self.surface.facet(paired.record.facet as usize).corners().len()]
    }

    pub fn gather_corners<'s>(&self, paired: &Paired<'_>, scratch: &'s mut ElementScratch) -> &'s [Point] {
        self.gather(&Paired { masters: self.corners_of(paired), ..*paired }, scratch)
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
        let moving = Paired { frame: None, ..*paired };
        Ok(Some(self.frame(&moving, scratch)?.0.frozen()))
    }

    const fn holds_frames(&self) -> bool {
        matches!(self.options.element, ContactElement::Diffuse { frame: FrameDerivative::Frozen, .. })
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
