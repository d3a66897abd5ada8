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
//! Unknowns may come in blocks, each the root of a sum over nodes of its own, that depend on the blocks after them:
//! the fit depends on the average plane. Then A is block triangular, r₁₂ = ∂r₁/∂y₂ couples the blocks
//! (B̂₁ = L₁⁻¹B₁ + L₁⁻¹ r₁₂ L₂⁻ᵀ B̂₂) and K has a block for every pair.
//!
//! With A = L S Lᵀ, S = diag(±1), B̂ = L⁻¹B and Ĉ = S L⁻¹C + H B̂, where H is the lower triangle of S (L⁻¹ K L⁻ᵀ) S with
//! half of its diagonal, H + Hᵀ the whole, the off-diagonal blocks are the symmetric low-rank update
//! Ĉᵢᵀ B̂ⱼ + B̂ᵢᵀ Ĉⱼ: K costs nothing per pair of nodes. (S is the identity but for a multiplier.) Which of these blocks are zero, and that ρ and ∂Λ/∂α are a scalar times one and the same vector p, is
//! found in the expressions, not assumed.

use super::factors::ScaledVector;
use super::low_rank::{add_products, low_rank, low_rank_pair};
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
    fn split(&self, g: &mut Graph, vector: &[ExprId]) -> Vec<ScaledVector> {
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

/// Unknowns defined by sums over nodes, in blocks. A block's residuals may depend on the unknowns of later blocks.
#[derive(Clone, Debug)]
pub struct NodeProblem {
    /// The blocks; the quantities of interest are functions of the first one's unknowns.
    pub blocks: Vec<Block>,
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

/// A block's part of the factors of a Hessian: B̂ and Ĉ, one row per unknown in elimination order.
struct BlockFactors {
    b: Vec<[ExprId; 3]>,
    c: Vec<[ExprId; 3]>,
}

impl NodeProblem {
    /// The unknowns of interest.
    #[must_use]
    pub fn unknowns(&self) -> &[ExprId] {
        &self.blocks[0].unknowns
    }

    /// The system of the unknowns of interest.
    #[must_use]
    pub fn system(&self) -> SystemId {
        self.blocks[0].system
    }

    /// Checks that the first block's system, assembled from the nodes, is the derivative of its residuals: the first
    /// group's rows and columns.
    ///
    /// # Panics
    /// If it is not, or is not symmetric.
    pub fn check_system(&self, g: &mut Graph) {
        let block = &self.blocks[0];
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
        let lagrangian = self.lagrangian(g, functional);
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
        let own =
            self.coordinates.hessian(g, lagrangian).map(|row| row.map(|x| g.substitute(x, &self.values)));
        let factors = self.factors(g, functional, lagrangian);
        let (b, c) = name_factors(g, &functional.name, factors);
        let b_slave = slave_rows(g, &b, "b");
        let c_slave = slave_rows(g, &c, &format!("c_{}", functional.name));

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

    /// Λ = Σ λ·ρ over the blocks, a node expression in which λ and the unknowns are variables of their own. The adjoint
    /// equations are A₁ λ₁ = ∂G/∂y₁ and, for later blocks, A_k λ_k = Σ_{j<k} (∂r_j/∂y_k)ᵀ λ_j.
    fn lagrangian(&self, g: &mut Graph, functional: &Functional) -> ExprId {
        let mut lagrangian = g.zero();
        for (k, block) in self.blocks.iter().enumerate() {
            let right_hand_side = if k == 0 {
                functional.first.clone()
            } else {
                self.sums_of_derivatives(g, lagrangian, &block.unknowns)
            };
            let prefix = ["lambda", "mu"][k.min(1)];
            let solution = g.solve_symmetric_once(block.system, &right_hand_side);
            let adjoint: Vec<ExprId> = solution
                .into_iter()
                .enumerate()
                .map(|(j, x)| g.bind_once(&format!("{prefix}_{}_{j}", functional.name), x))
                .collect();
            for (group, ScaledVector { scale, direction }) in
                block.split(g, &block.residual).into_iter().enumerate()
            {
                let along = g.dot(&adjoint, &direction);
                if (k, group) == (0, 0) {
                    g.name(along, &format!("sigma_{}", functional.name));
                }
                let term = g.mul(scale, along);
                lagrangian = g.add(lagrangian, term);
            }
        }
        lagrangian
    }

    /// Σ ∂expr/∂y over the nodes for every unknown y.
    fn sums_of_derivatives(&self, g: &mut Graph, expr: ExprId, unknowns: &[ExprId]) -> Vec<ExprId> {
        unknowns
            .iter()
            .map(|&unknown| {
                let unknown = g.symbol_of(unknown);
                let derivative = g.derivative(expr, unknown);
                let derivative = g.substitute(derivative, &self.values);
                g.sum(derivative)
            })
            .collect()
    }

    /// B̂ and Ĉ of all blocks.
    fn factors(&self, g: &mut Graph, functional: &Functional, lagrangian: ExprId) -> Vec<BlockFactors> {
        // L⁻¹B and S L⁻¹C of each block by itself.
        let mut factors: Vec<BlockFactors> = self
            .blocks
            .iter()
            .enumerate()
            .map(|(k, block)| {
                let by_unknowns: Vec<ExprId> = block
                    .unknowns
                    .iter()
                    .map(|&unknown| {
                        let unknown = g.symbol_of(unknown);
                        g.derivative(lagrangian, unknown)
                    })
                    .collect();
                let name = ["p", "plane"][k.min(1)];
                let b = self.solved_gradient(g, block, &block.residual, name);
                let mut c = self.solved_gradient(g, block, &by_unknowns, name);
                for (position, row) in c.iter_mut().enumerate() {
                    *row = row.map(|x| block.signed(g, position, x));
                }
                BlockFactors { b, c }
            })
            .collect();

        // B̂_j += L_j⁻¹ (∂r_j/∂y_k) L_k⁻ᵀ B̂_k for later blocks k, the last ones first.
        for j in (0..self.blocks.len()).rev() {
            for k in j + 1..self.blocks.len() {
                let coupling: Vec<Vec<ExprId>> = self.blocks[j]
                    .residual
                    .iter()
                    .map(|&residual| self.sums_of_derivatives(g, residual, &self.blocks[k].unknowns))
                    .collect();
                let coupling = self.congruence(g, j, k, &coupling);
                name_matrix(g, &coupling, &format!("coupling_{j}{k}"));
                let later = factors[k].b.clone();
                for (row, coefficients) in factors[j].b.iter_mut().zip(&coupling) {
                    *row = add_rows(g, *row, coefficients, &later);
                }
            }
        }

        // Ĉ_j += Σ_{k≤j} H_jk B̂_k, H + Hᵀ = S (L⁻¹ K L⁻ᵀ) S
        let solved: Vec<Vec<[ExprId; 3]>> = factors.iter().map(|f| f.b.clone()).collect();
        for (j, factor) in factors.iter_mut().enumerate() {
            for (k, solved) in solved[..=j].iter().enumerate() {
                let matrix = self.second_derivative(g, functional, lagrangian, j, k);
                let mut matrix = self.congruence(g, j, k, &matrix);
                for (row, entries) in matrix.iter_mut().enumerate() {
                    for (column, entry) in entries.iter_mut().enumerate() {
                        *entry = self.half_of_symmetric(g, *entry, (j, row), (k, column));
                        let block = if self.blocks.len() == 1 { String::new() } else { format!("{j}{k}_") };
                        g.name(*entry, &format!("h_{}_{block}{row}_{column}", functional.name));
                    }
                }
                for (c, entries) in factor.c.iter_mut().zip(&matrix) {
                    *c = add_rows(g, *c, entries, solved);
                }
            }
        }
        factors
    }

    /// ∂²L/∂y_j∂y_k: ∂²G/∂y₁² in the first block, sums of second derivatives of Λ elsewhere. (Λ is linear in the
    /// first block's unknowns.)
    fn second_derivative(
        &self,
        g: &mut Graph,
        functional: &Functional,
        lagrangian: ExprId,
        j: usize,
        k: usize,
    ) -> Vec<Vec<ExprId>> {
        if (j, k) == (0, 0) {
            let size = functional.second.len();
            return (0..size)
                .map(|row| {
                    (0..size).map(|column| functional.second[row.max(column)][row.min(column)]).collect()
                })
                .collect();
        }
        let entry = |g: &mut Graph, x: ExprId, y: ExprId| {
            let first = g.symbol_of(x);
            let first = g.derivative(lagrangian, first);
            self.sums_of_derivatives(g, first, &[y])[0]
        };
        let (rows, columns) = (&self.blocks[j].unknowns, &self.blocks[k].unknowns);
        (0..rows.len())
            .map(|row| {
                (0..columns.len())
                    .map(|column| {
                        // Of a symmetric block every entry is derived once.
                        if j == k && column > row {
                            entry(g, rows[column], columns[row])
                        } else {
                            entry(g, rows[row], columns[column])
                        }
                    })
                    .collect()
            })
            .collect()
    }

    /// The entry of H at (row, column), each given as a block and a position in it, where S K̂ S = H + Hᵀ has the
    /// entry ±`entry`: H is the lower triangle with half of the diagonal, so that K costs half as much.
    fn half_of_symmetric(
        &self,
        g: &mut Graph,
        entry: ExprId,
        row: (usize, usize),
        column: (usize, usize),
    ) -> ExprId {
        let share = match row.cmp(&column) {
            std::cmp::Ordering::Less => return g.zero(),
            std::cmp::Ordering::Equal => 0.5,
            std::cmp::Ordering::Greater => 1.0,
        };
        let share = g.constant(share);
        let entry = g.mul(share, entry);
        let entry = self.blocks[row.0].signed(g, row.1, entry);
        self.blocks[column.0].signed(g, column.1, entry)
    }

    /// L_j⁻¹ X L_k⁻ᵀ
    fn congruence(&self, g: &mut Graph, j: usize, k: usize, matrix: &[Vec<ExprId>]) -> Vec<Vec<ExprId>> {
        let columns = matrix.first().map_or(0, Vec::len);
        let left: Vec<Vec<ExprId>> = (0..columns)
            .map(|column| {
                let entries: Vec<ExprId> = matrix.iter().map(|row| row[column]).collect();
                apply_inverse_factor(g, self.blocks[j].system, &entries)
            })
            .collect();
        (0..matrix.len())
            .map(|row| {
                let entries: Vec<ExprId> = left.iter().map(|column| column[row]).collect();
                apply_inverse_factor(g, self.blocks[k].system, &entries)
            })
            .collect()
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
            let solved_derivatives: Vec<Vec<ExprId>> = self
                .coordinates
                .local
                .iter()
                .map(|&coordinate| {
                    let derivative: Vec<ExprId> =
                        direction.iter().map(|&x| g.derivative(x, coordinate)).collect();
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

/// start + Σ coefficient · row
fn add_rows(g: &mut Graph, start: [ExprId; 3], coefficients: &[ExprId], rows: &[[ExprId; 3]]) -> [ExprId; 3] {
    std::array::from_fn(|axis| {
        let column: Vec<ExprId> = rows.iter().map(|row| row[axis]).collect();
        add_products(g, start[axis], coefficients, &column)
    })
}

fn name_matrix(g: &mut Graph, matrix: &[Vec<ExprId>], name: &str) {
    for (row, entries) in matrix.iter().enumerate() {
        for (column, &entry) in entries.iter().enumerate() {
            g.name(entry, &format!("{name}_{row}_{column}"));
        }
    }
}

/// All blocks' rows below each other, named.
fn name_factors(
    g: &mut Graph,
    functional: &str,
    factors: Vec<BlockFactors>,
) -> (Vec<[ExprId; 3]>, Vec<[ExprId; 3]>) {
    let (mut b, mut c) = (Vec::new(), Vec::new());
    for factor in factors {
        b.extend(factor.b);
        c.extend(factor.c);
    }
    for k in 0..b.len() {
        for axis in 0..3 {
            g.name(b[k][axis], &format!("b_hat_{k}_{}", AXES[axis]));
            g.name(c[k][axis], &format!("c_hat_{functional}_{k}_{}", AXES[axis]));
        }
    }
    (b, c)
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
