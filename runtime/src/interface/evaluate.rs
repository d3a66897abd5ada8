//! One element at the positions of the moment, and all of them in parallel.

use super::contacts::{Layout, Slot, Slots};
use super::pairings::{Paired, Pairings};
use super::scratch::Pool;
use super::{ContactElement, InterfaceOptions, NoContact, Outcome};
use crate::surface::{BorderScratch, Creases, MasterSurface};
use crate::{
    ContactPoint, Element, ElementError, FacetElement, Frame, FrameDerivative, Generated, Mode, Point,
};

/// Slaves that one thread evaluates in a row.
pub const CHUNK: usize = 64;

/// What every element of an interface has in common.
#[derive(Clone, Copy, Debug)]
pub struct Evaluator<'a> {
    pub surface: &'a MasterSurface,
    pub creases: &'a Creases,
    /// Of all nodes.
    pub positions: &'a [Point],
    pub options: &'a InterfaceOptions,
}

/// Memory kept from one element to the next.
#[derive(Clone, Debug, Default)]
pub struct ElementScratch {
    masters: Vec<Point>,
    /// Nodes of a facet, ascending.
    corners: Vec<u32>,
    border: BorderScratch,
}

impl Evaluator<'_> {
    /// Fills the slots of consecutive slaves. Which thread fills a slot, and after which others, makes no
    /// difference to what it gets.
    pub fn fill(&self, pairings: &Pairings, mode: Mode, slots: Slots<'_>, pool: &Pool<ElementScratch>) {
        let layout: &Layout = &pairings.layout;
        if slots.len() > CHUNK {
            let half = slots.len().div_ceil(2 * CHUNK) * CHUNK;
            let (first, second) = slots.split(layout, half);
            rayon::join(
                || self.fill(pairings, mode, first, pool),
                || self.fill(pairings, mode, second, pool),
            );
            return;
        }
        pool.with(ElementScratch::default, |scratch| {
            slots.for_each(layout, |slot| {
                let Slot { index, outcome, point, gradient, hessian } = slot;
                let result = pairings.get(index).and_then(|paired| {
                    let point = self.element(&paired, mode, gradient, hessian, scratch)?;
                    Ok((point, paired.record.fallback))
                });
                (*outcome, *point) = match result {
                    Ok((point, fallback)) => (Outcome::Contact { fallback }, point),
                    Err(reason) => (Outcome::None(reason), ContactPoint::default()),
                };
            });
        });
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
                let element = Element { slave, masters, frame, support_radius, basis, weight };
                let point = Generated.gap_into(&element, mode, gradient, hessian);
                // A slave that has slid far beyond the border has no fit any more: the border is the reason.
                let foot = match &point {
                    Ok(point) => point.foot,
                    Err(error @ ElementError::BeyondCentreOfCurvature { .. }) => return Err((*error).into()),
                    Err(_) => slave,
                };
                let beyond = if paired.record.ends_near {
                    let patch = (paired.record.facet, paired.masters);
                    self.creases.beyond(self.surface, self.positions, patch, foot, &mut scratch.border)
                } else {
                    0.0
                };
                (point.map_err(NoContact::from), beyond)
            }
            ContactElement::NodeToFacet => {
                let element = FacetElement { slave, corners: self.gather(paired, scratch) };
                let found = Generated.facet_gap_into(&element, mode, gradient, hessian)?;
                // Off its facet, the foot may lie over a neighbour or beyond the neighbour's end.
                let beyond = if element.contains(found.natural, 0.0) {
                    0.0
                } else {
                    let ElementScratch { corners, border, .. } = scratch;
                    corners.clear();
                    corners.extend_from_slice(paired.masters);
                    corners.sort_unstable();
                    let patch = (paired.record.facet, corners.as_slice());
                    self.creases.beyond(self.surface, self.positions, patch, found.point.foot, border)
                };
                (Ok(found.point), beyond)
            }
        };
        let tolerance = self.options.border_tolerance;
        if beyond > tolerance {
            return Err(NoContact::BeyondBorder { distance: beyond, tolerance });
        }
        point
    }

    /// The frame of a diffuse element: the one that is held, or the average plane of the masters, outward where the
    /// slave's facet is now. With it the masters' positions.
    pub fn frame<'s>(
        &self,
        paired: &Paired<'_>,
        scratch: &'s mut ElementScratch,
    ) -> Result<(Frame, &'s [Point]), NoContact> {
        let masters = self.gather(paired, scratch);
        let frame = match paired.frame {
            Some(frame) => *frame,
            None => {
                let facet = self.surface.shape(paired.record.facet as usize, self.positions);
                Frame::average_plane(masters, facet.normal().into())?
            }
        };
        Ok((frame, masters))
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
