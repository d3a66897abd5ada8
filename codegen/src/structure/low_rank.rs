//! Hessians as products of low rank.

use super::point::PointRows;
use crate::expr::{Mat3, Vec3};
use crate::graph::ExprId;

/// One of the products a Hessian is made of off its diagonal: cᵢᵀ bⱼ + bᵢᵀ cⱼ for the row i and the column j.
#[derive(Clone, Copy, Debug)]
pub struct LowRankTerm {
    /// Its place among all products, those that vanish included.
    pub row: usize,
    /// Row b of a node.
    pub b: [ExprId; 3],
    /// Row c of a node.
    pub c: [ExprId; 3],
}

/// A Hessian over slave and nodes as Σ cᵀ b + bᵀ c plus, for every node, its own block O in the four places
/// of the difference between node and slave: O at (node, node) and (slave, slave), −O at (node, slave). The slave's rows are the negative
/// sums of the nodes', and of the point's where there is one.
#[derive(Clone, Debug)]
pub struct LowRankForm {
    /// O, symmetric.
    pub own: [[ExprId; 3]; 3],
    /// The products.
    pub terms: Vec<LowRankTerm>,
    /// The part of a point that takes part as one more node.
    pub point: Option<PointForm>,
}

/// The part of a point in a form, whose rows b are zero. Its own block stands where a node's does.
#[derive(Clone, Debug)]
pub struct PointForm {
    /// Its own block O.
    pub own: [[ExprId; 3]; 3],
    /// Its rows c, one for each product.
    pub c: Vec<[ExprId; 3]>,
}

impl LowRankForm {
    /// From the factors of a node, and of a point if there is one; products that vanish are left out.
    pub(super) fn new(own: Mat3<'_>, node: &Factors<'_>, point: Option<&PointRows<'_>>) -> Self {
        let is_zero = |row: Vec3<'_>| row.iter().all(|x| x.is_zero());
        let vanishes = |k: usize| {
            is_zero(node.b[k]) || (is_zero(node.c[k]) && point.is_none_or(|point| is_zero(point.c[k])))
        };
        let products: Vec<usize> = (0..node.b.len()).filter(|&k| !vanishes(k)).collect();
        let term = |&k: &usize| LowRankTerm { row: k, b: node.b[k].ids(), c: node.c[k].ids() };
        let point_form = |point: &PointRows<'_>| PointForm {
            own: point.own.ids(),
            c: products.iter().map(|&k| point.c[k].ids()).collect(),
        };
        Self { own: own.ids(), terms: products.iter().map(term).collect(), point: point.map(point_form) }
    }

    /// What the form is made of, in an order that keeps the bits of the kernels there are: what is lowered first is computed first. It is that
    /// of the sums over the products of the slave's own block.
    pub(crate) fn in_order_of_products(&self) -> Vec<ExprId> {
        let mut all = Vec::new();
        let own = |i: usize, j: usize| {
            let point = self.point.as_ref().map(|point| point.own[i][j]);
            point.into_iter().chain([self.own[i][j]])
        };
        let factors = |k: usize, b: usize, c: usize| {
            let point = self.point.as_ref().map(|point| point.c[k][c]);
            [self.terms[k].b[b]].into_iter().chain(point).chain([self.terms[k].c[c]])
        };
        let count = self.terms.len();
        for (i, j) in (0..3).flat_map(|j| (j..3).map(move |i| (i, j))) {
            if i == j {
                all.extend(own(i, i));
                all.extend((2..count).rev().chain(0..count.min(2)).flat_map(|k| factors(k, i, i)));
            } else {
                let mut products = (0..count).map(|k| (k, j, i)).chain((0..count).map(|k| (k, i, j)));
                let first = products.next();
                all.extend(products.rev().flat_map(|(k, b, c)| factors(k, b, c)));
                all.extend(own(i, j));
                all.extend(first.into_iter().flat_map(|(k, b, c)| factors(k, b, c)));
            }
        }
        all
    }

    /// The same with other expressions.
    #[must_use]
    pub fn map(&self, mut new: impl FnMut(ExprId) -> ExprId) -> Self {
        let own = self.own.map(|row| row.map(&mut new));
        let terms = self.terms.iter().map(|term| LowRankTerm {
            row: term.row,
            b: term.b.map(&mut new),
            c: term.c.map(&mut new),
        });
        let terms = terms.collect();
        let point = self.point.as_ref().map(|point| PointForm {
            own: point.own.map(|row| row.map(&mut new)),
            c: point.c.iter().map(|row| row.map(&mut new)).collect(),
        });
        Self { own, terms, point }
    }
}

/// The factors B and C of a form by a node's rows.
pub(super) struct Factors<'g> {
    pub b: Vec<Vec3<'g>>,
    pub c: Vec<Vec3<'g>>,
}
