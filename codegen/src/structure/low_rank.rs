//! Products of low rank, and sums of products that fuse.

use crate::graph::{ExprId, Graph, Scope};

/// One of the products a Hessian is made of off its diagonal: cᵢᵀ bⱼ + bᵢᵀ cⱼ for the row i and the column j.
#[derive(Clone, Copy, Debug)]
pub struct LowRankTerm {
    /// Rows b of a node and of the slave.
    pub b: [[ExprId; 3]; 2],
    /// Rows c of a node and of the slave.
    pub c: [[ExprId; 3]; 2],
}

/// A Hessian over slave and nodes as Σ cᵀ b + bᵀ c plus, for every node, its own block O in the four places
/// of the difference between node and slave: O at (node, node) and (slave, slave), −O at (node, slave).
#[derive(Clone, Debug)]
pub struct LowRankForm {
    /// O, symmetric.
    pub own: [[ExprId; 3]; 3],
    /// The products.
    pub terms: Vec<LowRankTerm>,
}

impl LowRankForm {
    /// From the factors' rows, for a node and for the slave; products that vanish are left out.
    pub(super) fn new(own: [[ExprId; 3]; 3], g: &Graph, node: Factors<'_>, slave: Factors<'_>) -> Self {
        let is_zero = |row: &[ExprId; 3]| row.iter().all(|&x| g.is_zero(x));
        let terms = (0..node.0.len())
            .map(|k| LowRankTerm { b: [node.0[k], slave.0[k]], c: [node.1[k], slave.1[k]] })
            .filter(|term| !is_zero(&term.b[0]) && !is_zero(&term.c[0]))
            .collect();
        Self { own, terms }
    }

    /// The same with other expressions.
    #[must_use]
    pub fn map(&self, mut new: impl FnMut(ExprId) -> ExprId) -> Self {
        let own = self.own.map(|row| row.map(&mut new));
        let terms = self.terms.iter().map(|term| LowRankTerm {
            b: term.b.map(|row| row.map(&mut new)),
            c: term.c.map(|row| row.map(&mut new)),
        });
        Self { own, terms: terms.collect() }
    }
}

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
    let one_way = products(g, &column_of(first.1, row), &column_of(second.0, column));
    if row == column && first == second {
        let two = g.constant(2.0);
        return split_by_scope(g, one_way).into_iter().fold(start, |total, products| {
            let sum = g.total(&products);
            add_products(g, total, &[two], &[sum])
        });
    }
    let mut all = one_way;
    all.extend(products(g, &column_of(first.0, row), &column_of(second.1, column)));
    if g.scope(start) == Scope::Element {
        return add_all(g, start, all);
    }
    let [same, varying] = split_by_scope(g, all);
    let same = g.total(&same);
    // A name keeps it whole.
    g.name(same, "same_for_all_nodes");
    let start = g.add(start, same);
    add_all(g, start, varying)
}

/// The same for the pair (row node, column node). What rows that are the same for all nodes contribute is computed once
/// per element.
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
    let mut all = products(g, &c_row, &b_column);
    all.extend(products(g, &b_row, &c_column));
    let [same, varying] = split_by_scope(g, all);
    let start = g.total(&same);
    add_all(g, start, varying)
}

/// Entries of one column of a factor.
fn column_of(rows: &[[ExprId; 3]], axis: usize) -> Vec<ExprId> {
    rows.iter().map(|row| row[axis]).collect()
}

fn products(g: &mut Graph, x: &[ExprId], y: &[ExprId]) -> Vec<ExprId> {
    x.iter().zip(y).map(|(&x, &y)| g.mul(x, y)).collect()
}

/// Terms of element scope, and the others.
fn split_by_scope(g: &Graph, terms: Vec<ExprId>) -> [Vec<ExprId>; 2] {
    terms.into_iter().partition::<Vec<_>, _>(|&term| g.scope(term) == Scope::Element).into()
}

/// start + Σ term, added from the left.
fn add_all(g: &mut Graph, start: ExprId, terms: Vec<ExprId>) -> ExprId {
    terms.into_iter().fold(start, |total, term| g.add(total, term))
}

/// start + Σ x_k y_k, added from the left so that every product fuses with its addition.
pub(super) fn add_products(g: &mut Graph, start: ExprId, x: &[ExprId], y: &[ExprId]) -> ExprId {
    x.iter().zip(y).fold(start, |total, (&x, &y)| {
        let product = g.mul(x, y);
        g.add(total, product)
    })
}
