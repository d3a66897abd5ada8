//! First and second derivatives of a quantity defined through a sum over nodes ([T13] of the theory).
//!
//! The unknowns α are defined by r(α, x) = Σᵢ ρ(α, xᵢ) = 0 with A = −∂r/∂α symmetric positive definite, and
//! G(α) is the quantity of interest. With A λ = ∂G/∂α the Lagrangian G + λ·r is stationary in α, and
//!
//! ```text
//! dG/dxᵢ     = ∂Λ/∂xᵢ                                   Λ = λ·ρ, the term of node i, α and λ held
//! d²G/dxᵢdxⱼ = δᵢⱼ ∂²Λ/∂xᵢ² + Cᵢᵀ Yⱼ + Yᵢᵀ Cⱼ + Yᵢᵀ K Yⱼ
//! Y = dα/dx = A⁻¹ B,   B = ∂ρ/∂x,   C = ∂²Λ/∂α∂x,   K = ∂²G/∂α²
//! ```
//!
//! With A = L Lᵀ, B̂ = L⁻¹B and Ĉ = L⁻¹C + ½ (L⁻¹ K L⁻ᵀ) B̂ the off-diagonal blocks are the symmetric low-rank
//! update Ĉᵢᵀ B̂ⱼ + B̂ᵢᵀ Ĉⱼ: K costs nothing per pair of nodes. Which of these blocks are zero, and that ρ and ∂Λ/∂α
//! are a scalar times one and the same vector p, is found in the expressions, not assumed.

use super::factors::ScaledVector;
use crate::graph::{ExprId, Graph, Op, Scope, SymbolId, SystemId};

/// Names of the global axes in emitted code.
const AXES: [&str; 3] = ["x", "y", "z"];

/// How local node coordinates depend on the global ones. The map is linear in the nodes' positions relative
/// to the slave, so all quantities are invariant under translation and the slave's derivatives are the negative
/// sums of the masters'.
#[derive(Clone, Debug)]
pub struct CoordinateMap {
    /// Bound symbols of the local coordinates.
    local: Vec<SymbolId>,
    /// ∂(local coordinate)/∂(global coordinate), element expressions.
    jacobian: Vec<[ExprId; 3]>,
}

impl CoordinateMap {
    /// Derives the map from the definitions of the `local` coordinates.
    ///
    /// # Panics
    /// If a local coordinate is not bound, is not linear in the positions, or changes when node and slave move
    /// together.
    #[must_use]
    pub fn new(g: &mut Graph, local: &[ExprId], node: &[ExprId; 3], slave: &[ExprId; 3]) -> Self {
        let local: Vec<SymbolId> = local.iter().map(|&x| g.symbol_of(x)).collect();
        let jacobian = local
            .iter()
            .map(|&coordinate| {
                let data = g.symbol_data(coordinate).clone();
                let definition = data.definition.expect("a local coordinate has a definition");
                std::array::from_fn(|axis| {
                    let (node, slave) = (g.symbol_of(node[axis]), g.symbol_of(slave[axis]));
                    let by_node = g.derivative(definition, node);
                    let by_slave = g.derivative(definition, slave);
                    assert_eq!(
                        g.scope(by_node),
                        Scope::Element,
                        "{} is not linear in the positions",
                        data.name
                    );
                    assert_eq!(g.neg(by_slave), by_node, "{} is not invariant under translation", data.name);
                    by_node
                })
            })
            .collect();
        Self { local, jacobian }
    }

    /// Global gradient of a node expression of the local coordinates.
    fn gradient(&self, g: &mut Graph, expr: ExprId) -> [ExprId; 3] {
        let partial: Vec<ExprId> = self.local.iter().map(|&c| g.derivative(expr, c)).collect();
        self.pull_back(g, &partial)
    }

    /// Jᵀ v for a vector v of derivatives by the local coordinates.
    fn pull_back(&self, g: &mut Graph, partial: &[ExprId]) -> [ExprId; 3] {
        std::array::from_fn(|axis| {
            let column: Vec<ExprId> = self.jacobian.iter().map(|row| row[axis]).collect();
            g.dot(&column, partial)
        })
    }

    /// Global Hessian of a node expression of the local coordinates.
    fn hessian(&self, g: &mut Graph, expr: ExprId) -> [[ExprId; 3]; 3] {
        // One order of differentiation for both of a pair of mixed derivatives, so that they are one expression.
        let second = |g: &mut Graph, i: usize, j: usize| {
            let first = g.derivative(expr, self.local[i.min(j)]);
            g.derivative(first, self.local[i.max(j)])
        };
        let half: Vec<[ExprId; 3]> = (0..self.local.len())
            .map(|i| {
                let partial: Vec<ExprId> = (0..self.local.len()).map(|j| second(g, i, j)).collect();
                self.pull_back(g, &partial)
            })
            .collect();
        let mut hessian = [[g.zero(); 3]; 3];
        for row in 0..3 {
            for column in 0..=row {
                let left: Vec<ExprId> = self.jacobian.iter().map(|j| j[row]).collect();
                let right: Vec<ExprId> = half.iter().map(|h| h[column]).collect();
                hessian[row][column] = g.dot(&left, &right);
                hessian[column][row] = hessian[row][column];
            }
        }
        hessian
    }
}

/// Unknowns defined by a sum over nodes.
#[derive(Clone, Debug)]
pub struct NodeProblem {
    /// The unknowns α, bound symbols.
    pub unknowns: Vec<ExprId>,
    /// A node's term ρ in the residuals.
    pub residual: Vec<ExprId>,
    /// A = −∂r/∂α.
    pub system: SystemId,
    /// The coordinates the residuals depend on.
    pub coordinates: CoordinateMap,
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

/// d²G/dx² by global coordinates; `[row][column]`.
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
}

impl NodeProblem {
    /// Checks that a system assembled from the nodes is the derivative of the residuals.
    ///
    /// # Panics
    /// If it is not, or is not symmetric.
    pub fn check_system(&self, g: &mut Graph) {
        for (i, &residual) in self.residual.iter().enumerate() {
            for (j, &unknown) in self.unknowns.iter().enumerate() {
                let unknown = g.symbol_of(unknown);
                let derivative = g.derivative(residual, unknown);
                let sum = g.sum(derivative);
                let entry = g.neg(sum);
                assert_eq!(entry, g.system(self.system).entry(i, j), "entry ({i}, {j}) is not −∂r/∂α");
            }
        }
    }

    /// dG/dx.
    pub fn gradient(&self, g: &mut Graph, functional: &Functional) -> Gradient {
        let lagrangian = self.lagrangian(g, functional);
        let node = self.coordinates.gradient(g, lagrangian);
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
        let name = &functional.name;
        let own = self.coordinates.hessian(g, lagrangian);

        let by_unknowns: Vec<ExprId> = self
            .unknowns
            .iter()
            .map(|&unknown| {
                let unknown = g.symbol_of(unknown);
                g.derivative(lagrangian, unknown)
            })
            .collect();
        // B̂ and L⁻¹C
        let residual = self.residual.clone();
        let b = self.solved_gradient(g, &residual, "p");
        let c = self.solved_gradient(g, &by_unknowns, "p");
        let c = self.absorb_second_derivative(g, c, &b, functional);
        for k in 0..b.len() {
            for axis in 0..3 {
                g.name(b[k][axis], &format!("b_hat_{k}_{}", AXES[axis]));
                g.name(c[k][axis], &format!("c_hat_{name}_{k}_{}", AXES[axis]));
            }
        }
        let slave_rows = |g: &mut Graph, rows: &[[ExprId; 3]], letter: &str| -> Vec<[ExprId; 3]> {
            rows.iter()
                .enumerate()
                .map(|(k, row)| {
                    std::array::from_fn(|axis| {
                        let sum = negative_sum(g, row[axis]);
                        g.name(sum, &format!("{letter}_slave_{k}_{}", AXES[axis]))
                    })
                })
                .collect()
        };
        let b_slave = slave_rows(g, &b, "b");
        let c_slave = slave_rows(g, &c, &format!("c_{name}"));

        let mut hessian = Hessian {
            slave: [[g.zero(); 3]; 3],
            node_slave: [[g.zero(); 3]; 3],
            diagonal: [[g.zero(); 3]; 3],
            pair: [[g.zero(); 3]; 3],
        };
        for row in 0..3 {
            for column in 0..3 {
                hessian.pair[row][column] = low_rank_pair(g, &b, &c, row, column);
                let minus_own = g.neg(own[row][column]);
                hessian.node_slave[row][column] =
                    low_rank(g, minus_own, (&b, &c), (&b_slave, &c_slave), row, column);
            }
            for column in 0..=row {
                let own_sum = if g.is_zero(own[row][column]) { g.zero() } else { g.sum(own[row][column]) };
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

    /// Λ = λ·ρ with A λ = ∂G/∂α, a node expression in which λ and α are variables of their own.
    fn lagrangian(&self, g: &mut Graph, functional: &Functional) -> ExprId {
        let solution = g.solve_spd_once(self.system, &functional.first);
        let adjoint: Vec<ExprId> = solution
            .into_iter()
            .enumerate()
            .map(|(k, x)| g.bind_once(&format!("lambda_{}_{k}", functional.name), x))
            .collect();
        let ScaledVector { scale, direction } = g.common_factor(&self.residual);
        let along = g.dot(&adjoint, &direction);
        g.name(along, &format!("sigma_{}", functional.name));
        g.mul(scale, along)
    }

    /// L⁻¹ ∂v/∂x for a vector v of node expressions, rows in elimination order.
    fn solved_gradient(&self, g: &mut Graph, vector: &[ExprId], name: &str) -> Vec<[ExprId; 3]> {
        // ∇(s p) = p ∇sᵀ + s ∇p: L⁻¹ is applied to p and to its derivatives by the local coordinates, which two
        // vectors along the same p share.
        let ScaledVector { scale, direction } = g.common_factor(vector);
        let scale_gradient = self.coordinates.gradient(g, scale);
        let solved = self.apply_inverse_factor(g, &direction);
        let solved_derivatives: Vec<Vec<ExprId>> = self
            .coordinates
            .local
            .iter()
            .map(|&coordinate| {
                let derivative: Vec<ExprId> =
                    direction.iter().map(|&x| g.derivative(x, coordinate)).collect();
                self.apply_inverse_factor(g, &derivative)
            })
            .collect();
        (0..solved.len())
            .map(|k| {
                g.name(solved[k], &format!("{name}_hat_{k}"));
                let partial: Vec<ExprId> = solved_derivatives.iter().map(|d| d[k]).collect();
                let direction_gradient = self.coordinates.pull_back(g, &partial);
                std::array::from_fn(|axis| {
                    g.name(direction_gradient[axis], &format!("grad_{name}_hat_{k}_{}", AXES[axis]));
                    let left = g.mul(solved[k], scale_gradient[axis]);
                    let right = g.mul(scale, direction_gradient[axis]);
                    g.add(left, right)
                })
            })
            .collect()
    }

    /// L⁻¹ v
    fn apply_inverse_factor(&self, g: &mut Graph, vector: &[ExprId]) -> Vec<ExprId> {
        let size = vector.len();
        let permuted: Vec<ExprId> = (0..size).map(|k| vector[g.system(self.system).eliminated(k)]).collect();
        (0..size)
            .map(|row| {
                let entries: Vec<ExprId> =
                    (0..=row).map(|column| self.inverse_factor(g, row, column)).collect();
                g.dot(&entries, &permuted[..=row])
            })
            .collect()
    }

    fn inverse_factor(&self, g: &mut Graph, row: usize, column: usize) -> ExprId {
        g.intern(Op::InverseFactor { system: self.system, row: row as u32, column: column as u32 })
    }

    /// Ĉ = L⁻¹C + ½ (L⁻¹ K L⁻ᵀ) B̂
    fn absorb_second_derivative(
        &self,
        g: &mut Graph,
        c: Vec<[ExprId; 3]>,
        b: &[[ExprId; 3]],
        functional: &Functional,
    ) -> Vec<[ExprId; 3]> {
        let size = c.len();
        let symmetric = |i: usize, j: usize| functional.second[i.max(j)][i.min(j)];
        // L⁻¹ K, then (L⁻¹ K) L⁻ᵀ
        let left: Vec<Vec<ExprId>> = (0..size)
            .map(|j| {
                let column: Vec<ExprId> = (0..size).map(|i| symmetric(i, j)).collect();
                self.apply_inverse_factor(g, &column)
            })
            .collect();
        let half = g.constant(0.5);
        let mut middle = vec![vec![g.zero(); size]; size];
        for i in 0..size {
            let row: Vec<ExprId> = left.iter().map(|column| column[i]).collect();
            let solved = self.apply_inverse_factor(g, &row);
            for j in 0..=i {
                let entry = g.mul(half, solved[j]);
                g.name(entry, &format!("half_k_{i}_{j}"));
                middle[i][j] = entry;
                middle[j][i] = entry;
            }
        }
        c.into_iter()
            .enumerate()
            .map(|(k, row)| {
                std::array::from_fn(|axis| {
                    let column: Vec<ExprId> = b.iter().map(|b| b[axis]).collect();
                    add_products(g, row[axis], &middle[k], &column)
                })
            })
            .collect()
    }
}

/// −Σ x, or 0 for 0.
fn negative_sum(g: &mut Graph, x: ExprId) -> ExprId {
    let sum = g.sum(x);
    g.neg(sum)
}

type Factors<'a> = (&'a [[ExprId; 3]], &'a [[ExprId; 3]]);

/// `start` plus entry (row, column) of C₁ᵀB₂ + B₁ᵀC₂ for factors (B, C).
fn low_rank(
    g: &mut Graph,
    start: ExprId,
    first: Factors<'_>,
    second: Factors<'_>,
    row: usize,
    column: usize,
) -> ExprId {
    let at = |rows: &[[ExprId; 3]], axis: usize| -> Vec<ExprId> { rows.iter().map(|r| r[axis]).collect() };
    if row == column && first == second {
        let one_way = g.dot(&at(first.1, row), &at(second.0, column));
        let two = g.constant(2.0);
        return add_products(g, start, &[two], &[one_way]);
    }
    let one_way = add_products(g, start, &at(first.1, row), &at(second.0, column));
    add_products(g, one_way, &at(first.0, row), &at(second.1, column))
}

/// The same for the pair (row node, column node).
fn low_rank_pair(g: &mut Graph, b: &[[ExprId; 3]], c: &[[ExprId; 3]], row: usize, column: usize) -> ExprId {
    let rows =
        |g: &mut Graph, f: &[[ExprId; 3]]| -> Vec<ExprId> { f.iter().map(|r| g.at_row(r[row])).collect() };
    let columns = |g: &mut Graph, f: &[[ExprId; 3]]| -> Vec<ExprId> {
        f.iter().map(|r| g.at_column(r[column])).collect()
    };
    let (b_row, c_row) = (rows(g, b), rows(g, c));
    let (b_column, c_column) = (columns(g, b), columns(g, c));
    let one_way = g.dot(&c_row, &b_column);
    add_products(g, one_way, &b_row, &c_column)
}

/// start + Σ x_k y_k, added from the left so that every product fuses with its addition.
fn add_products(g: &mut Graph, start: ExprId, x: &[ExprId], y: &[ExprId]) -> ExprId {
    x.iter().zip(y).fold(start, |total, (&x, &y)| {
        let product = g.mul(x, y);
        g.add(total, product)
    })
}
