//! First derivatives of further quantities, as combinations of the rows that a Hessian is made of.
//!
//! A quantity G(α, θ) changes with the unknowns only, and their derivatives are rows B̂ of the form of low rank (`fit_derivatives`):
//!
//! ```text
//! dα/dx = A₁⁻¹ B₁ + Z dθ/dx,  dθ/dx = A₂⁻¹ B₂      Z = dα/dθ
//! dG/dx = vᵀ S₁ B̂₁ + wᵀ S₂ B̂₂                      L₁ v = ∂G/∂α,  L₂ w = ∂G/∂θ + Zᵀ ∂G/∂α
//! ```
//!
//! where A₂ is not symmetric, B̂₂ = A₂⁻¹ B₂ and w is the right-hand side itself. Beside a Hessian a first derivative costs a number for
//! each row, of element scope.

use super::elimination::Elimination;
use super::low_rank::LowRankForm;
use super::node_problem::NodeProblem;
use crate::expr::{Expr, dot, ids};
use crate::graph::ExprId;

impl<'g> NodeProblem<'g> {
    /// The coefficients c of dG/dx = Σ c b̂, b̂ the rows b of a Hessian's terms in their order. `first`: ∂G/∂α and ∂G/∂θ, both
    /// at the values; without the second, θ is held.
    ///
    /// # Panics
    /// If a row that the Hessian does without is needed.
    pub fn combination(
        &self,
        hessian: &LowRankForm,
        (by_alpha, by_theta): (&[Expr<'g>], Option<&[Expr<'g>]>),
    ) -> Vec<ExprId> {
        let solved = |system: &Elimination<'g>, v: &[Expr<'g>]| -> Vec<Expr<'g>> {
            system.right(v).into_iter().enumerate().map(|(k, x)| system.signed(k, x)).collect()
        };
        let mut all = solved(&self.block.system, by_alpha);
        if let Some(outer) = &self.outer {
            let total = |(&theta, &explicit): (&Expr<'g>, &Expr<'g>)| {
                explicit + dot(by_alpha, self.change_of_unknowns(theta))
            };
            let total: Vec<Expr<'g>> = match by_theta {
                Some(by_theta) => outer.unknowns.iter().zip(by_theta).map(total).collect(),
                None => vec![self.zero(); outer.unknowns.len()],
            };
            all.extend(solved(&outer.system, &total));
        }
        let rows: Vec<usize> = hessian.terms.iter().map(|term| term.row).collect();
        for (row, coefficient) in all.iter().enumerate() {
            assert!(rows.contains(&row) || coefficient.is_zero(), "row {row} is no part of the Hessian");
        }
        ids(&rows.into_iter().map(|row| all[row]).collect::<Vec<_>>())
    }
}
