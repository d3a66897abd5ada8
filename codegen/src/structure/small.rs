//! Linear systems of two or three unknowns by Cramer's rule.

use crate::graph::{ExprId, Graph};

impl Graph {
    /// Determinant by expansion along the first row.
    ///
    /// # Panics
    /// If the matrix is empty or larger than 3 × 3, where expansion is no longer the right method.
    pub fn determinant(&mut self, matrix: &[Vec<ExprId>]) -> ExprId {
        assert!((1..=3).contains(&matrix.len()), "determinants by expansion are for 1 to 3 rows");
        if let [row] = matrix {
            return row[0];
        }
        let mut total = self.zero();
        for column in 0..matrix.len() {
            let minor: Vec<Vec<ExprId>> = matrix[1..]
                .iter()
                .map(|row| row.iter().enumerate().filter(|(k, _)| *k != column).map(|(_, &x)| x).collect())
                .collect();
            let minor = self.determinant(&minor);
            let term = self.mul(matrix[0][column], minor);
            total = if column % 2 == 0 { self.add(total, term) } else { self.sub(total, term) };
        }
        total
    }

    /// Solution of `matrix` x = `right_hand_side`.
    ///
    /// # Panics
    /// As [`determinant`](Self::determinant).
    pub fn solve_small(&mut self, matrix: &[Vec<ExprId>], right_hand_side: &[ExprId]) -> Vec<ExprId> {
        let determinant = self.determinant(matrix);
        let one = self.one();
        let reciprocal = self.div(one, determinant);
        (0..matrix.len())
            .map(|column| {
                let mut replaced = matrix.to_vec();
                for (row, &b) in replaced.iter_mut().zip(right_hand_side) {
                    row[column] = b;
                }
                let numerator = self.determinant(&replaced);
                self.mul(numerator, reciprocal)
            })
            .collect()
    }

    /// Inverse of `matrix`, by rows.
    ///
    /// # Panics
    /// As [`determinant`](Self::determinant).
    pub fn inverse_small(&mut self, matrix: &[Vec<ExprId>]) -> Vec<Vec<ExprId>> {
        let size = matrix.len();
        let columns: Vec<Vec<ExprId>> = (0..size)
            .map(|column| {
                let unit: Vec<ExprId> =
                    (0..size).map(|row| self.constant(f64::from(u8::from(row == column)))).collect();
                self.solve_small(matrix, &unit)
            })
            .collect();
        (0..size).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpret::{Interpreter, NodeInputs};

    #[test]
    fn three_equations() {
        let mut g = Graph::new();
        let rows = [[2.0, 1.0, 0.0], [1.0, 3.0, -1.0], [0.5, 0.0, 4.0]];
        let solution = [1.0, -2.0, 3.0];
        let matrix: Vec<Vec<ExprId>> =
            rows.iter().map(|row| row.iter().map(|&x| g.constant(x)).collect()).collect();
        let b: Vec<ExprId> =
            rows.iter().map(|row| g.constant(row.iter().zip(solution).map(|(a, x)| a * x).sum())).collect();
        let x = g.solve_small(&matrix, &b);
        let inputs = NodeInputs::new(0);
        let mut interpreter = Interpreter::new(&g, &inputs);
        for (x, expected) in x.into_iter().zip(solution) {
            assert!((interpreter.element(x) - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn an_inverse_of_three_rows() {
        let mut g = Graph::new();
        let rows = [[2.0, 1.0, 0.0], [1.0, 3.0, -1.0], [0.5, 0.0, 4.0]];
        let matrix: Vec<Vec<ExprId>> =
            rows.iter().map(|row| row.iter().map(|&x| g.constant(x)).collect()).collect();
        let inverse = g.inverse_small(&matrix);
        let inputs = NodeInputs::new(0);
        let mut interpreter = Interpreter::new(&g, &inputs);
        for (i, row) in rows.iter().enumerate() {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| row[k] * interpreter.element(inverse[k][j])).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }
}
