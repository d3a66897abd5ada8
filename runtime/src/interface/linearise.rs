//! The contacts that carry force with N and the factors of M, for products that need no matrix; or with the slave's rows of M, for faces.

use std::ops::Range;

use diffuse_contact_kernels::support::{ElementInputs, FrameRule, KernelSet, SecondKind, packed_row};
use rayon::prelude::*;

use super::contacts::{Results, resize};
use super::evaluator::Evaluator;
use super::fill::{CHUNK, Request};
use super::fold::FitPoint;
use super::pairings::{Paired, Pairings};
use super::scratch::ElementScratch;
use super::within_reach::WithinReach;
use super::{ContactElement, ContactInterface, InterfaceError};
use crate::batch::{Asked, GapSlot, Waiting, contact_point, evaluate};
use crate::kernels::frame_rule;
use crate::product::HessianForm;
use crate::weight::with_kernels;
use crate::{ContactPoint, Generated, Mode, Weight};

/// How the second derivatives of a contact are held.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SecondForm {
    /// They are not.
    None,
    /// As factors.
    Factors(HessianForm),
    /// As a packed lower triangle: of a facet, whose few nodes make it smaller than factors would be.
    Packed,
}

/// What is made beside gradients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Second {
    /// Nothing.
    None,
    /// Second derivatives.
    Hessians,
    /// φ and ∂ν/∂x; of facets second derivatives, which have them.
    AtFoot,
    /// The slave's rows of M, whatever the element.
    SlaveRows,
}

impl Second {
    /// How it is held, of an element whose factors have this form, and numbers of it.
    const fn of_fit(self, form: HessianForm) -> (SecondForm, usize) {
        match self {
            Self::None => (SecondForm::None, 0),
            Self::Hessians => (SecondForm::Factors(form), form.numbers()),
            Self::AtFoot => (SecondForm::Factors(form), form.foot_numbers()),
            Self::SlaveRows => (SecondForm::None, form.rows().slave_rows()),
        }
    }

    /// What kernels are asked for.
    const fn kernels(self) -> Asked {
        match self {
            Self::None => Asked::Mode(Mode::Gradient),
            Self::Hessians => Asked::Second(SecondKind::Factors),
            Self::AtFoot => Asked::Second(SecondKind::FactorsAndFoot),
            Self::SlaveRows => Asked::Second(SecondKind::SlaveRows),
        }
    }

    /// The same as [`of_fit`](Self::of_fit) of a facet with so many derivatives.
    const fn of_facet(self, freedoms: usize) -> (SecondForm, usize) {
        match self {
            Self::None => (SecondForm::None, 0),
            Self::Hessians | Self::AtFoot => (SecondForm::Packed, freedoms * (freedoms + 1) / 2),
            Self::SlaveRows => (SecondForm::None, 3 * freedoms),
        }
    }
}

/// A contact that carries force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearContact {
    /// Its slave, by place among the slaves.
    pub index: usize,
    /// Gaps are NaN where there is no result.
    pub point: ContactPoint,
    pub area: f64,
    /// Number of its points; they follow those of the contact before.
    pub points: usize,
    /// Where its gradient begins.
    pub gradient: usize,
    pub second: SecondForm,
    /// Where its second derivatives begin, or the slave's rows of them.
    pub second_start: usize,
}

/// The contacts of some consecutive slaves.
#[derive(Clone, Debug, Default)]
pub(crate) struct LinearContacts {
    pub contacts: Vec<LinearContact>,
    /// The points of all contacts.
    pub points: Vec<FitPoint>,
    /// N by slave and points.
    pub gradients: Vec<f64>,
    pub seconds: Vec<f64>,
}

/// No result.
const NONE: ContactPoint = ContactPoint { gap: f64::NAN, foot: [f64::NAN; 3], normal: [f64::NAN; 3] };

impl LinearContacts {
    fn allocate(&mut self, gradients: usize, seconds: usize) -> Result<(), InterfaceError> {
        resize(&mut self.gradients, gradients, 0.0)?;
        resize(&mut self.seconds, seconds, 0.0)
    }

    /// Gives each element its contact's numbers, and returns the contacts.
    fn hand_out<'s>(&'s mut self, waiting: &mut [Waiting<'_, 's>]) -> &'s mut [LinearContact] {
        let (mut gradients, mut seconds) = (&mut self.gradients[..], &mut self.seconds[..]);
        // From the last on: what begins at one's own place is one's own.
        for (contact, element) in self.contacts.iter().zip(waiting).rev() {
            element.slot.gradient = gradients.split_off_mut(contact.gradient..).unwrap_or_default();
            element.slot.hessian = seconds.split_off_mut(contact.second_start..).unwrap_or_default();
        }
        &mut self.contacts
    }
}

impl ContactInterface {
    /// The contacts for which `is_loaded` holds, of the index of the slave, its gap and its tributary area, at the positions of the last
    /// update: some hundred slaves in each part, in their order. The same for any number of threads.
    pub(crate) fn linearise(
        &self,
        with_second: bool,
        is_loaded: impl Fn(usize, f64, f64) -> bool + Sync,
    ) -> Result<Vec<LinearContacts>, InterfaceError> {
        self.check_refreshed()?;
        let all = self.pairings.all();
        let starts: Vec<usize> = all.clone().step_by(CHUNK).collect();
        let of_range =
            |start: usize| self.linearise_range(start..all.end.min(start + CHUNK), with_second, &is_loaded);
        starts.into_par_iter().map(of_range).collect()
    }

    fn linearise_range(
        &self,
        range: Range<usize>,
        with_second: bool,
        is_loaded: &impl Fn(usize, f64, f64) -> bool,
    ) -> Result<LinearContacts, InterfaceError> {
        let results = self.values_of(range.clone())?;
        let loaded: Vec<usize> = range
            .filter(|&k| {
                let contact = results.get(&self.pairings.layout, k);
                contact.outcome.is_contact() && is_loaded(k, contact.point.gap, contact.area)
            })
            .collect();
        self.linearise_slaves(&loaded, if with_second { Second::Hessians } else { Second::None })
    }

    /// The contacts of consecutive slaves, without derivatives.
    pub(super) fn values_of(&self, range: Range<usize>) -> Result<Results, InterfaceError> {
        let mut results = Results::default();
        let slots = results.start(&self.pairings.layout, range, Mode::Value, false)?;
        self.evaluator().fill(&self.pairings, Request::all(Mode::Value), slots, &self.elements);
        Ok(results)
    }

    /// The contacts of these slaves, which are contacts.
    pub(crate) fn linearise_slaves(
        &self,
        loaded: &[usize],
        second: Second,
    ) -> Result<LinearContacts, InterfaceError> {
        let (pairings, evaluator) = (&self.pairings, self.evaluator());
        let work = |scratch: &mut ElementScratch| match self.options.element {
            ContactElement::Diffuse { weight, .. } => {
                evaluator.linear_fits(pairings, loaded, weight, second, scratch)
            }
            ContactElement::NodeToFacet => evaluator.linear_facets(pairings, loaded, second, scratch),
        };
        self.elements.with(ElementScratch::default, work)
    }
}

impl Evaluator<'_> {
    /// Diffuse elements, those with the same number of points side by side. Feet have met the border before.
    fn linear_fits(
        &self,
        pairings: &Pairings,
        loaded: &[usize],
        weight: Weight,
        asked: Second,
        scratch: &mut ElementScratch,
    ) -> Result<LinearContacts, InterfaceError> {
        let ElementScratch { within_reach, batch, .. } = scratch;
        if self.nodal.is_some() {
            let paired = loaded.iter().map(|&k| pairings.get(k));
            self.gather_within_reach(paired, weight, within_reach);
        }
        let mut found = LinearContacts::default();
        let mut waiting: Vec<Waiting<'_, '_>> = Vec::with_capacity(loaded.len());
        let (mut gradients, mut seconds) = (0, 0);
        for (place, &index) in loaded.iter().enumerate() {
            let Ok(paired) = pairings.get(index) else { continue };
            let Some((frame, inputs)) = self.fit(&paired, weight, (within_reach, place), &mut found.points)
            else {
                continue;
            };
            let (basis, points) = (paired.record.basis, inputs.masters.len());
            let form = with_kernels!(weight, K => HessianForm::new(K::gap_form((basis, frame), points)));
            let (second, numbers) = asked.of_fit(form);
            found.contacts.push(LinearContact {
                index,
                point: NONE,
                area: pairings.layout.area(index),
                points,
                gradient: gradients,
                second,
                second_start: seconds,
            });
            waiting.push(Waiting {
                weight,
                frame,
                basis,
                inputs,
                has_slip: false,
                slot: GapSlot::default(),
                places: &[],
                is_sound: true,
            });
            gradients += 3 * (points + 1);
            seconds += numbers;
        }
        found.allocate(gradients, seconds)?;
        let contacts = found.hand_out(&mut waiting);
        evaluate(&Generated, asked.kernels(), &mut waiting, batch, |place, element| {
            // Without a result it stays a NaN, which carries no force.
            if let Ok(point) = contact_point(&element.values) {
                contacts[place].point = point;
            }
        });
        drop(waiting);
        Ok(found)
    }

    /// What the kernel of a contact reads, whose points are appended. `place`: among the elements within reach.
    fn fit<'s>(
        &'s self,
        paired: &Paired<'s>,
        weight: Weight,
        (within_reach, place): (&'s WithinReach, usize),
        points: &mut Vec<FitPoint>,
    ) -> Option<(FrameRule, ElementInputs<'s>)> {
        let (derivative, inputs) = if self.nodal.is_some() {
            let own = within_reach.elements[place].as_ref().ok()?;
            let sources = within_reach.sources[own.range.clone()].iter();
            points.extend(sources.map(|source| source.point(paired.masters)));
            (own.frame.derivative, within_reach.inputs(self.positions[paired.slave], own, weight))
        } else {
            let frame = self.current_frame(paired).ok()?;
            points.extend(paired.masters.iter().map(|&node| FitPoint::from(node)));
            (frame.derivative, self.inputs(paired, &frame, weight))
        };
        Some((frame_rule(derivative, &inputs.domains), inputs))
    }

    /// Elements of a node and a facet, one after another.
    fn linear_facets(
        &self,
        pairings: &Pairings,
        loaded: &[usize],
        asked: Second,
        scratch: &mut ElementScratch,
    ) -> Result<LinearContacts, InterfaceError> {
        let mut found = LinearContacts::default();
        let mode = if asked == Second::None { Mode::Gradient } else { Mode::Hessian };
        let freedoms = |points: usize| 3 * (points + 1);
        let points = |k: usize| pairings.get(k).map_or(0, |paired| self.corners_of(&paired).len());
        let gradients = loaded.iter().map(|&k| freedoms(points(k))).sum();
        let seconds = loaded.iter().map(|&k| asked.of_facet(freedoms(points(k))).1).sum();
        found.allocate(gradients, seconds)?;
        let mut packed = [0.0; packed_row(3 * (4 + 1))];
        let (mut gradient, mut second_start) = (0, 0);
        for &index in loaded {
            let Ok(paired) = pairings.get(index) else { continue };
            let corners = self.corners_of(&paired);
            let points = corners.len();
            let (second, numbers) = asked.of_facet(freedoms(points));
            let own_gradient = &mut found.gradients[gradient..][..freedoms(points)];
            let own_second = &mut found.seconds[second_start..][..numbers];
            let point = if asked == Second::SlaveRows {
                let packed = &mut packed[..packed_row(freedoms(points))];
                let point = self.element(&paired, mode, own_gradient, packed, scratch);
                for (row, entries) in own_second.chunks_exact_mut(freedoms(points)).enumerate() {
                    let entry = |column: usize| packed[packed_row(row.max(column)) + row.min(column)];
                    entries.iter_mut().zip(0..).for_each(|(target, column)| *target = entry(column));
                }
                point
            } else {
                self.element(&paired, mode, own_gradient, own_second, scratch)
            };
            let (point, area) = (point.unwrap_or(NONE), pairings.layout.area(index));
            found.points.extend(corners.iter().map(|&node| FitPoint::from(node)));
            found.contacts.push(LinearContact { index, point, area, points, gradient, second, second_start });
            gradient += freedoms(points);
            second_start += numbers;
        }
        Ok(found)
    }
}
