//! First and second derivatives of a quantity defined through a sum over nodes (`docs/equations.md`, section 5).
//!
//! The unknowns α are defined by r(α, x) = Σᵢ ρ(α, xᵢ) = 0 with A = −∂r/∂α symmetric, and
//! G(α) is the quantity of interest. With A λ = ∂G/∂α the Lagrangian G + λ·r is stationary in α, and
//!
//! ```text
//! dG/dxᵢ     = ∂Λ/∂xᵢ                                   Λ = λ·ρ, the term of node i, α and λ held
//! d²G/dxᵢdxⱼ = δᵢⱼ ∂²Λ/∂xᵢ² + Cᵢᵀ Yⱼ + Yᵢᵀ Cⱼ + Yᵢᵀ K Yⱼ
//! Y = dα/dx = A⁻¹ B,   B = ∂ρ/∂x,   C = ∂²Λ/∂α∂x,   K = ∂²G/∂α²
//! ```
//!
//! With A = L S Lᵀ, S = diag(±1), B̂ = L⁻¹B and Ĉ = S L⁻¹C + H B̂, where H is the lower triangle of S (L⁻¹ K L⁻ᵀ) S with
//! half of its diagonal, H + Hᵀ the whole, the off-diagonal blocks are the symmetric low-rank update
//! Ĉᵢᵀ B̂ⱼ + B̂ᵢᵀ Ĉⱼ: K costs nothing per pair of nodes. (S is the identity but for a multiplier.) Which of these blocks
//! are zero, which rows are the same for all nodes, and that ρ and ∂Λ/∂α are a scalar times one and the same vector p,
//! is found in the expressions, not assumed. Where A is not symmetric, as it may be for outer unknowns, λ solves Aᵀ λ = ∂G/∂α,
//! and B̂ = Y and Ĉ = C + H B̂ with H of K itself do the same.
//!
//! The residuals may depend on further, outer unknowns θ, the root of a sum of their own: the fit depends on the average
//! plane. `outer_block` adds what that brings.

use super::elimination::Elimination;
use super::factors::ScaledVector;
use super::low_rank::{Factors, LowRankForm};
use super::node_problem::{Block, Functional, Gradient, Lagrangian, NodeProblem};
use super::outer_block::Reduced;
use super::point::PointRows;
use crate::expr::{AXES, Expr, System, Vec3, all_at, dot};
use crate::graph::Op;

impl<'g> NodeProblem<'g> {
    /// The unknowns of interest.
    pub fn unknowns(&self) -> &[Expr<'g>] {
        &self.block.unknowns
    }

    /// The system of the unknowns of interest.
    ///
    /// # Panics
    /// If it is not symmetric.
    pub fn system(&self) -> System<'g> {
        match self.block.system {
            Elimination::Symmetric(system) => system,
            Elimination::Inverse(_) => panic!("the unknowns of interest have a symmetric system"),
        }
    }

    pub(super) fn zero(&self) -> Expr<'g> {
        self.system().sheet().zero()
    }

    /// Checks that the system of the unknowns of interest, assembled from the nodes, is the derivative of its residuals: the first
    /// group's rows and columns.
    ///
    /// # Panics
    /// If it is not, or is not symmetric.
    pub fn check_system(&self) {
        let Block { unknowns, residual, groups, .. } = &self.block;
        for (i, residual) in residual[..groups[0]].iter().enumerate() {
            for (j, &unknown) in unknowns[..groups[0]].iter().enumerate() {
                let entry = -self.sum_at_values(residual.by(unknown));
                assert_eq!(entry, self.system().entry(i, j), "entry ({i}, {j}) is not −∂r/∂α");
            }
        }
    }

    /// dG/dx.
    pub fn gradient(&self, functional: &Functional<'g>) -> Gradient {
        let lagrangian = self.lagrangian(functional).total;
        let node = self.coordinates.gradient(lagrangian).at(&self.values);
        let point = functional.point.as_ref().map(|point| point.gradient(functional));
        let of_nodes = node.map(|x| -x.sum());
        let slave =
            point.map_or(of_nodes, |point| of_nodes - point).named(&format!("d{}_dslave", functional.name));
        let node = Vec3::from_fn(|k| node[k].named(&format!("d{}_d{}", functional.name, AXES[k])));
        Gradient { slave: slave.ids(), node: node.ids(), point: point.map(Vec3::ids) }
    }

    /// d²G/dx².
    pub fn hessian(&self, functional: &Functional<'g>) -> LowRankForm {
        let lagrangian = self.lagrangian(functional);
        let own = self.coordinates.hessian(lagrangian.total).at(&self.values);
        let (node, point) = self.factors(functional, &lagrangian);
        LowRankForm::new(own, &node, point.as_ref())
    }

    /// ∂G/∂zᵢ for a quantity G linear in the unknowns, with ∂G/∂α = `first`, and a variable z of node scope that the
    /// residuals of the unknowns of interest depend on.
    pub fn sensitivity(&self, name: &str, first: &[Expr<'g>], z: Expr<'g>) -> Expr<'g> {
        let adjoint = self.system().solve_bound(first, &format!("lambda_{name}"));
        let by_z: Vec<Expr<'g>> = self.block.residual.iter().map(|residual| residual.by(z)).collect();
        dot(&adjoint, &by_z).at(&self.values)
    }

    /// The adjoint equations are A₁ λ = ∂G/∂α and A₂ μ = Σ (∂ρ₁/∂θ)ᵀ λ.
    fn lagrangian(&self, functional: &Functional<'g>) -> Lagrangian<'g> {
        let name = &functional.name;
        let adjoint = self.system().solve_bound(&functional.first, &format!("lambda_{name}"));
        let mut inner = self.zero();
        for (group, ScaledVector { scale, direction }) in
            self.block.split(&self.block.residual).into_iter().enumerate()
        {
            let along = dot(&adjoint, &direction);
            let along = if group == 0 { along.named(&format!("sigma_{name}")) } else { along };
            inner += self.with_weight_apart(scale, along, &format!("eta_{name}_{group}"));
        }
        let Some(outer) = &self.outer else {
            return Lagrangian { inner, total: inner, outer: self.zero() };
        };
        // A name keeps its derivatives whole, which are needed by themselves.
        let inner = inner.named(&format!("lagrangian_{name}"));
        inner.unite_mixed_derivatives(self.coordinates.moving_variables());
        let change = |&unknown: &Expr<'g>| self.coordinates.follower(unknown).total_derivative(inner);
        let right_hand_side: Vec<Expr<'g>> =
            outer.unknowns.iter().map(|unknown| self.sum_at_values(change(unknown))).collect();
        let of_point = |&unknown: &Expr<'g>, sum: Expr<'g>| match &functional.point {
            Some(point) => sum + point.change(point.value, unknown),
            None => sum,
        };
        let right_hand_side: Vec<Expr<'g>> =
            outer.unknowns.iter().zip(right_hand_side).map(|(unknown, sum)| of_point(unknown, sum)).collect();
        let outer_adjoint = outer.system.solve_transposed(&right_hand_side, &format!("mu_{name}"));
        let mut along_residual = self.zero();
        for (group, ScaledVector { scale, direction }) in outer.split(&outer.residual).into_iter().enumerate()
        {
            let along = dot(&outer_adjoint, &direction).named(&format!("tau_{name}_{group}"));
            along_residual += self.with_weight_apart(scale, along, &format!("theta_{name}_{group}"));
        }
        let outer = along_residual;
        Lagrangian { inner, total: inner + outer, outer }
    }

    /// `scale` · `along`. What the local coordinates do not change is multiplied last, and the rest has a name: derivatives by them leave
    /// it alone.
    fn with_weight_apart(&self, scale: Expr<'g>, along: Expr<'g>, name: &str) -> Expr<'g> {
        let Op::Mul(x, y) = scale.operation() else { return scale * along };
        let [x, y] = [x, y].map(|x| scale.sheet().expr(x));
        let is_held = |x: Expr<'g>| self.coordinates.partial_derivatives(x).iter().all(|x| x.is_zero());
        match [is_held(x), is_held(y)] {
            [true, false] => x * (y * along).named(name),
            [false, true] => y * (x * along).named(name),
            _ => scale * along,
        }
    }

    /// Σ x over the nodes, evaluated at the values.
    pub(super) fn sum_at_values(&self, x: Expr<'g>) -> Expr<'g> {
        x.at(&self.values).sum()
    }

    /// B̂ and Ĉ, named, one row per unknown in elimination order, of a node and of the point.
    fn factors(
        &self,
        functional: &Functional<'g>,
        lagrangian: &Lagrangian<'g>,
    ) -> (Factors<'g>, Option<PointRows<'g>>) {
        let (block, name) = (&self.block, &functional.name);
        let by_unknowns: Vec<Expr<'g>> =
            block.unknowns.iter().map(|&unknown| lagrangian.inner.by(unknown)).collect();
        let mut factors = self.block_factors(block, &by_unknowns, "p");
        let mut point = functional.point.as_ref().map(|point| point.rows(block));
        add_second_derivative(&mut factors, block, &functional.second, &format!("h_{name}"));
        if let Some(outer) = &self.outer {
            let reduced: Reduced<'g> = self.reduced(outer, functional, lagrangian, &by_unknowns);
            let mut added = self.block_factors(outer, &reduced.by_outer, "plane");
            add_second_derivative(&mut added, outer, &reduced.second, &format!("h_{name}_plane"));
            factors.b.extend(added.b);
            factors.c.extend(added.c);
            if let (Some(rows), Some(point)) = (&mut point, &functional.point) {
                rows.c.extend(point.factor(outer, &reduced.point_by_outer));
            }
        }
        let named = |(k, row): (usize, &Vec3<'g>), letter: &str| row.named(&format!("{letter}_{k}"));
        let factors = Factors {
            b: factors.b.iter().enumerate().map(|row| named(row, "b_hat")).collect(),
            c: factors.c.iter().enumerate().map(|row| named(row, &format!("c_hat_{name}"))).collect(),
        };
        (factors, point)
    }

    /// L⁻¹B and S L⁻¹C of a block, or A⁻¹B and C where A is not symmetric, C being the gradient of `by_unknowns`.
    fn block_factors(&self, block: &Block<'g>, by_unknowns: &[Expr<'g>], name: &str) -> Factors<'g> {
        let system = &block.system;
        let b = self.solved_gradient(block, &block.residual, name, |v| system.left(v));
        let c = self.solved_gradient(block, by_unknowns, name, |v| system.right(v)).into_iter().enumerate();
        Factors { b, c: c.map(|(position, row)| row.map(|x| system.signed(position, x))).collect() }
    }

    /// `factor` times ∂v/∂x for a vector v of node expressions.
    fn solved_gradient(
        &self,
        block: &Block<'g>,
        vector: &[Expr<'g>],
        name: &str,
        factor: impl Fn(&[Expr<'g>]) -> Vec<Expr<'g>>,
    ) -> Vec<Vec3<'g>> {
        // ∇(s p) = p ∇sᵀ + s ∇p: L⁻¹ is applied to p and to its derivatives by the local coordinates, which two
        // vectors along the same p share.
        let (x, values) = (&self.coordinates, &self.values);
        let solved = |v: &[Expr<'g>]| factor(&all_at(v, values));
        let mut total = vec![Vec3::zero(self.system().sheet()); vector.len()];
        for (group, ScaledVector { scale, direction: p }) in block.split(vector).into_iter().enumerate() {
            let scale_gradient = x.gradient(scale).at(values);
            let partial: Vec<Vec<Expr<'g>>> = p.iter().map(|&p| x.partial_derivatives(p)).collect();
            let partial: Vec<Vec<Expr<'g>>> = (0..x.dimension())
                .map(|coordinate| solved(&partial.iter().map(|row| row[coordinate]).collect::<Vec<_>>()))
                .collect();
            let scale = scale.at(values);
            let name = if group == 0 { name.to_owned() } else { format!("{name}_{group}") };
            for (k, p) in solved(&p).into_iter().enumerate() {
                let p = p.named(&format!("{name}_hat_{k}"));
                let gradient = x.pull_back(&partial.iter().map(|row| row[k]).collect::<Vec<_>>());
                total[k] += p * scale_gradient + scale * gradient.named(&format!("grad_{name}_hat_{k}"));
            }
        }
        total
    }
}

/// Ĉ += H B̂, where H is the lower triangle of S (L⁻¹ K L⁻ᵀ) S with half of the diagonal, so that K costs half as much. Of
/// K, `second`, the lower triangle is read.
fn add_second_derivative<'g>(
    factors: &mut Factors<'g>,
    block: &Block<'g>,
    second: &[Vec<Expr<'g>>],
    name: &str,
) {
    let half = block.unknowns[0].sheet().number(0.5);
    for (row, entries) in block.system.congruence(second).into_iter().enumerate() {
        for (column, &entry) in entries[..=row].iter().enumerate() {
            let entry = if row == column { half * entry } else { entry };
            let entry = block.system.signed(column, block.system.signed(row, entry));
            factors.c[row] += entry.named(&format!("{name}_{row}_{column}")) * factors.b[column];
        }
    }
}
