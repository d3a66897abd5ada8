//! The tangent of contact as an operator.

use std::cell::RefCell;

use diffuse_contact::assembly::{AssemblyError, TangentOperator};

use crate::named::named;
use crate::system::Operator;

/// How the tangent of contact takes part in linear systems.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactTangent {
    /// All of it is assembled.
    #[default]
    Assembled,
    /// ε N Nᵀ is assembled, for the preconditioner, too; the rest of the exact tangent, −f M and friction, is an operator: no M is ever made.
    Operator,
}

named!(ContactTangent { Assembled => "assembled", Operator => "operator" });

/// −f M of all contacts that carry force, and what friction adds.
#[derive(Debug)]
pub struct ContactOperator {
    /// One for each pass. They keep what a product works with, so that products change them.
    passes: RefCell<Vec<TangentOperator>>,
}

impl ContactOperator {
    pub(super) fn new(passes: Vec<TangentOperator>) -> Self {
        Self { passes: RefCell::new(passes) }
    }
}

impl Operator for ContactOperator {
    fn add_product(&self, x: &[[f64; 3]], y: &mut [[f64; 3]]) -> Result<(), (usize, f64)> {
        self.passes.borrow_mut().iter_mut().try_for_each(|pass| {
            pass.add_product(x.as_flattened(), y.as_flattened_mut()).map_err(|error| match error {
                AssemblyError::Overflow { equation, .. } => (equation, y.as_flattened()[equation]),
                AssemblyError::NonFiniteEntry { equation, value, .. } => (equation, value),
                other => unreachable!("all vectors are over the nodes of the problem: {other}"),
            })
        })
    }

    fn bytes(&self) -> usize {
        self.passes.borrow().iter().map(TangentOperator::bytes).sum()
    }
}
