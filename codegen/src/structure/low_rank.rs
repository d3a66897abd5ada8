//! Products of low rank, and sums of products that fuse.

use super::point::PointRows;
use crate::expr::{Expr, Mat3, Vec3};
use crate::graph::{ExprId, Scope};

/// One of the products a Hessian is made of off its diagonal: cᵢᵀ bⱼ + bᵢᵀ cⱼ for the row i and the column j.
#[derive(Clone, Copy, Debug)]
pub struct LowRankTerm {
    /// Its place among all products, those that vanish included.
    pub row: usize,
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
    /// The part of a point that takes part as one more node.
    pub point: Option<PointForm>,
}

/// The part of a point in a form, whose rows b are zero.
#[derive(Clone, Debug)]
pub struct PointForm {
    /// Its own block O.
    pub own: [[ExprId; 3]; 3],
    /// Its rows c, one for each product.
    pub c: Vec<[ExprId; 3]>,
}

impl LowRankForm {
    /// From the factors of a node, of the slave, and of a point if there is one; products that vanish are left out.
    pub(super) fn new(
        own: Mat3<'_>,
        node: &Factors<'_>,
        slave: &Factors<'_>,
        point: Option<&PointRows<'_>>,
    ) -> Self {
        let is_zero = |row: Vec3<'_>| row.iter().all(|x| x.is_zero());
        let vanishes = |k: usize| {
            is_zero(node.b[k]) || (is_zero(node.c[k]) && point.is_none_or(|point| is_zero(point.c[k])))
        };
        let products: Vec<usize> = (0..node.b.len()).filter(|&k| !vanishes(k)).collect();
        let term = |&k: &usize| LowRankTerm {
            row: k,
            b: [node.b[k].ids(), slave.b[k].ids()],
            c: [node.c[k].ids(), slave.c[k].ids()],
        };
        let point_form = |point: &PointRows<'_>| PointForm {
            own: point.own.ids(),
            c: products.iter().map(|&k| point.c[k].ids()).collect(),
        };
        Self { own: own.ids(), terms: products.iter().map(term).collect(), point: point.map(point_form) }
    }

    /// The same with other expressions.
    #[must_use]
    pub fn map(&self, mut new: impl FnMut(ExprId) -> ExprId) -> Self {
        let own = self.own.map(|row| row.map(&mut new));
        let terms = self.terms.iter().map(|term| LowRankTerm {
            row: term.row,
            b: term.b.map(|row| row.map(&mut new)),
            c: term.c.map(|row| row.map(&mut new)),
        });
        let terms = terms.collect();
        let point = self.point.as_ref().map(|point| PointForm {
            own: point.own.map(|row| row.map(&mut new)),
            c: point.c.iter().map(|row| row.map(&mut new)).collect(),
        });
        Self { own, terms, point }
    }
}

/// The factors B and C of a form by their rows: those of a node, or of the slave.
#[derive(PartialEq)]
pub(super) struct Factors<'g> {
    pub b: Vec<Vec3<'g>>,
    pub c: Vec<Vec3<'g>>,
}

impl<'g> Factors<'g> {
    /// `start` plus entry (row, column) of C₁ᵀB₂ + B₁ᵀC₂, with these factors first.
    pub fn product(&self, start: Expr<'g>, other: &Self, row: usize, column: usize) -> Expr<'g> {
        let mut all = products(&self.c, row, &other.b, column);
        let zero = start.sheet().zero();
        if row == column && self == other {
            return split_by_scope(all)
                .into_iter()
                .fold(start, |total, products| total + 2.0 * add_all(zero, products));
        }
        all.extend(products(&self.b, row, &other.c, column));
        if start.scope() == Scope::Element {
            return add_all(start, all);
        }
        let [same, varying] = split_by_scope(all);
        // A name keeps it whole.
        let same = add_all(zero, same).named("same_for_all_nodes");
        add_all(start + same, varying)
    }

    /// The same for the pair (row node, column node). What rows that are the same for all nodes contribute is computed
    /// once per element.
    pub fn pair(&self, row: usize, column: usize) -> Expr<'g> {
        let rows = |f: &[Vec3<'g>]| -> Vec<Expr<'g>> { f.iter().map(|r| r[row].at_row()).collect() };
        let columns = |f: &[Vec3<'g>]| -> Vec<Expr<'g>> { f.iter().map(|r| r[column].at_column()).collect() };
        let (b_row, c_row) = (rows(&self.b), rows(&self.c));
        let (b_column, c_column) = (columns(&self.b), columns(&self.c));
        let c_b = c_row.into_iter().zip(b_column);
        let all: Vec<Expr<'g>> = c_b.chain(b_row.into_iter().zip(c_column)).map(|(x, y)| x * y).collect();
        let sheet = self.b[0][0].sheet();
        let [same, varying] = split_by_scope(all);
        add_all(add_all(sheet.zero(), same), varying)
    }
}

/// Products of a column of one factor with one of another.
fn products<'g>(x: &[Vec3<'g>], row: usize, y: &[Vec3<'g>], column: usize) -> Vec<Expr<'g>> {
    x.iter().zip(y).map(|(x, y)| x[row] * y[column]).collect()
}

/// Terms of element scope, and the others.
fn split_by_scope(terms: Vec<Expr<'_>>) -> [Vec<Expr<'_>>; 2] {
    terms.into_iter().partition::<Vec<_>, _>(|term| term.scope() == Scope::Element).into()
}

/// start + Σ term, added from the left: every product fuses with its addition.
fn add_all<'g>(start: Expr<'g>, terms: Vec<Expr<'g>>) -> Expr<'g> {
    terms.into_iter().fold(start, |total, term| total + term)
}
