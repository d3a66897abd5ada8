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
//! is found in the expressions, not assumed.
//!
//! The residuals may depend on further, outer unknowns θ, the root of a sum of their own: the fit depends on the average
//! plane. `outer_block` adds what that brings.

use super::coordinates::CoordinateMap;
use super::factors::ScaledVector;
use super::low_rank::{LowRankForm, add_products, low_rank, low_rank_pair};
use crate::graph::{ExprId, Graph, Op, SymbolId, SystemId};

/// Names of the global axes in emitted code.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Unknowns y defined by a sum over nodes, Σ ρ(y, …; xᵢ) = 0.
#[derive(Clone, Debug)]
pub struct Block {
    /// The unknowns, symbols.
    pub unknowns: Vec<ExprId>,
    /// A node's term ρ in the residuals.
    pub residual: Vec<ExprId>,
    /// Numbers of consecutive residuals, those of a group along one vector: common factors are sought within groups.
    pub groups: Vec<usize>,
    /// A = −∂r/∂y, symmetric.
    pub system: SystemId,
}

impl Block {
    /// A vector of residuals' length as the sum of its groups' parts.
    pub(super) fn split(&self, g: &mut Graph, vector: &[ExprId]) -> Vec<ScaledVector> {
        let mut start = 0;
        self.groups
            .iter()
            .map(|&size| {
                let rows = start..start + size;
                start += size;
                let ScaledVector { scale, direction: part } = g.common_factor(&vector[rows.clone()]);
                let mut direction = vec![g.zero(); vector.len()];
                direction[rows].copy_from_slice(&part);
                ScaledVector { scale, direction }
            })
            .collect()
    }

    /// S v, v in elimination order.
    fn signed(&self, g: &mut Graph, position: usize, x: ExprId) -> ExprId {
        if g.system(self.system).is_negative(position) { g.neg(x) } else { x }
    }
}

/// Unknowns defined by sums over nodes.
#[derive(Clone, Debug)]
pub struct NodeProblem {
    /// The unknowns α that the quantities of interest are functions of.
    pub block: Block,
    /// The unknowns θ that the residuals of the first ones depend on.
    pub outer: Option<Block>,
    /// The coordinates the residuals depend on.
    pub coordinates: CoordinateMap,
    /// Values of symbols that are variables while differentiating, put in afterwards.
    pub values: Vec<(SymbolId, ExprId)>,
}

/// A quantity G(α) of a [`NodeProblem`]'s unknowns.
#[derive(Clone, Debug)]
pub struct Functional {
    /// Name, used for the adjoint solution and the derivatives.
    pub name: String,
    /// ∂G/∂α.
    pub first: Vec<ExprId>,
    /// ∂²G/∂α², of which the lower triangle is read.
    pub second: Vec<Vec<ExprId>>,
}

/// dG/dx by global coordinates.
#[derive(Clone, Debug)]
pub struct Gradient {
    /// By the slave's coordinates.
    pub slave: [ExprId; 3],
    /// By a master node's coordinates.
    pub node: [ExprId; 3],
}

/// d²G/dx² by global coordinates; `[row][column]`. The blocks are what the form says.
#[derive(Clone, Debug)]
pub struct Hessian {
    /// Slave by slave, symmetric.
    pub slave: [[ExprId; 3]; 3],
    /// Row of a master node, column of the slave.
    pub node_slave: [[ExprId; 3]; 3],
    /// A master node by itself, symmetric.
    pub diagonal: [[ExprId; 3]; 3],
    /// Row of one master node, column of another.
    pub pair: [[ExprId; 3]; 3],
    /// All of it as products of rows.
    pub form: LowRankForm,
}

/// The factors B̂ and Ĉ of a Hessian, one row per unknown in elimination order.
#[derive(Default)]
pub(super) struct HessianFactors {
    pub b: Vec<[ExprId; 3]>,
    pub c: Vec<[ExprId; 3]>,
}

/// Λ = Λ₁ + Λ₂, a node expression in which the unknowns and the adjoint ones are variables of their own.
pub(super) struct Lagrangian {
    /// Λ₁ = λ·ρ₁
    pub inner: ExprId,
    /// Λ₁ + μ·ρ₂
    pub total: ExprId,
    /// μ·ρ₂
    pub outer: ExprId,
    /// μ
    pub outer_adjoint: Vec<ExprId>,
}

impl NodeProblem {
    /// The unknowns of interest.
    #[must_use]
    pub fn unknowns(&self) -> &[ExprId] {
        &self.block.unknowns
    }

    /// The system of the unknowns of interest.
    #[must_use]
    pub fn system(&self) -> SystemId {
        self.block.system
    }

    /// Checks that the system of the unknowns of interest, assembled from the nodes, is the derivative of its residuals: the first
    /// group's rows and columns.
    ///
    /// # Panics
    /// If it is not, or is not symmetric.
    pub fn check_system(&self, g: &mut Graph) {
        let block = &self.block;
        let checked = block.groups[0];
        for (i, &residual) in block.residual[..checked].iter().enumerate() {
            for (j, &unknown) in block.unknowns[..checked].iter().enumerate() {
                let unknown = g.symbol_of(unknown);
                let derivative = g.derivative(residual, unknown);
                let derivative = g.substitute(derivative, &self.values);
                let sum = g.sum(derivative);
                let entry = g.neg(sum);
                assert_eq!(entry, g.system(block.system).entry(i, j), "entry ({i}, {j}) is not −∂r/∂α");
            }
        }
    }

    /// dG/dx.
    pub fn gradient(&self, g: &mut Graph, functional: &Functional) -> Gradient {
        let lagrangian = self.lagrangian(g, functional).total;
        let node = self.coordinates.gradient(g, lagrangian).map(|x| g.substitute(x, &self.values));
        let slave = node.map(|x| negative_sum(g, x));
        for axis in 0..3 {
            g.name(node[axis], &format!("d{}_d{}", functional.name, AXES[axis]));
            g.name(slave[axis], &format!("d{}_dslave_{}", functional.name, AXES[axis]));
        }
        Gradient { slave, node }
    }

    /// d²G/dx².
    pub fn hessian(&self, g: &mut Graph, functional: &Functional) -> Hessian {
        let lagrangian = self.lagrangian(g, functional);
        let own = self.coordinates.hessian(g, lagrangian.total);
        let own = own.map(|row| row.map(|x| g.substitute(x, &self.values)));
        let HessianFactors { b, c } = self.factors(g, functional, &lagrangian);
        let b_slave = slave_rows(g, &b, "b");
        let c_slave = slave_rows(g, &c, &format!("c_{}", functional.name));

        let mut hessian = Hessian {
            slave: [[g.zero(); 3]; 3],
            node_slave: [[g.zero(); 3]; 3],
            diagonal: [[g.zero(); 3]; 3],
            pair: [[g.zero(); 3]; 3],
            form: LowRankForm::new(own, g, (&b, &c), (&b_slave, &c_slave)),
        };
        for row in 0..3 {
            for column in 0..3 {
                hessian.pair[row][column] = low_rank_pair(g, &b, &c, row, column);
                let minus_own = g.neg(own[row][column]);
                hessian.node_slave[row][column] =
                    low_rank(g, minus_own, (&b, &c), (&b_slave, &c_slave), row, column);
            }
            for column in 0..=row {
                let own_sum = g.sum(own[row][column]);
                let slave = low_rank(g, own_sum, (&b_slave, &c_slave), (&b_slave, &c_slave), row, column);
                let diagonal = low_rank(g, own[row][column], (&b, &c), (&b, &c), row, column);
                for (i, j) in [(row, column), (column, row)] {
                    hessian.slave[i][j] = slave;
                    hessian.diagonal[i][j] = diagonal;
                }
            }
        }
        hessian
    }

    /// The adjoint equations are A₁ λ = ∂G/∂α and A₂ μ = Σ (∂ρ₁/∂θ)ᵀ λ.
    fn lagrangian(&self, g: &mut Graph, functional: &Functional) -> Lagrangian {
        let name = &functional.name;
        let adjoint = solved(g, self.block.system, &functional.first, &format!("lambda_{name}"));
        let mut inner = g.zero();
        for (group, ScaledVector { scale, direction }) in
            self.block.split(g, &self.block.residual).into_iter().enumerate()
        {
            let along = g.dot(&adjoint, &direction);
            if group == 0 {
                g.name(along, &format!("sigma_{name}"));
            }
            let term = g.mul(scale, along);
            inner = g.add(inner, term);
        }
        let Some(outer) = &self.outer else {
            return Lagrangian { inner, total: inner, outer: g.zero(), outer_adjoint: Vec::new() };
        };
        // A name keeps its derivatives whole, which are needed by themselves.
        g.name(inner, &format!("lagrangian_{name}"));
        g.unite_mixed_derivatives(inner, &self.coordinates.moving_variables());
        let right_hand_side: Vec<ExprId> = outer
            .unknowns
            .iter()
            .map(|&unknown| {
                let change = self.coordinates.follower(g, unknown).total_derivative(g, inner);
                self.sum_at_values(g, change)
            })
            .collect();
        let outer_adjoint = solved(g, outer.system, &right_hand_side, &format!("mu_{name}"));
        let outer = g.dot(&outer_adjoint, &outer.residual);
        Lagrangian { inner, total: g.add(inner, outer), outer, outer_adjoint }
    }

    /// Σ expr over the nodes, evaluated at the values.
    pub(super) fn sum_at_values(&self, g: &mut Graph, expr: ExprId) -> ExprId {
        let expr = g.substitute(expr, &self.values);
        g.sum(expr)
    }

    /// B̂ and Ĉ, named.
    fn factors(&self, g: &mut Graph, functional: &Functional, lagrangian: &Lagrangian) -> HessianFactors {
        let block = &self.block;
        let by_unknowns = partial_derivatives(g, lagrangian.inner, &block.unknowns);
        let mut factors = self.block_factors(g, block, &by_unknowns, "p");
        add_second_derivative(g, &mut factors, block, &functional.second, &format!("h_{}", functional.name));
        if let Some(outer) = &self.outer {
            let (by_outer, second) = self.reduced(g, outer, functional, lagrangian, &by_unknowns);
            let mut added = self.block_factors(g, outer, &by_outer, "plane");
            add_second_derivative(g, &mut added, outer, &second, &format!("h_{}_plane", functional.name));
            factors.b.extend(added.b);
            factors.c.extend(added.c);
        }
        for k in 0..factors.b.len() {
            for axis in 0..3 {
                g.name(factors.b[k][axis], &format!("b_hat_{k}_{}", AXES[axis]));
                g.name(factors.c[k][axis], &format!("c_hat_{}_{k}_{}", functional.name, AXES[axis]));
            }
        }
        factors
    }

    /// L⁻¹B and S L⁻¹C of a block, C being the gradient of `by_unknowns`.
    fn block_factors(
        &self,
        g: &mut Graph,
        block: &Block,
        by_unknowns: &[ExprId],
        name: &str,
    ) -> HessianFactors {
        let b = self.solved_gradient(g, block, &block.residual, name);
        let mut c = self.solved_gradient(g, block, by_unknowns, name);
        for (position, row) in c.iter_mut().enumerate() {
            *row = row.map(|x| block.signed(g, position, x));
        }
        HessianFactors { b, c }
    }

    /// L⁻¹ ∂v/∂x for a vector v of node expressions, rows in elimination order.
    fn solved_gradient(
        &self,
        g: &mut Graph,
        block: &Block,
        vector: &[ExprId],
        name: &str,
    ) -> Vec<[ExprId; 3]> {
        // ∇(s p) = p ∇sᵀ + s ∇p: L⁻¹ is applied to p and to its derivatives by the local coordinates, which two
        // vectors along the same p share.
        let mut total = vec![[g.zero(); 3]; vector.len()];
        for (group, ScaledVector { scale, direction }) in block.split(g, vector).into_iter().enumerate() {
            let scale_gradient = self.coordinates.gradient(g, scale).map(|x| g.substitute(x, &self.values));
            let partial: Vec<Vec<ExprId>> =
                direction.iter().map(|&x| self.coordinates.partial_derivatives(g, x)).collect();
            let solved_derivatives: Vec<Vec<ExprId>> = (0..self.coordinates.dimension())
                .map(|coordinate| {
                    let derivative: Vec<ExprId> = partial.iter().map(|row| row[coordinate]).collect();
                    let derivative = g.substitute_all(&derivative, &self.values);
                    apply_inverse_factor(g, block.system, &derivative)
                })
                .collect();
            let scale = g.substitute(scale, &self.values);
            let direction = g.substitute_all(&direction, &self.values);
            let solved = apply_inverse_factor(g, block.system, &direction);
            let name = if group == 0 { name.to_owned() } else { format!("{name}_{group}") };
            for k in 0..solved.len() {
                g.name(solved[k], &format!("{name}_hat_{k}"));
                let partial: Vec<ExprId> = solved_derivatives.iter().map(|d| d[k]).collect();
                let direction_gradient = self.coordinates.pull_back(g, &partial);
                for axis in 0..3 {
                    g.name(direction_gradient[axis], &format!("grad_{name}_hat_{k}_{}", AXES[axis]));
                    let left = g.mul(solved[k], scale_gradient[axis]);
                    let right = g.mul(scale, direction_gradient[axis]);
                    let both = g.add(left, right);
                    total[k][axis] = g.add(total[k][axis], both);
                }
            }
        }
        total
    }
}

/// Ĉ += H B̂, where H is the lower triangle of S (L⁻¹ K L⁻ᵀ) S with half of the diagonal, so that K costs half as much. Of
/// K, `second`, the lower triangle is read.
fn add_second_derivative(
    g: &mut Graph,
    factors: &mut HessianFactors,
    block: &Block,
    second: &[Vec<ExprId>],
    name: &str,
) {
    let half = g.constant(0.5);
    for (row, entries) in congruence(g, block.system, second).into_iter().enumerate() {
        for (column, &entry) in entries[..=row].iter().enumerate() {
            let entry = if row == column { g.mul(half, entry) } else { entry };
            let entry = block.signed(g, row, entry);
            let entry = block.signed(g, column, entry);
            g.name(entry, &format!("{name}_{row}_{column}"));
            for axis in 0..3 {
                factors.c[row][axis] =
                    add_products(g, factors.c[row][axis], &[entry], &[factors.b[column][axis]]);
            }
        }
    }
}

/// L⁻¹ X L⁻ᵀ for a symmetric X, of which the lower triangle is read.
fn congruence(g: &mut Graph, system: SystemId, lower: &[Vec<ExprId>]) -> Vec<Vec<ExprId>> {
    let size = lower.len();
    let left: Vec<Vec<ExprId>> = (0..size)
        .map(|column| {
            let entries: Vec<ExprId> = (0..size).map(|row| lower[row.max(column)][row.min(column)]).collect();
            apply_inverse_factor(g, system, &entries)
        })
        .collect();
    (0..size)
        .map(|row| {
            let entries: Vec<ExprId> = left.iter().map(|column| column[row]).collect();
            apply_inverse_factor(g, system, &entries)
        })
        .collect()
}

/// L⁻¹ v, rows in elimination order.
fn apply_inverse_factor(g: &mut Graph, system: SystemId, vector: &[ExprId]) -> Vec<ExprId> {
    let permuted: Vec<ExprId> = (0..vector.len()).map(|k| vector[g.system(system).eliminated(k)]).collect();
    (0..vector.len())
        .map(|row| {
            let entries: Vec<ExprId> = (0..=row)
                .map(|column| g.intern(Op::InverseFactor { system, row: row as u32, column: column as u32 }))
                .collect();
            g.dot(&entries, &permuted[..=row])
        })
        .collect()
}

/// A⁻¹ v as variables of their own; 0 for 0.
pub(super) fn solved(g: &mut Graph, system: SystemId, vector: &[ExprId], name: &str) -> Vec<ExprId> {
    if vector.iter().all(|&x| g.is_zero(x)) {
        return vector.to_vec();
    }
    g.solve_symmetric_once(system, vector)
        .into_iter()
        .enumerate()
        .map(|(k, x)| g.bind_once(&format!("{name}_{k}"), x))
        .collect()
}

/// Derivatives of an expression by unknowns.
fn partial_derivatives(g: &mut Graph, expr: ExprId, unknowns: &[ExprId]) -> Vec<ExprId> {
    unknowns
        .iter()
        .map(|&unknown| {
            let unknown = g.symbol_of(unknown);
            g.derivative(expr, unknown)
        })
        .collect()
}

/// The slave's rows of a factor: the negative sums of the nodes'.
fn slave_rows(g: &mut Graph, rows: &[[ExprId; 3]], letter: &str) -> Vec<[ExprId; 3]> {
    rows.iter()
        .enumerate()
        .map(|(k, row)| {
            std::array::from_fn(|axis| {
                let sum = negative_sum(g, row[axis]);
                g.name(sum, &format!("{letter}_slave_{k}_{}", AXES[axis]))
            })
        })
        .collect()
}

/// −Σ x, or 0 for 0.
fn negative_sum(g: &mut Graph, x: ExprId) -> ExprId {
    let sum = g.sum(x);
    g.neg(sum)
}
