//! Running the backends on the same elements.

use std::sync::atomic::{AtomicBool, Ordering};

use diffuse_contact::ad::{Ad, FormulaError};
use diffuse_contact::{Backend, ElementError, Generated, Mode};
use diffuse_contact_codegen::Basis;
use rayon::prelude::*;

use super::balance::sums;
use super::blocks::{Blocks, Subject};
use super::elements::{NoElement, RandomElement};
use super::facets::compare_facets;
use super::plan::{Against, ELEMENTS, MODES, Plan, Tested};
use super::report::Report;
use crate::interpreted::Interpreted;
use crate::weight::Weight;

/// Why nothing can be compared.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum CompareError {
    #[error("automatic differentiation cannot use \"{formula}\": {reason}")]
    Ad { formula: String, reason: FormulaError },
    #[error(transparent)]
    NoElement(#[from] NoElement),
}

/// Compares the backends, on all cores; calls `step` after each element.
///
/// The tested backend, in each mode, is compared with automatic differentiation, with the interpreter in the same
/// mode, and in its lower modes with itself in Hessian mode.
///
/// # Errors
/// [`CompareError`]. A backend that has no result where it should is in the report, not an error.
pub fn compare(plan: &Plan, step: impl Fn() + Sync) -> Result<Report, CompareError> {
    let interpreted = Interpreted::new(plan.weight.for_generator());
    let ad: Box<dyn Backend> = match &plan.weight {
        Weight::BuiltIn(_) => Box::new(Ad),
        Weight::Formula(weight) => {
            let text = weight.text();
            let ad: Result<Box<dyn Backend>, FormulaError> = match weight.is_interpolating() {
                true => Ad::with_interpolating_formula(text).map(|ad| Box::new(ad) as _),
                false => Ad::with_weight_formula(text).map(|ad| Box::new(ad) as _),
            };
            ad.map_err(|reason| CompareError::Ad { formula: text.to_owned(), reason })?
        }
    };
    let backends = Backends {
        ad: &*ad,
        interpreted: &interpreted,
        generated: plan.weight.as_built_in().map(|_| &Generated as &dyn Backend),
    };
    let jobs: Vec<Job> = plan.jobs().collect();
    let has_failed = AtomicBool::new(false);
    let parts = jobs.par_iter().map(|job| {
        if has_failed.load(Ordering::Relaxed) {
            return None;
        }
        let part = job.run(plan, &backends);
        has_failed.fetch_or(part.is_err(), Ordering::Relaxed);
        step();
        Some(part)
    });
    // In the order of the plan, whichever was ready first.
    let mut report = Report::new(plan);
    for part in parts.collect::<Vec<_>>().into_iter().flatten() {
        report.merge(part?);
    }
    // Facets have no weight: they are compared once, beside the default one.
    if plan.weight == Weight::default() {
        report.add_facets(compare_facets(plan.seed));
    }
    Ok(report)
}

/// The comparisons of one element.
struct Job {
    basis: Basis,
    nodes: usize,
    index: usize,
}

impl Plan {
    fn jobs(&self) -> impl Iterator<Item = Job> + '_ {
        let counts = self.ranges.iter().flat_map(|(basis, range)| range.clone().map(|nodes| (*basis, nodes)));
        counts.flat_map(|(basis, nodes)| (0..ELEMENTS).map(move |index| Job { basis, nodes, index }))
    }
}

impl Job {
    fn run(&self, plan: &Plan, backends: &Backends<'_>) -> Result<Report, NoElement> {
        let &Self { basis, nodes, index } = self;
        let with = (plan.weight.as_built_in().unwrap_or_default(), backends.ad);
        let random = RandomElement::new(basis, nodes, plan.seed, index, backends.interpreted, with)?;
        let mut report = Report::new(plan);
        report.add_element(&random);
        for subject in Subject::ALL {
            Results { random: &random, subject, at: (basis, nodes), report: &mut report }.compare(backends);
        }
        Ok(report)
    }
}

struct Backends<'a> {
    ad: &'a dyn Backend,
    interpreted: &'a Interpreted,
    /// The kernels, if there are any with this weight.
    generated: Option<&'a dyn Backend>,
}

/// One subject of one element.
struct Results<'a> {
    random: &'a RandomElement,
    subject: Subject,
    at: (Basis, usize),
    report: &'a mut Report,
}

impl Results<'_> {
    fn compare(&mut self, backends: &Backends<'_>) {
        // Its derivatives are those of one function in every mode.
        let ad = self.evaluate("AD", backends.ad, Mode::Hessian, "hessian");
        let interpreted =
            MODES.map(|(mode, name)| self.evaluate("interpreter", backends.interpreted, mode, name));
        let has_kernels = self.report.tested(self.subject) == Tested::Generated;
        let generated = backends
            .generated
            .filter(|_| has_kernels)
            .map(|backend| MODES.map(|(mode, name)| self.evaluate("generated", backend, mode, name)));
        let tested = generated.as_ref().unwrap_or(&interpreted);
        for (mode, tested_in_mode) in tested.iter().enumerate() {
            self.add(Against::Ad, tested_in_mode.as_ref(), ad.as_ref());
            if generated.is_some() {
                self.add(Against::Interpreter, tested_in_mode.as_ref(), interpreted[mode].as_ref());
            }
            if mode + 1 < MODES.len() {
                self.add(Against::HessianMode, tested_in_mode.as_ref(), tested[MODES.len() - 1].as_ref());
            }
        }
        if let Some(gradient) = tested[MODES.len() - 1].as_ref().and_then(|tested| tested.entries("N")) {
            let sums = sums(&self.random.element(self.subject.frame), gradient);
            self.report.add_balance(self.subject, sums, self.at);
        }
    }

    /// A result, or nothing and a line in the report.
    fn evaluate(&mut self, who: &str, backend: &dyn Backend, mode: Mode, name: &str) -> Option<Blocks> {
        let result = Blocks::evaluate(backend, self.random, self.subject, mode);
        result.map_err(|reason| self.report.add_failure(who, self.subject, name, self.at, &reason)).ok()
    }

    fn add(&mut self, against: Against, found: Option<&Blocks>, expected: Option<&Blocks>) {
        if let (Some(found), Some(expected)) = (found, expected) {
            for (block, difference) in found.differences(expected) {
                self.report.add(block, against, difference, self.at);
            }
        }
    }
}

impl Report {
    fn add_failure(
        &mut self,
        who: &str,
        subject: Subject,
        mode: &str,
        at: (Basis, usize),
        reason: &ElementError,
    ) {
        let (basis, nodes) = (at.0.name(), at.1);
        self.failures.push(format!("{who} {} {mode}, {basis} n = {nodes}: {reason}", subject.name()));
    }
}
