//! Products of low rank, and sums of products that fuse.

use crate::graph::{ExprId, Graph};

pub(super) type Factors<'a> = (&'a [[ExprId; 3]], &'a [[ExprId; 3]]);

/// `start` plus entry (row, column) of C₁ᵀB₂ + B₁ᵀC₂ for factors (B, C).
pub(super) fn low_rank(
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
pub(super) fn low_rank_pair(
    g: &mut Graph,
    b: &[[ExprId; 3]],
    c: &[[ExprId; 3]],
    row: usize,
    column: usize,
) -> ExprId {
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
pub(super) fn add_products(g: &mut Graph, start: ExprId, x: &[ExprId], y: &[ExprId]) -> ExprId {
    x.iter().zip(y).fold(start, |total, (&x, &y)| {
        let product = g.mul(x, y);
        g.add(total, product)
    })
}
