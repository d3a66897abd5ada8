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
//! α: its factors are L₂⁻¹B₂ and L₂⁻¹C₂ + H₂ L₂⁻¹B₂, or A₂⁻¹B₂ and C₂ + H₂ A₂⁻¹B₂ where A₂ is not symmetric, and those of
//! α are the same as if θ were held. Per node, an outer unknown costs a scalar's gradient; neither Z nor Z' is multiplied
//! with a factor.

use super::factors::ScaledVector;
use super::follower::Follower;
use super::node_problem::{Block, Functional, Lagrangian, NodeProblem};
use crate::expr::{Expr, dot, total};

/// How the unknowns of interest move with an outer unknown.
struct Motion<'g> {
    follower: Follower<'g>,
    /// ∂Λ₁/∂θ
    lagrangian: Expr<'g>,
    /// ∂G/∂θ of the point that G depends on besides, with θ moving the point.
    point: Option<Expr<'g>>,
    /// Σ ∂²Λ₁/∂α∂θ
    change: Vec<Expr<'g>>,
    /// A₁ Z'
    adjoint_change: Vec<Expr<'g>>,
    /// Z
    unknowns: Vec<Expr<'g>>,
    /// Z'
    adjoint: Vec<Expr<'g>>,
}

/// What is left for the outer unknowns when those of interest follow them.
pub(super) struct Reduced<'g> {
    /// Λ_θ of a node.
    pub by_outer: Vec<Expr<'g>>,
    /// The same of the point that G depends on besides: dG/dθ.
    pub point_by_outer: Vec<Expr<'g>>,
    /// The lower triangle of K₂.
    pub second: Vec<Vec<Expr<'g>>>,
}

impl<'g> NodeProblem<'g> {
    /// Λ_θ and K₂; `by_unknowns` is ∂Λ₁/∂α.
    pub(super) fn reduced(
        &self,
        outer: &Block<'g>,
        functional: &Functional<'g>,
        lagrangian: &Lagrangian<'g>,
        by_unknowns: &[Expr<'g>],
    ) -> Reduced<'g> {
        let motion = |&theta: &Expr<'g>| self.motion(functional, lagrangian, by_unknowns, theta);
        let motions: Vec<Motion<'g>> = outer.unknowns.iter().map(motion).collect();
        let by_outer = motions.iter().map(|motion| {
            let outer = motion.follower.total_derivative(lagrangian.outer);
            let name = motion.follower.parameter().symbol_name();
            let by_alpha = self.along(by_unknowns, &motion.unknowns, &format!("p_alpha_{name}"));
            let by_lambda = self.along(&self.block.residual, &motion.adjoint, &format!("p_lambda_{name}"));
            motion.lagrangian + by_alpha + by_lambda + outer
        });
        let by_outer = by_outer.collect();
        let point_by_outer = functional.point.iter().flat_map(|point| {
            let explicit = motions.iter().filter_map(|motion| Some((motion.point?, &motion.unknowns)));
            explicit.map(|(explicit, unknowns)| explicit + dot(&point.by_unknowns, unknowns))
        });
        let point_by_outer = point_by_outer.collect();
        let second = |row: usize, column: usize| {
            let (row, column) = (&motions[row], &motions[column]);
            let second = self.second_derivative(lagrangian, row, column);
            match (&functional.point, row.point) {
                (Some(point), Some(explicit)) => second + point.change(explicit, column.follower.parameter()),
                _ => second,
            }
        };
        let second =
            (0..motions.len()).map(|row| (0..=row).map(|column| second(row, column)).collect()).collect();
        Reduced { by_outer, point_by_outer, second }
    }

    fn motion(
        &self,
        functional: &Functional<'g>,
        lagrangian: &Lagrangian<'g>,
        by_unknowns: &[Expr<'g>],
        theta: Expr<'g>,
    ) -> Motion<'g> {
        let (system, of) = (self.system(), &functional.name);
        let follower = self.coordinates.follower(theta);
        let name = theta.symbol_name();
        let by_theta = follower.total_derivative(lagrangian.inner).named(&format!("lagrangian_{of}_{name}"));
        let unknowns = self.change_of_unknowns(theta);
        let mut change = self.sums_of_changes(by_unknowns, &follower);
        if let Some(point) = &functional.point {
            for (change, &first) in change.iter_mut().zip(&point.by_unknowns) {
                *change += point.change(first, theta);
            }
        }
        let point = functional.point.as_ref().map(|point| point.total_derivative(point.value, theta));
        let size = change.len();
        let second = |row: usize, column: usize| functional.second[row.max(column)][row.min(column)];
        let adjoint_change: Vec<Expr<'g>> = (0..size)
            .map(|row| change[row] + dot((0..size).map(|column| second(row, column)), &unknowns))
            .collect();
        let adjoint = system.solve_bound(&adjoint_change, &format!("lambda_{of}_{name}"));
        Motion { follower, lagrangian: by_theta, point, change, adjoint_change, unknowns, adjoint }
    }

    /// Z, the change of the unknowns of interest with an outer one.
    pub(super) fn change_of_unknowns(&self, theta: Expr<'g>) -> Vec<Expr<'g>> {
        let change = self.sums_of_changes(&self.block.residual, &self.coordinates.follower(theta));
        self.system().solve_bound(&change, &format!("alpha_{}", theta.symbol_name()))
    }

    /// Σ dv/dθ over the nodes for a vector v of the residuals' length, θ moving what the coordinates say.
    fn sums_of_changes(&self, vector: &[Expr<'g>], follower: &Follower<'g>) -> Vec<Expr<'g>> {
        let mut total = vec![self.zero(); vector.len()];
        for ScaledVector { scale, direction } in self.block.split(vector) {
            // d(s p) = ds p + s dp, where dp is the sum of ∂p/∂X dX, and s dX the same for all components.
            let change_of_scale = follower.total_derivative(scale);
            let steps: Vec<_> = follower.moves().iter().map(|&(x, change)| (x, scale * change)).collect();
            for (total, &p) in total.iter_mut().zip(&direction) {
                let change = change_of_scale * p + scale * p.by(follower.parameter());
                let change = steps.iter().fold(change, |change, &(x, step)| change + p.by(x) * step);
                *total += self.sum_at_values(change);
            }
        }
        total
    }

    /// coefficients · v for a vector v of the residuals' length: a scalar times a scalar in each group.
    fn along(&self, vector: &[Expr<'g>], coefficients: &[Expr<'g>], name: &str) -> Expr<'g> {
        let parts = self.block.split(vector).into_iter();
        parts.fold(self.zero(), |total, ScaledVector { scale, direction }| {
            total + scale * dot(coefficients, &direction).named(name)
        })
    }

    /// d²L/dθdθ' = ∂²L/∂θ∂θ' + Zᵀ ∂²L/∂α∂θ' + (∂²L/∂θ∂α + Zᵀ K) Z'
    fn second_derivative(
        &self,
        lagrangian: &Lagrangian<'g>,
        row: &Motion<'g>,
        column: &Motion<'g>,
    ) -> Expr<'g> {
        let sum_of_change = |first: Expr<'g>| self.sum_at_values(column.follower.total_derivative(first));
        let inner = sum_of_change(row.lagrangian);
        // One sum for μ·ρ₂, not one for each of ρ₂: there are many more of these second derivatives.
        let outer = sum_of_change(row.follower.total_derivative(lagrangian.outer));
        let through_alpha = dot(&row.unknowns, &column.change);
        let through_lambda = dot(&row.adjoint_change, &column.unknowns);
        total([inner, outer, through_alpha, through_lambda])
    }
}
