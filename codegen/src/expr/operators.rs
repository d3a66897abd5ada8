//! `+ − × ÷` among expressions, numbers, vectors and matrices.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::{Expr, Matrix, Term, Vector};
use crate::graph::Graph;

macro_rules! arithmetic {
    ($($trait:ident $method:ident $of_graph:path),*) => {$(
        impl<'g, T: Term<'g>> $trait<T> for Expr<'g> {
            type Output = Self;
            fn $method(self, other: T) -> Self {
                self.with(other, $of_graph)
            }
        }

        impl<'g> $trait<Expr<'g>> for f64 {
            type Output = Expr<'g>;
            fn $method(self, other: Expr<'g>) -> Expr<'g> {
                self.on(other.sheet).with(other, $of_graph)
            }
        }
    )*};
}
arithmetic!(Add add Graph::add, Sub sub Graph::sub, Mul mul Graph::mul, Div div Graph::div);

impl Neg for Expr<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(Graph::neg)
    }
}

impl<'g, T: Term<'g>> AddAssign<T> for Expr<'g> {
    fn add_assign(&mut self, other: T) {
        *self = *self + other;
    }
}

impl<'g, T: Term<'g>> SubAssign<T> for Expr<'g> {
    fn sub_assign(&mut self, other: T) {
        *self = *self - other;
    }
}

/// Entry by entry, and with a factor on either side.
macro_rules! linear {
    ($type:ident, $($size:ident),*) => {
        impl<'g, $(const $size: usize),*> Add for $type<'g, $($size),*> {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                self.zip(other, |x, y| x + y)
            }
        }

        impl<'g, $(const $size: usize),*> AddAssign for $type<'g, $($size),*> {
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl<'g, $(const $size: usize),*> Sub for $type<'g, $($size),*> {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                self.zip(other, |x, y| x - y)
            }
        }

        impl<'g, $(const $size: usize),*> Neg for $type<'g, $($size),*> {
            type Output = Self;
            fn neg(self) -> Self {
                self.map(|x| -x)
            }
        }

        impl<'g, T: Term<'g>, $(const $size: usize),*> Mul<T> for $type<'g, $($size),*> {
            type Output = Self;
            fn mul(self, factor: T) -> Self {
                self.map(|x| x * factor)
            }
        }

        impl<'g, $(const $size: usize),*> Mul<$type<'g, $($size),*>> for Expr<'g> {
            type Output = $type<'g, $($size),*>;
            fn mul(self, other: $type<'g, $($size),*>) -> $type<'g, $($size),*> {
                other.map(|x| self * x)
            }
        }

        impl<'g, $(const $size: usize),*> Mul<$type<'g, $($size),*>> for f64 {
            type Output = $type<'g, $($size),*>;
            fn mul(self, other: $type<'g, $($size),*>) -> $type<'g, $($size),*> {
                other.map(|x| self * x)
            }
        }

        impl<'g, T: Term<'g>, $(const $size: usize),*> Div<T> for $type<'g, $($size),*> {
            type Output = Self;
            fn div(self, divisor: T) -> Self {
                self.map(|x| x / divisor)
            }
        }
    };
}
linear!(Vector, N);
linear!(Matrix, R, C);

/// A v
impl<'g, const R: usize, const C: usize> Mul<Vector<'g, C>> for Matrix<'g, R, C> {
    type Output = Vector<'g, R>;
    fn mul(self, vector: Vector<'g, C>) -> Vector<'g, R> {
        Vector::from_fn(|row| self.row(row).dot(vector))
    }
}

/// A B
impl<'g, const R: usize, const K: usize, const C: usize> Mul<Matrix<'g, K, C>> for Matrix<'g, R, K> {
    type Output = Matrix<'g, R, C>;
    fn mul(self, other: Matrix<'g, K, C>) -> Matrix<'g, R, C> {
        Matrix::from_fn(|row, column| self.row(row).dot(other.column(column)))
    }
}
