//! Contenders that take one element after another.

use crate::Elements;
use crate::contender::{Evaluation, NoResult, Run};

/// A contender that takes one element after another: `evaluate` computes element `index` into gradient and Hessian and
/// returns the gap.
pub(crate) struct OneByOne<'a, F> {
    elements: &'a Elements,
    evaluate: F,
    next: usize,
    gradient: Vec<f64>,
    hessian: Vec<f64>,
}

impl<'a, F> OneByOne<'a, F>
where
    F: FnMut(&Elements, usize, &mut [f64], &mut [f64]) -> Option<f64>,
{
    pub(crate) fn new(elements: &'a Elements, evaluate: F) -> Self {
        let freedoms = elements.degrees_of_freedom();
        let hessian = vec![0.0; freedoms * (freedoms + 1) / 2];
        Self { elements, evaluate, next: 0, gradient: vec![0.0; freedoms], hessian }
    }
}

impl<F> Run for OneByOne<'_, F>
where
    F: FnMut(&Elements, usize, &mut [f64], &mut [f64]) -> Option<f64>,
{
    fn run(&mut self, count: usize) -> Result<(), NoResult> {
        for _ in 0..count {
            let element = self.next;
            let value = (self.evaluate)(self.elements, element, &mut self.gradient, &mut self.hessian);
            std::hint::black_box(value.ok_or(NoResult { element })?);
            std::hint::black_box((&mut self.gradient, &mut self.hessian));
            self.next = if element + 1 == self.elements.len() { 0 } else { element + 1 };
        }
        Ok(())
    }

    fn evaluation(&mut self, element: usize) -> Result<Evaluation, NoResult> {
        self.gradient.fill(f64::NAN);
        self.hessian.fill(f64::NAN);
        let value = (self.evaluate)(self.elements, element, &mut self.gradient, &mut self.hessian)
            .ok_or(NoResult { element })?;
        Ok(Evaluation { value, gradient: self.gradient.clone(), hessian: self.hessian.clone() })
    }
}
