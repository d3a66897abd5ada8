//! Symmetric systems among formulas.

use super::{Expr, Sheet, dot, ids};
use crate::graph::{Op, SymmetricSystem, SystemId};

/// A symmetric system of a [`Sheet`].
#[derive(Clone, Copy, Debug)]
pub struct System<'g> {
    sheet: &'g Sheet,
    id: SystemId,
}

impl SymmetricSystem {
    /// See [`new`](Self::new).
    pub fn of(name: &str, lower: &[Vec<Expr<'_>>], order: Vec<usize>) -> Self {
        Self::new(name, lower.iter().map(|row| ids(row)).collect(), order)
    }
}

impl Sheet {
    /// Adds a symmetric system.
    pub fn system(&self, system: SymmetricSystem) -> System<'_> {
        System { sheet: self, id: self.edit(|g| g.add_system(system)) }
    }
}

impl<'g> System<'g> {
    /// Its sheet.
    pub const fn sheet(self) -> &'g Sheet {
        self.sheet
    }

    /// A⁻¹ b
    pub fn solve(self, right_hand_side: &[Expr<'g>]) -> Vec<Expr<'g>> {
        self.sheet.exprs(self.sheet.edit(|g| g.solve_symmetric(self.id, ids(right_hand_side))))
    }

    /// The same; what was solved before is not solved again.
    pub(crate) fn solve_once(self, right_hand_side: &[Expr<'g>]) -> Vec<Expr<'g>> {
        self.sheet.exprs(self.sheet.edit(|g| g.solve_symmetric_once(self.id, &ids(right_hand_side))))
    }

    /// A⁻¹ b as variables `name_0`, …, the same ones for the same b; 0 for 0.
    pub fn solve_bound(self, right_hand_side: &[Expr<'g>], name: &str) -> Vec<Expr<'g>> {
        if right_hand_side.iter().all(|x| x.is_zero()) {
            return right_hand_side.to_vec();
        }
        let solution = self.sheet.edit(|g| g.solve_symmetric_once(self.id, &ids(right_hand_side)));
        let bound = |(k, x)| self.sheet.make(|g| g.bind_once(&format!("{name}_{k}"), x));
        solution.into_iter().enumerate().map(bound).collect()
    }

    /// L⁻¹ v, rows in elimination order.
    pub fn apply_inverse_factor(self, vector: &[Expr<'g>]) -> Vec<Expr<'g>> {
        let order = |k| self.sheet.graph().system(self.id).eliminated(k);
        let permuted: Vec<Expr<'g>> = (0..vector.len()).map(|k| vector[order(k)]).collect();
        let row = |row: usize| (0..=row).map(move |column| self.inverse_factor(row as u32, column as u32));
        (0..vector.len()).map(|k| dot(row(k), &permuted[..=k])).collect()
    }

    fn inverse_factor(self, row: u32, column: u32) -> Expr<'g> {
        self.sheet.make(|g| g.intern(Op::InverseFactor { system: self.id, row, column }))
    }

    /// Smallest pivot of the factorisation, relative to its reference.
    pub fn pivot_ratio(self) -> Expr<'g> {
        self.sheet.make(|g| g.intern(Op::PivotRatio(self.id)))
    }

    /// Whether the pivot at a position of the factorisation is negative.
    pub fn is_negative(self, position: usize) -> bool {
        self.sheet.graph().system(self.id).is_negative(position)
    }

    /// Entry (row, column) of the matrix.
    pub fn entry(self, row: usize, column: usize) -> Expr<'g> {
        let id = self.sheet.graph().system(self.id).entry(row, column);
        self.sheet.expr(id)
    }
}
