//! Second derivatives where the residuals depend on outer unknowns: these are eliminated last.
//!
//! Let r₁(α, θ, x) = 0 define α for given θ, and r₂(θ, x) = 0 define θ. While x is held, the unknowns and their adjoint
//! ones follow θ,
//!
//! ```text
//! A₁ Z = Σ ∂ρ₁/∂θ,   A₁ Z' = Σ ∂²Λ₁/∂α∂θ + K Z        Z = dα/dθ,  Z' = dλ/dθ
//! ```
//!
//! so that the Lagrangian's derivative by θ, with α and λ following, is the node expression
//! Λ_θ = ∂Λ/∂θ + Zᵀ ∂Λ₁/∂α + Z'ᵀ ρ₁. With C₂ = ∂Λ_θ/∂x and the reduced K₂ = d²L/dθ², θ is a block of its own beside
//! α: its factors are L₂⁻¹B₂ and L₂⁻¹C₂ + H₂ L₂⁻¹B₂, and those of α are the same as if θ were held. Per node, an outer
//! unknown costs a scalar's gradient; neither Z nor Z' is multiplied with a factor.

use super::factors::ScaledVector;
use super::fit_derivatives::{Block, Functional, Lagrangian, NodeProblem, solved};
use super::follower::Follower;
use crate::graph::{ExprId, Graph};

/// How the unknowns of interest move with an outer unknown.
struct Motion {
    follower: Follower,
    /// ∂Λ₁/∂θ
    lagrangian: ExprId,
    /// Σ ∂²Λ₁/∂α∂θ
    change: Vec<ExprId>,
    /// A₁ Z'
    adjoint_change: Vec<ExprId>,
    /// Z
    unknowns: Vec<ExprId>,
    /// Z'
    adjoint: Vec<ExprId>,
}

impl NodeProblem {
    /// Λ_θ and the lower triangle of K₂; `by_unknowns` is ∂Λ₁/∂α.
    pub(super) fn reduced(
        &self,
        g: &mut Graph,
        outer: &Block,
        functional: &Functional,
        lagrangian: &Lagrangian,
        by_unknowns: &[ExprId],
    ) -> (Vec<ExprId>, Vec<Vec<ExprId>>) {
        let motions: Vec<Motion> = outer
            .unknowns
            .iter()
            .map(|&unknown| self.motion(g, functional, lagrangian, by_unknowns, unknown))
            .collect();
        let by_outer = motions
            .iter()
            .map(|motion| {
                let outer = motion.follower.total_derivative(g, lagrangian.outer);
                let name = g.symbol_data(motion.follower.parameter()).name.clone();
                let by_alpha = self.along(g, by_unknowns, &motion.unknowns, &format!("p_alpha_{name}"));
                let by_lambda =
                    self.along(g, &self.block.residual, &motion.adjoint, &format!("p_lambda_{name}"));
                g.total(&[motion.lagrangian, by_alpha, by_lambda, outer])
            })
            .collect();
        let second = (0..motions.len())
            .map(|row| {
                (0..=row)
                    .map(|column| {
                        let pair = [&motions[row], &motions[column]];
                        self.second_derivative(g, outer, lagrangian, pair)
                    })
                    .collect()
            })
            .collect();
        (by_outer, second)
    }

    fn motion(
        &self,
        g: &mut Graph,
        functional: &Functional,
        lagrangian: &Lagrangian,
        by_unknowns: &[ExprId],
        unknown: ExprId,
    ) -> Motion {
        let system = self.block.system;
        let follower = self.coordinates.follower(g, unknown);
        let name = g.symbol_data(follower.parameter()).name.clone();
        let by_unknown = follower.total_derivative(g, lagrangian.inner);
        g.name(by_unknown, &format!("lagrangian_{}_{name}", functional.name));
        let residual_change = self.sums_of_changes(g, &self.block.residual, &follower);
        let unknowns = solved(g, system, &residual_change, &format!("alpha_{name}"));
        let change = self.sums_of_changes(g, by_unknowns, &follower);
        let adjoint_change: Vec<ExprId> = (0..change.len())
            .map(|row| {
                let second: Vec<ExprId> = (0..change.len())
                    .map(|column| functional.second[row.max(column)][row.min(column)])
                    .collect();
                let by_motion = g.dot(&second, &unknowns);
                g.add(change[row], by_motion)
            })
            .collect();
        let adjoint = solved(g, system, &adjoint_change, &format!("lambda_{}_{name}", functional.name));
        Motion { follower, lagrangian: by_unknown, change, adjoint_change, unknowns, adjoint }
    }

    /// Σ dv/dθ over the nodes for a vector v of the residuals' length, θ moving what the coordinates say.
    fn sums_of_changes(&self, g: &mut Graph, vector: &[ExprId], follower: &Follower) -> Vec<ExprId> {
        let mut total = vec![g.zero(); vector.len()];
        for ScaledVector { scale, direction } in self.block.split(g, vector) {
            // d(s p) = ds p + s dp, where dp is the sum of ∂p/∂X dX, and s dX the same for all components.
            let change_of_scale = follower.total_derivative(g, scale);
            let steps: Vec<_> =
                follower.moves().iter().map(|&(variable, change)| (variable, g.mul(scale, change))).collect();
            for (total, &p) in total.iter_mut().zip(&direction) {
                let mut change = g.mul(change_of_scale, p);
                let explicit = g.derivative(p, follower.parameter());
                let explicit = g.mul(scale, explicit);
                change = g.add(change, explicit);
                for &(variable, step) in &steps {
                    let partial = g.derivative(p, variable);
                    let product = g.mul(partial, step);
                    change = g.add(change, product);
                }
                let sum = self.sum_at_values(g, change);
                *total = g.add(*total, sum);
            }
        }
        total
    }

    /// coefficients · v for a vector v of the residuals' length: a scalar times a scalar in each group.
    fn along(&self, g: &mut Graph, vector: &[ExprId], coefficients: &[ExprId], name: &str) -> ExprId {
        let mut total = g.zero();
        for ScaledVector { scale, direction } in self.block.split(g, vector) {
            let along = g.dot(coefficients, &direction);
            g.name(along, name);
            let term = g.mul(scale, along);
            total = g.add(total, term);
        }
        total
    }

    /// d²L/dθdθ' = ∂²L/∂θ∂θ' + Zᵀ ∂²L/∂α∂θ' + (∂²L/∂θ∂α + Zᵀ K) Z'
    fn second_derivative(
        &self,
        g: &mut Graph,
        outer: &Block,
        lagrangian: &Lagrangian,
        [row, column]: [&Motion; 2],
    ) -> ExprId {
        let sum_of_change = |g: &mut Graph, first: ExprId| {
            let second = column.follower.total_derivative(g, first);
            self.sum_at_values(g, second)
        };
        let inner = sum_of_change(g, row.lagrangian);
        let of_residuals: Vec<ExprId> = outer
            .residual
            .iter()
            .map(|&residual| {
                let first = row.follower.total_derivative(g, residual);
                sum_of_change(g, first)
            })
            .collect();
        let outer = g.dot(&lagrangian.outer_adjoint, &of_residuals);
        let through_alpha = g.dot(&row.unknowns, &column.change);
        let through_lambda = g.dot(&row.adjoint_change, &column.unknowns);
        g.total(&[inner, outer, through_alpha, through_lambda])
    }
}
