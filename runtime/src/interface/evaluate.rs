//! Gaps of all slaves with the derivatives that are asked for: into arrays, or one by one.

use std::ops::Range;
use std::sync::Arc;

use super::contacts::Results;
use super::evaluator::Evaluator;
use super::fill::{CHUNK, Request};
use super::scratch::ElementScratch;
use super::{ContactInterface, ContactRef, Contacts, InterfaceError, NoContact, PairedElement};
use crate::Mode;

impl ContactInterface {
    /// The contact of every slave at the positions of the last [`update`](Self::update) or
    /// [`refresh_pairing`](Self::refresh_pairing), with the derivatives that `mode` asks for.
    ///
    /// # Errors
    /// [`InterfaceError::NotRefreshed`] before the first refresh; [`InterfaceError::OutOfMemory`]: a Hessian over 16 masters takes 10.6 kB, see [`for_each`](Self::for_each).
    pub fn evaluate(&mut self, mode: Mode) -> Result<&Contacts, InterfaceError> {
        self.evaluate_as(Request::all(mode))
    }

    /// As [`evaluate`](Self::evaluate), but with derivatives only where `is_loaded` says so of the index of a slave, its gap and its
    /// tributary area; the gradient and the Hessian of others are empty. With the forces of a
    /// [`ContactLaw`](crate::assembly::ContactLaw), `|k, gap, area| law.normal_force(k, gap, area).force > 0.0`, residual and tangent by this
    /// law are those of all contacts, bit for bit: nothing else is read for them.
    ///
    /// All gaps are evaluated first, in [`Mode::Value`], so where most contacts carry force this takes longer. What is
    /// derived is as [`evaluate`](Self::evaluate) gives it, bit for bit; gaps that are not derived differ by
    /// rounding, which decides where a force is zero to rounding, or a foot on the limit of the border.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn evaluate_where(
        &mut self,
        mode: Mode,
        is_loaded: impl Fn(usize, f64, f64) -> bool + Sync,
    ) -> Result<&Contacts, InterfaceError> {
        let layout = Arc::clone(&self.pairings.layout);
        let is_loaded = |k: usize, gap: f64| is_loaded(k, gap, layout.area(k));
        self.evaluate_as(Request { mode, is_loaded: Some(&is_loaded) })
    }

    /// Whether slaves have been paired since the interface was made, or got planes of symmetry.
    pub(crate) fn check_refreshed(&self) -> Result<(), InterfaceError> {
        if self.pairings.is_made { Ok(()) } else { Err(InterfaceError::NotRefreshed) }
    }

    fn evaluate_as(&mut self, request: Request<'_>) -> Result<&Contacts, InterfaceError> {
        self.check_refreshed()?;
        let Self {
            master,
            options,
            positions,
            creases,
            nodal,
            anchors,
            augmented,
            own,
            pairings,
            contacts,
            elements,
            ..
        } = self;
        let (nodal, committed, own) = (nodal.as_ref(), anchors.as_deref(), own.as_ref());
        let anchors = augmented.as_deref().or(committed);
        let evaluator =
            Evaluator { surface: master, creases, positions, options, nodal, anchors, committed, own };
        let slots = contacts.start(&pairings.layout, request.mode, anchors.is_some())?;
        evaluator.fill(pairings, request, slots, elements);
        Ok(contacts)
    }

    /// Hands the contact of every slave to `f`, in the order of the slaves, without holding them all: 256 times
    /// the number of threads are evaluated in parallel, handed over one by one by the calling thread, and
    /// forgotten. They are the same as those of [`evaluate`](Self::evaluate), bit for bit.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn for_each<F>(&self, mode: Mode, mut f: F) -> Result<(), InterfaceError>
    where
        F: FnMut(ContactRef<'_>),
    {
        self.check_refreshed()?;
        let mut results = Results::default();
        // One chunk for each thread: more of them leave the processor's cache before they are handed over.
        let batch = CHUNK * rayon::current_num_threads();
        let all = self.pairings.all();
        all.clone().step_by(batch).try_for_each(|start| {
            self.evaluate_range(start..all.end.min(start + batch), mode, &mut results, &mut f)
        })
    }

    /// Evaluates some consecutive slaves into `results` and hands them over one by one.
    pub(crate) fn evaluate_range(
        &self,
        range: Range<usize>,
        mode: Mode,
        results: &mut Results,
        f: impl FnMut(ContactRef<'_>),
    ) -> Result<(), InterfaceError> {
        let contact = self.evaluate_request(range.clone(), Request::all(mode), results)?;
        range.map(contact).for_each(f);
        Ok(())
    }

    /// Evaluates some consecutive slaves into `results`, with derivatives where `is_loaded` says so, and tells how to look at them.
    pub(crate) fn evaluate_loaded<'a>(
        &'a self,
        range: Range<usize>,
        mode: Mode,
        is_loaded: &(dyn Fn(usize) -> bool + Sync),
        results: &'a mut Results,
    ) -> Result<impl Fn(usize) -> ContactRef<'a> + Sync + 'a, InterfaceError> {
        let by_gap = |k: usize, _gap: f64| is_loaded(k);
        // Without the gaps that come first where only some are derived.
        let all = range.clone().all(is_loaded);
        let request = Request { mode, is_loaded: if all { None } else { Some(&by_gap) } };
        self.evaluate_request(range, request, results)
    }

    fn evaluate_request<'a>(
        &'a self,
        range: Range<usize>,
        request: Request<'_>,
        results: &'a mut Results,
    ) -> Result<impl Fn(usize) -> ContactRef<'a> + Sync + use<'a>, InterfaceError> {
        let layout = &self.pairings.layout;
        let slots = results.start(layout, range, request.mode, self.anchors.is_some())?;
        self.evaluator().fill(&self.pairings, request, slots, &self.elements);
        let results = &*results;
        Ok(move |k| results.get(layout, k))
    }

    pub(super) fn evaluator(&self) -> Evaluator<'_> {
        let Self { master, options, positions, creases, nodal, anchors, own, .. } = self;
        let (nodal, committed, own) = (nodal.as_ref(), anchors.as_deref(), own.as_ref());
        let anchors = self.present_anchors();
        Evaluator { surface: master, creases, positions, options, nodal, anchors, committed, own }
    }

    /// The element of the `k`-th slave at the positions of the moment, to be looked at or evaluated by itself.
    ///
    /// # Errors
    /// [`NoContact`] if the slave is not paired or its masters have no average plane.
    ///
    /// # Panics
    /// If there is no such slave.
    pub fn element(&self, k: usize) -> Result<PairedElement, NoContact> {
        let (pairings, evaluator) = (&self.pairings, self.evaluator());
        evaluator.paired_element(&pairings.get(k)?, &mut ElementScratch::default())
    }
}
