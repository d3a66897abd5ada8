//! How equations for unknowns are solved, by the matrix of their derivatives.

use super::coordinates::CoordinateMap;
use super::follower::Follower;
use crate::expr::{Expr, System, dot, inverse_by_elimination};

/// How equations are solved.
#[derive(Clone, Debug)]
pub enum Elimination<'g> {
    /// A symmetric A, by its factor.
    Symmetric(System<'g>),
    /// Any A, by its inverse, rows of element expressions.
    Inverse(Vec<Vec<Expr<'g>>>),
}

impl<'g> Elimination<'g> {
    /// The inverse of A = −Σ dρ/dy, for residuals ρ whose unknowns y move what the coordinates say; all of it at the values.
    ///
    /// Rows are eliminated in order, without a search for pivots.
    pub fn of_residuals(
        name: &str,
        (unknowns, residual): (&[Expr<'g>], &[Expr<'g>]),
        coordinates: &CoordinateMap<'g>,
        values: &[(Expr<'g>, Expr<'g>)],
    ) -> Self {
        let y: Vec<Follower<'g>> = unknowns.iter().map(|&y| coordinates.follower(y)).collect();
        let entry = |i: usize, j: usize| {
            (-y[j].total_derivative(residual[i]).at(values).sum()).named(&format!("{name}_{i}_{j}"))
        };
        let size = y.len();
        let matrix: Vec<Vec<_>> = (0..size).map(|i| (0..size).map(|j| entry(i, j)).collect()).collect();
        Self::Inverse(inverse_by_elimination(&matrix, name))
    }

    /// A⁻¹ v, or A⁻ᵀ v; 0 for 0.
    pub(super) fn solve(&self, v: &[Expr<'g>], is_transposed: bool) -> Vec<Expr<'g>> {
        if v.iter().all(|x| x.is_zero()) {
            return v.to_vec();
        }
        let entry = |inverse: &[Vec<Expr<'g>>], k: usize| match is_transposed {
            true => dot(inverse.iter().map(|row| row[k]), v),
            false => dot(&inverse[k], v),
        };
        match self {
            Self::Symmetric(system) => system.solve_once(v),
            Self::Inverse(inverse) => (0..v.len()).map(|k| entry(inverse, k)).collect(),
        }
    }

    /// A⁻ᵀ v as variables `name_0`, …, the same ones for the same v; 0 for 0.
    pub(super) fn solve_transposed(&self, v: &[Expr<'g>], name: &str) -> Vec<Expr<'g>> {
        match self {
            Self::Symmetric(system) => system.solve_bound(v, name),
            Self::Inverse(_) if v.iter().all(|x| x.is_zero()) => v.to_vec(),
            Self::Inverse(_) => {
                let bound = |(k, x): (usize, Expr<'g>)| x.bind_once(&format!("{name}_{k}"));
                self.solve(v, true).into_iter().enumerate().map(bound).collect()
            }
        }
    }

    /// The factor in front of B: L⁻¹ v, rows in elimination order, or A⁻¹ v.
    pub(super) fn left(&self, v: &[Expr<'g>]) -> Vec<Expr<'g>> {
        match self {
            Self::Symmetric(system) => system.apply_inverse_factor(v),
            Self::Inverse(inverse) => inverse.iter().map(|row| dot(row, v)).collect(),
        }
    }

    /// The factor in front of C: L⁻¹ v, or v.
    pub(super) fn right(&self, v: &[Expr<'g>]) -> Vec<Expr<'g>> {
        match self {
            Self::Symmetric(system) => system.apply_inverse_factor(v),
            Self::Inverse(_) => v.to_vec(),
        }
    }

    /// S v at a position of v, in elimination order.
    pub(super) fn signed(&self, position: usize, x: Expr<'g>) -> Expr<'g> {
        match self {
            Self::Symmetric(system) if system.is_negative(position) => -x,
            _ => x,
        }
    }

    /// The K between rows B̂, symmetric, of which the lower triangle is read: L⁻¹ K L⁻ᵀ, or K itself, its lower triangle.
    pub(super) fn congruence(&self, lower: &[Vec<Expr<'g>>]) -> Vec<Vec<Expr<'g>>> {
        let Self::Symmetric(system) = self else { return lower.to_vec() };
        let size = lower.len();
        let entry = |row: usize, column: usize| lower[row.max(column)][row.min(column)];
        let solved = |entries: Vec<Expr<'g>>| system.apply_inverse_factor(&entries);
        let left: Vec<Vec<Expr<'g>>> =
            (0..size).map(|column| solved((0..size).map(|row| entry(row, column)).collect())).collect();
        (0..size).map(|row| solved(left.iter().map(|column| column[row]).collect())).collect()
    }
}
