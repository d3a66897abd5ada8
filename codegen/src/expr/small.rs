//! Linear systems: of up to three unknowns by Cramer's rule, of more by elimination.

use super::{Expr, ids};
use crate::graph::{ExprId, Graph};

/// Most unknowns of a system that is solved by determinants.
pub(crate) const MOST_BY_CRAMER: usize = 3;

/// Determinant by expansion along the first row.
///
/// # Panics
/// If the matrix is empty or larger than 3 × 3, where expansion is no longer the right method.
pub fn determinant<'g>(matrix: &[Vec<Expr<'g>>]) -> Expr<'g> {
    assert!((1..=MOST_BY_CRAMER).contains(&matrix.len()), "determinants by expansion are for 1 to 3 rows");
    if let [row] = matrix {
        return row[0];
    }
    let mut total = matrix[0][0].sheet().zero();
    for (column, &entry) in matrix[0].iter().enumerate() {
        let minor: Vec<_> =
            matrix[1..].iter().map(|row| [&row[..column], &row[column + 1..]].concat()).collect();
        let term = entry * determinant(&minor);
        total = if column % 2 == 0 { total + term } else { total - term };
    }
    total
}

/// Solution of `matrix` x = `right_hand_side`.
///
/// # Panics
/// As [`determinant`].
pub fn solve<'g>(matrix: &[Vec<Expr<'g>>], right_hand_side: &[Expr<'g>]) -> Vec<Expr<'g>> {
    let reciprocal = 1.0 / determinant(matrix);
    (0..matrix.len())
        .map(|column| {
            let mut replaced = matrix.to_vec();
            for (row, &b) in replaced.iter_mut().zip(right_hand_side) {
                row[column] = b;
            }
            determinant(&replaced) * reciprocal
        })
        .collect()
}

/// Inverse of `matrix`, by rows.
///
/// # Panics
/// As [`determinant`].
pub fn inverse<'g>(matrix: &[Vec<Expr<'g>>]) -> Vec<Vec<Expr<'g>>> {
    let (size, sheet) = (matrix.len(), matrix[0][0].sheet());
    let columns: Vec<_> = (0..size)
        .map(|column| {
            let unit: Vec<_> =
                (0..size).map(|row| sheet.number(f64::from(u8::from(row == column)))).collect();
            solve(matrix, &unit)
        })
        .collect();
    (0..size).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
}

/// Inverse of `matrix`, by rows, by elimination in the order of its rows: pivots are not searched for. What it makes is bound to
/// `name_step_1`, …, so that derivatives see the inverse as a constant.
pub fn inverse_by_elimination<'g>(matrix: &[Vec<Expr<'g>>], name: &str) -> Vec<Vec<Expr<'g>>> {
    let (size, sheet) = (matrix.len(), matrix[0][0].sheet());
    // (matrix | identity) → (identity | inverse)
    let unit = |row: usize| (0..size).map(move |column| sheet.number(f64::from(u8::from(row == column))));
    let mut rows: Vec<Vec<_>> =
        matrix.iter().enumerate().map(|(k, row)| row.iter().copied().chain(unit(k)).collect()).collect();
    let mut step = 0;
    let mut bound = |x: Expr<'g>| {
        step += 1;
        if x.value().is_some() { x } else { x.bind(&format!("{name}_step_{step}")) }
    };
    for pivot in 0..size {
        let reciprocal = bound(1.0 / rows[pivot][pivot]);
        for x in &mut rows[pivot][pivot + 1..] {
            *x = bound(*x * reciprocal);
        }
        let scaled = rows[pivot].clone();
        for row in rows.iter_mut().enumerate().filter_map(|(k, row)| (k != pivot).then_some(row)) {
            let factor = row[pivot];
            for (x, &y) in row.iter_mut().zip(&scaled).skip(pivot + 1) {
                let changed = *x - factor * y;
                if changed != *x {
                    *x = bound(changed);
                }
            }
        }
    }
    rows.into_iter().map(|row| row[size..].to_vec()).collect()
}

impl Graph {
    /// The same by ids, for the engine: see [`solve`].
    pub(crate) fn solve_small(&mut self, matrix: &[Vec<ExprId>], right_hand_side: &[ExprId]) -> Vec<ExprId> {
        self.write(|sheet| {
            let matrix: Vec<_> = matrix.iter().map(|row| sheet.exprs(row)).collect();
            ids(&solve(&matrix, &sheet.exprs(right_hand_side)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Sheet;
    use crate::interpret::{Interpreter, NodeInputs};

    #[test]
    fn an_inverse_by_elimination() {
        let sheet = Sheet::new();
        let rows = [[2.0, 1.0, 0.0, 0.3], [1.0, 3.0, -1.0, 0.0], [0.5, 0.0, 4.0, 1.0], [0.0, -0.7, 0.2, 5.0]];
        let matrix = rows.map(|row| row.map(|x| sheet.number(x)).to_vec());
        let inverse = inverse_by_elimination(&matrix, "test");
        let (graph, inputs) = (sheet.graph(), NodeInputs::new(0));
        let mut interpreter = Interpreter::new(&graph, &inputs);
        for (i, row) in rows.iter().enumerate() {
            for j in 0..4 {
                let product: f64 = (0..4).map(|k| row[k] * interpreter.element(inverse[k][j].id())).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }
}
