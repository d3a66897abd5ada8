//! First and second derivatives of a function of a few vectors that are linear in the positions of a few nodes.
//!
//! With v_m = Σ_k c_km x_k and G(v), the chain rule is
//!
//! ```text
//! dG/dx_k      = Σ_m c_km ∂G/∂v_m
//! d²G/dx_i dx_j = Σ_m c_im W_jm,   W_jm = Σ_l c_jl K_ml,   K_ml = ∂²G/∂v_m∂v_l
//! ```
//!
//! The rows of K that belong to a vector v_m are often one and the same row three times over, up to a factor: K_ml =
//! s ⊗ d_l. That is found in the expressions, not assumed. W_jm is then s ⊗ w with a vector w, and all such
//! terms of a block with the same s are one product.

use crate::graph::{ExprId, Graph};

/// Coefficients c_km of vectors that are linear in the positions of nodes; `[node][vector]`.
#[derive(Clone, Debug)]
pub struct LinearImages {
    coefficients: Vec<Vec<ExprId>>,
}

/// K_ml = ∂²G/∂v_m∂v_l as `[m][l][row][column]`.
pub type SecondDerivative = Vec<Vec<[[ExprId; 3]; 3]>>;

/// The rows of K that belong to one vector.
enum Rows {
    /// No entry but zeros.
    Zero,
    /// K_ml = scale ⊗ direction_l.
    RankOne { scale: [ExprId; 3], directions: Vec<[ExprId; 3]> },
    /// Anything else.
    Full,
}

/// W_jm of one node j: a matrix, or the vector w of scale ⊗ w.
enum Product {
    Zero,
    RankOne([ExprId; 3]),
    Full([[ExprId; 3]; 3]),
}

impl LinearImages {
    /// Vectors from their coefficients, one row per node.
    #[must_use]
    pub const fn new(coefficients: Vec<Vec<ExprId>>) -> Self {
        Self { coefficients }
    }

    /// dG/dx from ∂G/∂v, three entries per node.
    pub fn gradient(&self, g: &mut Graph, first: &[[ExprId; 3]]) -> Vec<ExprId> {
        let mut gradient = Vec::new();
        for node in &self.coefficients {
            for axis in 0..3 {
                let column: Vec<ExprId> = first.iter().map(|v| v[axis]).collect();
                gradient.push(g.dot(node, &column));
            }
        }
        gradient
    }

    /// d²G/dx² from K, the packed lower triangle row by row. Where a block of K and its transpose are both there, as K
    /// is symmetric, one of them is used.
    pub fn hessian(&self, g: &mut Graph, second: &SecondDerivative) -> Vec<ExprId> {
        let rows: Vec<Rows> = second.iter().map(|row| classify(g, row)).collect();
        let products: Vec<Vec<Product>> = self
            .coefficients
            .iter()
            .map(|node| (0..rows.len()).map(|m| product(g, second, &rows, node, m)).collect())
            .collect();
        let mut packed = Vec::new();
        for (i, node) in self.coefficients.iter().enumerate() {
            let blocks: Vec<[[ExprId; 3]; 3]> =
                products[..=i].iter().map(|product| block(g, &rows, node, product)).collect();
            for row in 0..3 {
                for (j, block) in blocks.iter().enumerate() {
                    let columns = if j == i { row + 1 } else { 3 };
                    packed.extend(&block[row][..columns]);
                }
            }
        }
        packed
    }
}

fn classify(g: &mut Graph, row: &[[[ExprId; 3]; 3]]) -> Rows {
    if row.iter().flatten().flatten().all(|&x| g.is_zero(x)) {
        return Rows::Zero;
    }
    let scaled = [0, 1, 2].map(|axis| {
        let entries: Vec<ExprId> = row.iter().flat_map(|block| block[axis]).collect();
        g.common_factor(&entries)
    });
    if scaled.iter().any(|row| row.direction != scaled[0].direction) {
        return Rows::Full;
    }
    let directions = scaled[0].direction.chunks_exact(3).map(|d| [d[0], d[1], d[2]]).collect();
    Rows::RankOne { scale: scaled.map(|row| row.scale), directions }
}

/// W_jm for the coefficients of node j.
fn product(g: &mut Graph, second: &SecondDerivative, rows: &[Rows], node: &[ExprId], m: usize) -> Product {
    match &rows[m] {
        Rows::Zero => Product::Zero,
        Rows::RankOne { directions, .. } => Product::RankOne(combination(g, node, directions)),
        Rows::Full => {
            let mut matrix = [[g.zero(); 3]; 3];
            for (l, row) in rows.iter().enumerate() {
                if !matches!(row, Rows::Full) {
                    continue;
                }
                for a in 0..3 {
                    for b in 0..3 {
                        // Of a symmetric matrix the lower triangle is read.
                        let entry = if (m, a) >= (l, b) { second[m][l][a][b] } else { second[l][m][b][a] };
                        let term = g.mul(node[l], entry);
                        matrix[a][b] = g.add(matrix[a][b], term);
                    }
                }
            }
            // K_ml = K_lmᵀ = direction ⊗ scale
            for (scale, members) in groups(rows) {
                let members: Vec<(ExprId, [ExprId; 3])> =
                    members.into_iter().map(|(l, directions)| (node[l], directions[m])).collect();
                let along = sum_of_multiples(g, &members);
                add_outer(g, &mut matrix, along, scale);
            }
            Product::Full(matrix)
        }
    }
}

/// Σ_m c_im W_jm
fn block(g: &mut Graph, rows: &[Rows], node: &[ExprId], products: &[Product]) -> [[ExprId; 3]; 3] {
    let mut total = [[g.zero(); 3]; 3];
    for (&c, product) in node.iter().zip(products) {
        if let Product::Full(matrix) = product {
            for a in 0..3 {
                for b in 0..3 {
                    let term = g.mul(c, matrix[a][b]);
                    total[a][b] = g.add(total[a][b], term);
                }
            }
        }
    }
    for (scale, members) in groups(rows) {
        let members: Vec<(ExprId, [ExprId; 3])> = members
            .into_iter()
            .filter_map(|(m, _)| match &products[m] {
                Product::RankOne(w) => Some((node[m], *w)),
                Product::Zero | Product::Full(_) => None,
            })
            .collect();
        let along = sum_of_multiples(g, &members);
        add_outer(g, &mut total, scale, along);
    }
    total
}

/// The vectors of rank one with the same scale.
type Group<'a> = ([ExprId; 3], Vec<(usize, &'a [[ExprId; 3]])>);

fn groups(rows: &[Rows]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for (m, row) in rows.iter().enumerate() {
        let Rows::RankOne { scale, directions } = row else { continue };
        match groups.iter_mut().find(|(other, _)| other == scale) {
            Some((_, members)) => members.push((m, directions)),
            None => groups.push((*scale, vec![(m, directions)])),
        }
    }
    groups
}

/// Σ_l c_l v_l
fn combination(g: &mut Graph, coefficients: &[ExprId], vectors: &[[ExprId; 3]]) -> [ExprId; 3] {
    let members: Vec<(ExprId, [ExprId; 3])> =
        coefficients.iter().copied().zip(vectors.iter().copied()).collect();
    sum_of_multiples(g, &members)
}

fn sum_of_multiples(g: &mut Graph, members: &[(ExprId, [ExprId; 3])]) -> [ExprId; 3] {
    [0, 1, 2].map(|axis| {
        let (c, v): (Vec<ExprId>, Vec<ExprId>) = members.iter().map(|&(c, v)| (c, v[axis])).unzip();
        g.dot(&c, &v)
    })
}

/// matrix += x ⊗ y
fn add_outer(g: &mut Graph, matrix: &mut [[ExprId; 3]; 3], x: [ExprId; 3], y: [ExprId; 3]) {
    for a in 0..3 {
        for b in 0..3 {
            let term = g.mul(x[a], y[b]);
            matrix[a][b] = g.add(matrix[a][b], term);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Scope, SymbolId};
    use crate::interpret::{Interpreter, NodeInputs};

    /// G = ½ (v·v)² + (n·v)(n·w) + (m·z)(v·v) for v, w, z linear in three nodes: full rows for v, rank one for w and z.
    #[test]
    fn the_chain_rule_holds_for_full_and_for_rank_one_rows() {
        let mut g = Graph::new();
        let vector = |g: &mut Graph, name: &str| -> [ExprId; 3] {
            [0, 1, 2].map(|axis| g.input(&format!("{name}_{axis}"), Scope::Element))
        };
        let nodes: Vec<[ExprId; 3]> = (0..3).map(|k| vector(&mut g, &format!("x{k}"))).collect();
        let [n, m] = ["n", "m"].map(|name| vector(&mut g, name));
        let coefficients: Vec<Vec<ExprId>> = (0..3)
            .map(|k| (0..3).map(|l| g.input(&format!("c_{k}_{l}"), Scope::Element)).collect())
            .collect();
        let definitions: Vec<[ExprId; 3]> = (0..3)
            .map(|l| {
                [0, 1, 2].map(|axis| {
                    let column: Vec<ExprId> = coefficients.iter().map(|node| node[l]).collect();
                    let x: Vec<ExprId> = nodes.iter().map(|x| x[axis]).collect();
                    g.dot(&column, &x)
                })
            })
            .collect();
        let bound: Vec<[ExprId; 3]> = definitions
            .iter()
            .enumerate()
            .map(|(l, v)| [0, 1, 2].map(|axis| g.bind(&format!("v{l}_{axis}"), v[axis])))
            .collect();
        let function = |g: &mut Graph, [v, w, z]: [[ExprId; 3]; 3]| {
            let (vv, nv) = (g.dot(&v, &v), g.dot(&n, &v));
            let (nw, mz) = (g.dot(&n, &w), g.dot(&m, &z));
            let half = g.constant(0.5);
            let square = g.mul(vv, vv);
            let first = g.mul(half, square);
            let (second, third) = (g.mul(nv, nw), g.mul(mz, vv));
            g.total(&[first, second, third])
        };

        let of_bound = function(&mut g, [bound[0], bound[1], bound[2]]);
        let symbols: Vec<[SymbolId; 3]> = bound.iter().map(|v| v.map(|x| g.symbol_of(x))).collect();
        let first: Vec<[ExprId; 3]> =
            symbols.iter().map(|v| v.map(|symbol| g.derivative(of_bound, symbol))).collect();
        let second: SecondDerivative = first
            .iter()
            .map(|row| symbols.iter().map(|v| row.map(|x| v.map(|symbol| g.derivative(x, symbol)))).collect())
            .collect();
        let kinds: Vec<bool> =
            second.iter().map(|row| matches!(classify(&mut g, row), Rows::RankOne { .. })).collect();
        assert_eq!(kinds, [false, true, true]);
        let images = LinearImages::new(coefficients);
        let gradient = images.gradient(&mut g, &first);
        let hessian = images.hessian(&mut g, &second);

        // The same by plain differentiation of the function of the nodes.
        let of_nodes = function(&mut g, [definitions[0], definitions[1], definitions[2]]);
        let by: Vec<SymbolId> = nodes.iter().flatten().map(|&x| g.symbol_of(x)).collect();
        let expected: Vec<ExprId> = by.iter().map(|&x| g.derivative(of_nodes, x)).collect();
        let mut expected_hessian = Vec::new();
        for row in 0..by.len() {
            expected_hessian.extend((0..=row).map(|column| g.derivative(expected[row], by[column])));
        }
        let mut inputs = NodeInputs::new(0);
        let mut value = 0.3_f64;
        for index in 0..g.len() {
            if let crate::graph::Op::Symbol(symbol) = g.op(ExprId(index as u32)) {
                let data = g.symbol_data(symbol);
                if data.definition.is_none() {
                    value = (value * 7.3 + 0.17).fract();
                    inputs.set_element(&data.name, value - 0.4);
                }
            }
        }
        let mut interpreter = Interpreter::new(&g, &inputs);
        assert_eq!((gradient.len(), hessian.len()), (9, 45));
        for (found, expected) in gradient.iter().zip(&expected).chain(hessian.iter().zip(&expected_hessian)) {
            let difference = interpreter.element(*found) - interpreter.element(*expected);
            assert!(difference.abs() < 1e-15, "{difference:e}");
        }
    }
}
