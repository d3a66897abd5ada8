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

use super::definition::Intermediate;
use super::factors::common_factor;
use crate::expr::{AXES, Expr, Mat3, Vec3, Vector, dot};

/// Coefficients c_km of vectors that are linear in the positions of nodes; `[node][vector]`.
#[derive(Clone, Debug)]
pub struct LinearImages<'g> {
    coefficients: Vec<Vec<Expr<'g>>>,
}

/// K_ml = ∂²G/∂v_m∂v_l as `[m][l]`.
pub type SecondDerivative<'g> = Vec<Vec<Mat3<'g>>>;

/// The rows of K that belong to one vector.
enum Rows<'g> {
    /// No entry but zeros.
    Zero,
    /// K_ml = scale ⊗ direction_l.
    RankOne { scale: Vec3<'g>, directions: Vec<Vec3<'g>> },
    /// Anything else.
    Full,
}

/// W_jm of one node j: a matrix, or the vector w of scale ⊗ w.
enum Product<'g> {
    Zero,
    RankOne(Vec3<'g>),
    Full(Mat3<'g>),
}

impl<'g> LinearImages<'g> {
    /// Vectors from their coefficients, one row per node.
    pub const fn new(coefficients: Vec<Vec<Expr<'g>>>) -> Self {
        Self { coefficients }
    }

    /// dG/dx from ∂G/∂v, three entries per node.
    pub fn gradient(&self, first: &[Vec3<'g>]) -> Vec<Expr<'g>> {
        self.coefficients.iter().flat_map(|node| sum_of_multiples(node, first).0).collect()
    }

    /// d²G/dx² from K, the packed lower triangle row by row. Where a block of K and its transpose are both there, as K
    /// is symmetric, one of them is used.
    pub fn hessian(&self, second: &SecondDerivative<'g>) -> Vec<Expr<'g>> {
        let rows: Vec<Rows<'g>> = second.iter().map(|row| classify(row)).collect();
        let of_node =
            |node: &Vec<Expr<'g>>| (0..rows.len()).map(|m| product(second, &rows, node, m)).collect();
        let products: Vec<Vec<Product<'g>>> = self.coefficients.iter().map(of_node).collect();
        let mut packed = Vec::new();
        for (i, node) in self.coefficients.iter().enumerate() {
            let blocks: Vec<Mat3<'g>> =
                products[..=i].iter().map(|product| block(&rows, node, product)).collect();
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

/// Intermediates as vectors that are linear in vectors of nodes, which the variables are, three for each: the coefficients, and of each
/// vector the places of its entries. None if there is an intermediate of another kind.
pub(super) fn vectors_of_nodes<'g>(
    intermediates: &[Intermediate<'g>],
    variables: &[Expr<'g>],
) -> Option<(LinearImages<'g>, Vec<[usize; 3]>)> {
    let names: Vec<String> = intermediates.iter().map(|v| v.symbol.symbol_name()).collect();
    let first = names.iter().filter_map(|name| name.strip_suffix("_x"));
    let place = |vector: &str, axis: &str| names.iter().position(|name| *name == format!("{vector}_{axis}"));
    let vectors: Vec<[usize; 3]> = first
        .map(|vector| {
            let [x, y, z] = AXES.map(|axis| place(vector, axis));
            Some([x?, y?, z?])
        })
        .collect::<Option<_>>()?;
    if 3 * vectors.len() != intermediates.len() || !variables.len().is_multiple_of(3) || vectors.is_empty() {
        return None;
    }
    let is_free = |x: Expr<'g>| variables.iter().all(|&variable| !x.contains(variable));
    let coefficient = |vector: &[usize; 3], node: &[Expr<'g>]| {
        let by = |a: usize, b: usize| intermediates[vector[a]].definition.by(node[b]);
        let c = by(0, 0);
        let is_multiple =
            (0..3).all(|a| (0..3).all(|b| if a == b { by(a, b) == c } else { by(a, b).is_zero() }));
        (is_multiple && is_free(c)).then_some(c)
    };
    let coefficients: Option<Vec<Vec<Expr<'g>>>> =
        variables.chunks(3).map(|node| vectors.iter().map(|v| coefficient(v, node)).collect()).collect();
    Some((LinearImages::new(coefficients?), vectors))
}

fn classify<'g>(row: &[Mat3<'g>]) -> Rows<'g> {
    if row.iter().all(|block| block.as_flattened().iter().all(|x| x.is_zero())) {
        return Rows::Zero;
    }
    let scaled = [0, 1, 2].map(|axis| {
        let entries: Vec<Expr<'g>> = row.iter().flat_map(|block| block[axis]).collect();
        common_factor(&entries)
    });
    if scaled.iter().any(|row| row.direction != scaled[0].direction) {
        return Rows::Full;
    }
    let directions = scaled[0].direction.chunks_exact(3).map(|d| Vector([d[0], d[1], d[2]])).collect();
    Rows::RankOne { scale: Vector(scaled.map(|row| row.scale)), directions }
}

/// W_jm for the coefficients of node j.
fn product<'g>(second: &SecondDerivative<'g>, rows: &[Rows<'g>], node: &[Expr<'g>], m: usize) -> Product<'g> {
    match &rows[m] {
        Rows::Zero => Product::Zero,
        Rows::RankOne { directions, .. } => Product::RankOne(sum_of_multiples(node, directions)),
        Rows::Full => {
            let mut matrix = Mat3::zero(node[0].sheet());
            for l in (0..rows.len()).filter(|&l| matches!(rows[l], Rows::Full)) {
                // Of a symmetric matrix the lower triangle is read.
                let lower = |a: usize, b: usize| {
                    if (m, a) >= (l, b) { second[m][l][a][b] } else { second[l][m][b][a] }
                };
                matrix += node[l] * Mat3::from_fn(lower);
            }
            // K_ml = K_lmᵀ = direction ⊗ scale
            for (scale, members) in groups(rows) {
                let (c, directions): (Vec<_>, Vec<_>) =
                    members.into_iter().map(|(l, directions)| (node[l], directions[m])).unzip();
                matrix += sum_of_multiples(&c, &directions).outer(scale);
            }
            Product::Full(matrix)
        }
    }
}

/// Σ_m c_im W_jm
fn block<'g>(rows: &[Rows<'g>], node: &[Expr<'g>], products: &[Product<'g>]) -> Mat3<'g> {
    let mut total = Mat3::zero(node[0].sheet());
    for (&c, product) in node.iter().zip(products) {
        if let Product::Full(matrix) = product {
            total += c * *matrix;
        }
    }
    for (scale, members) in groups(rows) {
        let multiples = members.into_iter().filter_map(|(m, _)| match products[m] {
            Product::RankOne(w) => Some((node[m], w)),
            Product::Zero | Product::Full(_) => None,
        });
        let (c, w): (Vec<_>, Vec<_>) = multiples.unzip();
        total += scale.outer(sum_of_multiples(&c, &w));
    }
    total
}

/// The vectors of rank one with the same scale.
type Group<'a, 'g> = (Vec3<'g>, Vec<(usize, &'a [Vec3<'g>])>);

fn groups<'a, 'g>(rows: &'a [Rows<'g>]) -> Vec<Group<'a, 'g>> {
    let mut groups: Vec<Group<'a, 'g>> = Vec::new();
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
fn sum_of_multiples<'g>(c: &[Expr<'g>], v: &[Vec3<'g>]) -> Vec3<'g> {
    Vector::from_fn(|axis| dot(c, v.iter().map(|v| v[axis])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Sheet;
    use crate::graph::{Op, Scope};
    use crate::interpret::{Interpreter, NodeInputs};

    /// G = ½ (v·v)² + (n·v)(n·w) + (m·z)(v·v)
    fn function<'g>([n, m]: [Vec3<'g>; 2], [v, w, z]: [Vec3<'g>; 3]) -> Expr<'g> {
        0.5 * v.dot(v).powi(2) + n.dot(v) * n.dot(w) + m.dot(z) * v.dot(v)
    }

    /// For v, w, z linear in three nodes: full rows for v, rank one for w and z.
    #[test]
    fn the_chain_rule_holds_for_full_and_for_rank_one_rows() {
        let sheet = Sheet::new();
        let vector = |name: &str| sheet.vector(name, Scope::Element);
        let nodes = ["x0", "x1", "x2"].map(vector);
        let [n, m] = ["n", "m"].map(vector);
        let coefficients: Vec<Vec<_>> = (0..3)
            .map(|k| (0..3).map(|l| sheet.input(&format!("c_{k}_{l}"), Scope::Element)).collect())
            .collect();
        let definitions = [0, 1, 2].map(|l| {
            let column: Vec<_> = coefficients.iter().map(|node| node[l]).collect();
            sum_of_multiples(&column, &nodes)
        });
        let bound = [0, 1, 2].map(|l| definitions[l].bind(&format!("v{l}")));
        let of_bound = function([n, m], bound);
        let first = bound.map(|v| of_bound.gradient(v));
        let second: SecondDerivative<'_> =
            first.iter().map(|row| bound.iter().map(|&v| row.jacobian(v)).collect()).collect();
        let kinds: Vec<bool> =
            second.iter().map(|row| matches!(classify(row), Rows::RankOne { .. })).collect();
        assert_eq!(kinds, [false, true, true]);
        let images = LinearImages::new(coefficients);
        let (gradient, hessian) = (images.gradient(&first), images.hessian(&second));

        // The same by plain differentiation of the function of the nodes.
        let of_nodes = function([n, m], definitions);
        let by: Vec<_> = nodes.iter().flat_map(|x| x.0).collect();
        let expected: Vec<_> = by.iter().map(|&x| of_nodes.by(x)).collect();
        let expected_hessian = (0..by.len()).flat_map(|row| by[..=row].iter().map(move |&x| (row, x)));
        let expected_hessian: Vec<_> = expected_hessian.map(|(row, x)| expected[row].by(x)).collect();
        let mut inputs = NodeInputs::new(0);
        let mut value = 0.3_f64;
        let graph = sheet.graph();
        for index in 0..graph.len() {
            if let Op::Symbol(symbol) = graph.op(crate::graph::ExprId(index as u32)) {
                let data = graph.symbol_data(symbol);
                if data.definition.is_none() {
                    value = (value * 7.3 + 0.17).fract();
                    inputs.set_element(&data.name, value - 0.4);
                }
            }
        }
        let mut interpreter = Interpreter::new(&graph, &inputs);
        assert_eq!((gradient.len(), hessian.len()), (9, 45));
        for (found, expected) in gradient.iter().zip(&expected).chain(hessian.iter().zip(&expected_hessian)) {
            let difference = interpreter.element(found.id()) - interpreter.element(expected.id());
            assert!(difference.abs() < 1e-15, "{difference:e}");
        }
    }
}
