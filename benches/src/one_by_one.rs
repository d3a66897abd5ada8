//! Contenders that take one element after another.

use crate::Elements;
use crate::contender::{Evaluation, NoResult, Output, Run};
use crate::generated::hessian_size;

/// A contender that takes one element after another: `evaluate` computes element `index` into gradient and Hessian and
/// returns the gap, or the value of a surface.
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
    /// With room for what the output has; T_1 and T_2 of a surface follow its gradient.
    pub(crate) fn new(elements: &'a Elements, output: Output, evaluate: F) -> Self {
        let gradients = if output == Output::SurfaceHessian { 3 } else { 1 };
        let gradient = vec![0.0; gradients * elements.degrees_of_freedom()];
        Self { elements, evaluate, next: 0, gradient, hessian: vec![0.0; hessian_size(elements, output)] }
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
        let gradient = self.gradient[..self.elements.degrees_of_freedom()].to_vec();
        Ok(Evaluation { value, gradient, hessian: self.hessian.clone() })
    }
}
