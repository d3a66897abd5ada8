//! Vectors and matrices of a few expressions.

use std::ops::{Deref, DerefMut};

use super::{AXES, Expr, Sheet, Term, Values, dot, small, total};
use crate::graph::ExprId;

/// A vector of N expressions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vector<'g, const N: usize>(pub [Expr<'g>; N]);

/// A matrix of R rows and C columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Matrix<'g, const R: usize, const C: usize>(pub [[Expr<'g>; C]; R]);

/// A vector in a plane.
pub type Vec2<'g> = Vector<'g, 2>;
/// A vector in space.
pub type Vec3<'g> = Vector<'g, 3>;
/// A 2 × 2 matrix.
pub type Mat2<'g> = Matrix<'g, 2, 2>;
/// A 3 × 3 matrix.
pub type Mat3<'g> = Matrix<'g, 3, 3>;

impl<'g, const N: usize> Vector<'g, N> {
    /// The vector of `entry(k)`.
    pub fn from_fn(entry: impl FnMut(usize) -> Expr<'g>) -> Self {
        Self(std::array::from_fn(entry))
    }

    /// The vector of numbers.
    pub fn numbers(sheet: &'g Sheet, values: [f64; N]) -> Self {
        Self(values.map(|value| sheet.number(value)))
    }

    /// Zeros.
    pub fn zero(sheet: &'g Sheet) -> Self {
        Self([sheet.zero(); N])
    }

    /// Each entry changed.
    #[must_use]
    pub fn map(self, change: impl FnMut(Expr<'g>) -> Expr<'g>) -> Self {
        Self(self.0.map(change))
    }

    /// Each pair of entries put together.
    #[must_use]
    pub fn zip(self, other: Self, mut both: impl FnMut(Expr<'g>, Expr<'g>) -> Expr<'g>) -> Self {
        Self::from_fn(|k| both(self[k], other[k]))
    }

    /// Ids of the entries.
    pub fn ids(self) -> [ExprId; N] {
        self.0.map(Expr::id)
    }

    /// x · y
    #[track_caller]
    pub fn dot(self, other: Self) -> Expr<'g> {
        dot(self.0, other.0)
    }

    /// √(x · x). Its direction is 0 at the origin, where energies that are smooth have their derivatives all the same.
    #[track_caller]
    pub fn norm(self) -> Expr<'g> {
        match self.0.as_slice() {
            [] => panic!("a vector without entries has no norm"),
            [x] => x.hypot(0.0),
            [first, rest @ ..] => rest.iter().fold(*first, |norm, &x| norm.hypot(x)),
        }
    }

    /// x/√(x · x), and 0 for x = 0. Its derivatives are NaN there: those of `x * x.norm().reciprocal_or_zero()` are 0, for a few
    /// operations more.
    #[must_use]
    pub fn unit(self) -> Self {
        self * self.dot(self).sqrt().reciprocal_or_zero()
    }

    /// x yᵀ
    pub fn outer<const C: usize>(self, other: Vector<'g, C>) -> Matrix<'g, N, C> {
        Matrix::from_fn(|row, column| self[row] * other[column])
    }

    /// Names the entries `name_x`, `name_y`, `name_z`, of other lengths than three `name_1`, ….
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self::from_fn(|k| self[k].named(&entry_name::<N>(name, k)))
    }

    /// Binds the entries to symbols, named as by [`named`](Self::named).
    #[must_use]
    pub fn bind(self, name: &str) -> Self {
        Self::from_fn(|k| self[k].bind(&entry_name::<N>(name, k)))
    }

    /// Derivatives of the entries by a symbol.
    #[must_use]
    pub fn by(self, symbol: Expr<'g>) -> Self {
        self.map(|x| x.by(symbol))
    }

    /// The entries where symbols have other values.
    #[must_use]
    pub fn at(self, values: &[(Expr<'g>, Expr<'g>)]) -> Self {
        self.map(|x| x.at(values))
    }

    /// The entries, symbols, with the values they take: for [`Expr::at`].
    #[must_use]
    pub fn set_to(self, values: Self) -> Values<'g> {
        self.0.into_iter().zip(values.0).collect()
    }

    /// ∂(entry i)/∂(symbol j)
    pub fn jacobian<const C: usize>(self, symbols: Vector<'g, C>) -> Matrix<'g, N, C> {
        Matrix::from_fn(|row, column| self[row].by(symbols[column]))
    }
}

impl<'g> Vec3<'g> {
    /// x × y
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self::from_fn(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            self[i] * other[j] - self[j] * other[i]
        })
    }
}

impl<'g> Expr<'g> {
    /// Derivatives by the symbols of a vector.
    pub fn gradient<const N: usize>(self, symbols: Vector<'g, N>) -> Vector<'g, N> {
        symbols.map(|symbol| self.by(symbol))
    }
}

pub(crate) fn entry_name<const N: usize>(name: &str, k: usize) -> String {
    if N == 3 { format!("{name}_{}", AXES[k]) } else { format!("{name}_{}", k + 1) }
}

impl<'g, const R: usize, const C: usize> Matrix<'g, R, C> {
    /// Zeros.
    pub fn zero(sheet: &'g Sheet) -> Self {
        Self([[sheet.zero(); C]; R])
    }

    /// The matrix of `entry(row, column)`.
    pub fn from_fn(mut entry: impl FnMut(usize, usize) -> Expr<'g>) -> Self {
        Self(std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column))))
    }

    /// Each entry changed.
    #[must_use]
    pub fn map(self, mut change: impl FnMut(Expr<'g>) -> Expr<'g>) -> Self {
        Self(self.0.map(|row| row.map(&mut change)))
    }

    /// Each pair of entries put together.
    #[must_use]
    pub fn zip(self, other: Self, mut both: impl FnMut(Expr<'g>, Expr<'g>) -> Expr<'g>) -> Self {
        Self::from_fn(|row, column| both(self[row][column], other[row][column]))
    }

    /// Ids of the entries.
    pub fn ids(self) -> [[ExprId; C]; R] {
        self.0.map(|row| row.map(Expr::id))
    }

    /// The matrix of these columns.
    pub fn from_columns(columns: [Vector<'g, R>; C]) -> Self {
        Self::from_fn(|row, column| columns[column][row])
    }

    /// A row.
    pub fn row(self, row: usize) -> Vector<'g, C> {
        Vector(self[row])
    }

    /// A column.
    pub fn column(self, column: usize) -> Vector<'g, R> {
        Vector::from_fn(|row| self[row][column])
    }

    /// Aᵀ
    #[must_use]
    pub fn transpose(self) -> Matrix<'g, C, R> {
        Matrix::from_fn(|row, column| self[column][row])
    }

    /// A : B = Σ a_ij b_ij
    pub fn double_dot(self, other: Self) -> Expr<'g> {
        dot(self.as_flattened(), other.as_flattened())
    }

    /// Names the entries `name_1_1`, ….
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self::from_fn(|row, column| self[row][column].named(&format!("{name}_{}_{}", row + 1, column + 1)))
    }

    /// Binds the entries to symbols, named as by [`named`](Self::named).
    #[must_use]
    pub fn bind(self, name: &str) -> Self {
        Self::from_fn(|row, column| self[row][column].bind(&format!("{name}_{}_{}", row + 1, column + 1)))
    }

    /// The entries where symbols have other values.
    #[must_use]
    pub fn at(self, values: &[(Expr<'g>, Expr<'g>)]) -> Self {
        self.map(|x| x.at(values))
    }

    fn rows(self) -> Vec<Vec<Expr<'g>>> {
        self.iter().map(|row| row.to_vec()).collect()
    }
}

impl<'g, const N: usize> Matrix<'g, N, N> {
    /// The symmetric matrix of `entry(row, column)`, of which the lower triangle is asked for.
    pub fn symmetric(mut entry: impl FnMut(usize, usize) -> Expr<'g>) -> Self {
        let lower: Vec<Vec<_>> =
            (0..N).map(|row| (0..=row).map(|column| entry(row, column)).collect()).collect();
        Self::from_fn(|row, column| lower[row.max(column)][row.min(column)])
    }

    /// Ones on the diagonal.
    pub fn identity(sheet: &'g Sheet) -> Self {
        Self::from_fn(|row, column| f64::from(u8::from(row == column)).on(sheet))
    }

    /// tr A
    pub fn trace(self) -> Expr<'g> {
        total((0..N).map(|k| self[k][k]))
    }

    /// det A, for one to three rows.
    pub fn determinant(self) -> Expr<'g> {
        const { assert!(1 <= N && N <= small::MOST_BY_CRAMER) }
        small::determinant(&self.rows())
    }

    /// A⁻¹ by Cramer's rule, for one to three rows.
    #[must_use]
    pub fn inverse(self) -> Self {
        const { assert!(1 <= N && N <= small::MOST_BY_CRAMER) }
        let rows = small::inverse(&self.rows());
        Self::from_fn(|row, column| rows[row][column])
    }

    /// A⁻¹ b by Cramer's rule, for one to three rows.
    pub fn solve(self, right_hand_side: Vector<'g, N>) -> Vector<'g, N> {
        const { assert!(1 <= N && N <= small::MOST_BY_CRAMER) }
        let solution = small::solve(&self.rows(), &right_hand_side.0);
        Vector::from_fn(|k| solution[k])
    }
}

impl<'g, const N: usize> Deref for Vector<'g, N> {
    type Target = [Expr<'g>; N];
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<const N: usize> DerefMut for Vector<'_, N> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl<'g, const R: usize, const C: usize> Deref for Matrix<'g, R, C> {
    type Target = [[Expr<'g>; C]; R];
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<const R: usize, const C: usize> DerefMut for Matrix<'_, R, C> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Scope;
    use crate::interpret::{Interpreter, NodeInputs};

    fn value(expr: Expr<'_>) -> f64 {
        let inputs = NodeInputs::new(0);
        Interpreter::new(&expr.sheet().graph(), &inputs).element(expr.id())
    }

    fn entries<const R: usize, const C: usize>(matrix: Matrix<'_, R, C>) -> Vec<f64> {
        matrix.as_flattened().iter().map(|&x| value(x)).collect()
    }

    #[test]
    fn products_of_vectors() {
        let sheet = Sheet::new();
        let [x, y] = [[1.0, 2.0, 2.0], [3.0, -1.0, 0.5]].map(|v| Vector::numbers(&sheet, v));
        assert_eq!((value(x.dot(y)), value(x.norm())), (2.0, 3.0));
        assert_eq!(x.cross(y).map(|z| z).0.map(value), [3.0, 5.5, -7.0]);
        assert_eq!((2.0 * (x - y) / 4.0).0.map(value), [-1.0, 1.5, 0.75]);
        assert!((value(x.unit().norm()) - 1.0).abs() < 1e-15);
        assert_eq!((x - x).unit().0.map(value), [0.0; 3]);
        let at = sheet.input("x", Scope::Element);
        let way = Vector([at, at, at]);
        let slope = (way * way.norm().reciprocal_or_zero()).by(at).at(&[(at, sheet.zero())]);
        assert_eq!(slope.0.map(value), [0.0; 3]);
    }

    #[test]
    fn products_of_matrices() {
        let sheet = Sheet::new();
        let a = Matrix([[1.0, 2.0, 3.0], [0.0, 1.0, 4.0]].map(|row| row.map(|x| sheet.number(x))));
        assert_eq!(entries(a * a.transpose()), [14.0, 14.0, 14.0, 17.0]);
        assert_eq!((a * Vector::numbers(&sheet, [1.0, 1.0, 2.0])).0.map(value), [9.0, 9.0]);
        assert_eq!((value(a.double_dot(a)), value((a * a.transpose()).trace())), (31.0, 31.0));
        let outer = a.row(0).outer(a.row(1));
        assert_eq!(entries(outer), [0.0, 1.0, 4.0, 0.0, 2.0, 8.0, 0.0, 3.0, 12.0]);
    }

    #[test]
    fn an_inverse_times_its_matrix_is_the_identity() {
        let sheet = Sheet::new();
        let a =
            Matrix([[2.0, 1.0, 0.0], [1.0, 3.0, -1.0], [0.5, 0.0, 4.0]].map(|r| r.map(|x| sheet.number(x))));
        let b = Matrix([[2.0, 1.0], [1.0, 3.0]].map(|r| r.map(|x| sheet.number(x))));
        assert_eq!((value(a.determinant()), value(b.determinant())), (19.5, 5.0));
        for (found, expected) in [
            (entries(a.inverse() * a), entries(Mat3::identity(&sheet))),
            (entries(b * b.inverse()), entries(Mat2::identity(&sheet))),
        ] {
            assert!(found.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-15), "{found:?}");
        }
        let x = Vector::numbers(&sheet, [1.0, -2.0, 3.0]);
        assert_eq!(a.solve(a * x).0.map(value), [1.0, -2.0, 3.0]);
    }
}
