//! Vectors of three components.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, Sub};

use crate::Point;

/// A point or a vector in space, with the operations that a [`Point`] lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Vector3([f64; 3]);

impl Vector3 {
    #[cfg(test)]
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self([x, y, z])
    }

    pub const fn zeros() -> Self {
        Self([0.0; 3])
    }

    /// The unit vector along an axis.
    pub fn axis(axis: usize) -> Self {
        let mut components = [0.0; 3];
        components[axis] = 1.0;
        Self(components)
    }

    pub fn dot(&self, other: &Self) -> f64 {
        let (Self([a, b, c]), Self([x, y, z])) = (self, other);
        a * x + b * y + c * z
    }

    pub fn cross(&self, other: &Self) -> Self {
        let (Self([a, b, c]), Self([x, y, z])) = (self, other);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    pub fn norm_squared(&self) -> f64 {
        self.dot(self)
    }

    pub fn norm(&self) -> f64 {
        self.norm_squared().sqrt()
    }

    pub fn normalize(self) -> Self {
        self / self.norm()
    }

    /// The unit vector in this direction; `None` for the zero vector. A NaN comes through.
    pub fn try_normalize(self) -> Option<Self> {
        let norm = self.norm();
        (norm != 0.0).then(|| self / norm)
    }

    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|x| x.is_finite())
    }

    /// Largest magnitude of a component.
    pub fn largest(&self) -> f64 {
        self.0.iter().fold(0.0, |largest, x| x.abs().max(largest))
    }

    /// The axis along which the magnitude is smallest; of several the first.
    pub fn smallest_axis(&self) -> usize {
        let [x, y, z] = self.0.map(f64::abs);
        let (axis, least) = if y < x { (1, y) } else { (0, x) };
        if z < least { 2 } else { axis }
    }

    /// The smaller of each component.
    pub fn lower(&self, other: &Self) -> Self {
        self.by_component(other, f64::min)
    }

    /// The larger of each component.
    pub fn upper(&self, other: &Self) -> Self {
        self.by_component(other, f64::max)
    }

    fn by_component(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let (Self([a, b, c]), Self([x, y, z])) = (self, other);
        Self([f(*a, *x), f(*b, *y), f(*c, *z)])
    }
}

impl From<Point> for Vector3 {
    fn from(point: Point) -> Self {
        Self(point)
    }
}

impl From<Vector3> for Point {
    fn from(vector: Vector3) -> Self {
        vector.0
    }
}

impl Index<usize> for Vector3 {
    type Output = f64;

    fn index(&self, axis: usize) -> &f64 {
        &self.0[axis]
    }
}

impl IndexMut<usize> for Vector3 {
    fn index_mut(&mut self, axis: usize) -> &mut f64 {
        &mut self.0[axis]
    }
}

/// Square of the distance of two points.
pub(crate) fn squared_distance(x: Point, y: Point) -> f64 {
    let [a, b, c] = [x[0] - y[0], x[1] - y[1], x[2] - y[2]];
    a * a + b * b + c * c
}

/// The lowest and the highest coordinates of points; of none they are infinite, and the other way round.
pub(crate) fn bounds(points: impl Iterator<Item = Point>) -> [Point; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY].map(|x| Vector3([x; 3]));
    let joined = |[low, high]: [Vector3; 2], x: Vector3| [low.lower(&x), high.upper(&x)];
    points.map(Vector3::from).fold(none, joined).map(Point::from)
}

/// An operator by components, for vectors and references to them.
macro_rules! by_component {
    ($operator:ident, $method:ident, $f:expr) => {
        by_component!($operator, $method, $f, Vector3, Vector3);
        by_component!($operator, $method, $f, Vector3, &Vector3);
        by_component!($operator, $method, $f, &Vector3, Vector3);
        by_component!($operator, $method, $f, &Vector3, &Vector3);
    };
    ($operator:ident, $method:ident, $f:expr, $left:ty, $right:ty) => {
        impl $operator<$right> for $left {
            type Output = Vector3;

            fn $method(self, other: $right) -> Vector3 {
                Vector3::by_component(&self, &other, $f)
            }
        }
    };
}

by_component!(Add, add, |a, x| a + x);
by_component!(Sub, sub, |a, x| a - x);

impl Mul<f64> for Vector3 {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}

impl Div<f64> for Vector3 {
    type Output = Self;

    fn div(self, divisor: f64) -> Self {
        Self(self.0.map(|x| x / divisor))
    }
}

impl AddAssign for Vector3 {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sum for Vector3 {
    fn sum<I: Iterator<Item = Self>>(vectors: I) -> Self {
        vectors.fold(Self::zeros(), |sum, x| sum + x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_space() {
        let (x, y) = (Vector3::new(1.0, 2.0, 3.0), Vector3::new(-2.0, 0.5, 4.0));
        assert_eq!(x.dot(&y), 11.0);
        assert_eq!(x.cross(&y), Vector3::new(6.5, -10.0, 4.5));
        assert_eq!(Vector3::axis(0).cross(&Vector3::axis(1)), Vector3::axis(2));
        assert_eq!(Vector3::new(2.0, -3.0, 6.0).norm(), 7.0);
        assert_eq!(Vector3::new(0.0, 0.0, -4.0).normalize(), Vector3::new(0.0, 0.0, -1.0));
    }

    #[test]
    fn the_zero_vector_has_no_direction() {
        assert_eq!(Vector3::zeros().try_normalize(), None);
        assert!(!Vector3::new(f64::NAN, 1.0, 0.0).try_normalize().unwrap().is_finite());
        assert_eq!(Vector3::new(0.0, -2.0, 0.0).try_normalize(), Some(Vector3::new(0.0, -1.0, 0.0)));
    }

    #[test]
    fn extremes_are_by_magnitude_and_by_component() {
        let x = Vector3::new(-5.0, 3.0, -3.0);
        assert_eq!((x.largest(), x.smallest_axis()), (5.0, 1));
        assert_eq!(Vector3::new(0.0, 0.0, 0.0).smallest_axis(), 0);
        assert_eq!(Vector3::new(1.0, -2.0, 0.5).smallest_axis(), 2);
        let y = Vector3::new(1.0, 4.0, -7.0);
        assert_eq!((x.lower(&y), x.upper(&y)), (Vector3::new(-5.0, 3.0, -7.0), Vector3::new(1.0, 4.0, -3.0)));
    }
}
