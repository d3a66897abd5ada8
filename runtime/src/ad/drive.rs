//! Which dual numbers are pushed through the model.
//!
//! First derivatives: one pass per chunk of coordinates over dual numbers with a vector part. Second
//! derivatives: one pass per pair of chunks over hyper-dual numbers, whose mixed part is that block of the
//! Hessian. A chunk of six coordinates is two nodes: numbers that do not depend on them carry no derivative
//! parts at all, which keeps the sum over the nodes cheap.

use nalgebra::{Const, U1};
use num_dual::{DualSVec64, HyperDualSVec64};

use super::linear::Scalar;
use super::{coordinates_of, finite};
use crate::{Element, ElementError, Mode, SymmetricMatrix};

/// Coordinates per pass for first derivatives.
const GRADIENT_CHUNK: usize = 12;
/// Coordinates per direction and pass for second derivatives.
const HESSIAN_CHUNK: usize = 6;

/// Outputs of the model as functions of the coordinates of slave and masters, over any kind of number.
pub(super) trait Quantity {
    /// The outputs in units of the support radius.
    fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError>;
}

/// Outputs with derivatives with respect to coordinates over R, all finite.
#[derive(Debug)]
pub(super) struct Derivatives {
    pub(super) values: Vec<f64>,
    /// One vector per output; none in value mode.
    pub(super) gradients: Vec<Vec<f64>>,
    /// One matrix per output; none below Hessian mode.
    pub(super) hessians: Vec<SymmetricMatrix>,
}

impl Derivatives {
    /// Values without derivatives.
    pub(super) const fn of_values(values: Vec<f64>) -> Self {
        Self { values, gradients: Vec::new(), hessians: Vec::new() }
    }

    /// Turns output `k`, whose unit is length^`power`, from lengths over `radius` into lengths; the coordinates
    /// of its derivatives likewise.
    pub(super) fn scale(&mut self, k: usize, radius: f64, power: i32) -> Result<(), ElementError> {
        self.values[k] *= radius.powi(power);
        finite("value", [self.values[k]])?;
        if let Some(gradient) = self.gradients.get_mut(k) {
            let factor = radius.powi(power - 1);
            gradient.iter_mut().for_each(|x| *x *= factor);
            finite("first derivative", gradient.iter().copied())?;
        }
        if let Some(hessian) = self.hessians.get_mut(k) {
            let factor = radius.powi(power - 2);
            hessian.packed_mut().iter_mut().for_each(|x| *x *= factor);
            finite("second derivative", hessian.packed().iter().copied())?;
        }
        Ok(())
    }
}

/// Values and derivatives of a quantity. The coordinates are seeded with R, so that the derivatives are those
/// with respect to coordinates over R.
pub(super) fn differentiate<Q: Quantity>(
    quantity: &Q,
    element: &Element<'_>,
    mode: Mode,
) -> Result<Derivatives, ElementError> {
    differentiate_at(quantity, &coordinates_of(element), element.support_radius, mode)
}

/// Values and derivatives of a quantity at the given coordinates, which are seeded with `seed`.
pub(super) fn differentiate_at<Q: Quantity>(
    quantity: &Q,
    coordinates: &[[f64; 3]],
    seed: f64,
    mode: Mode,
) -> Result<Derivatives, ElementError> {
    let mut derivatives = Derivatives::of_values(quantity.evaluate(coordinates)?);
    match mode {
        Mode::Value => {}
        Mode::Gradient => fill_gradients(quantity, coordinates, seed, &mut derivatives)?,
        Mode::Hessian => {
            fill_gradients(quantity, coordinates, seed, &mut derivatives)?;
            fill_hessians(quantity, coordinates, seed, &mut derivatives)?;
        }
    }
    Ok(derivatives)
}

fn fill_gradients<Q: Quantity>(
    quantity: &Q,
    coordinates: &[[f64; 3]],
    seed: f64,
    derivatives: &mut Derivatives,
) -> Result<(), ElementError> {
    let freedoms = 3 * coordinates.len();
    derivatives.gradients = vec![vec![0.0; freedoms]; derivatives.values.len()];
    for start in (0..freedoms).step_by(GRADIENT_CHUNK) {
        let seeded = map_coordinates(coordinates, |x, freedom| {
            let mut dual = DualSVec64::<GRADIENT_CHUNK>::from(x);
            if let Some(index) = index_in_chunk(freedom, start, GRADIENT_CHUNK) {
                dual = dual.derivative(index);
                dual.eps *= seed;
            }
            dual
        });
        let outputs = quantity.evaluate(&seeded)?;
        for (gradient, output) in derivatives.gradients.iter_mut().zip(outputs) {
            let part = output.eps.unwrap_generic(Const::<GRADIENT_CHUNK>, U1);
            for (entry, derivative) in gradient[start..].iter_mut().zip(part.iter()) {
                *entry = *derivative;
            }
        }
    }
    Ok(())
}

fn fill_hessians<Q: Quantity>(
    quantity: &Q,
    coordinates: &[[f64; 3]],
    seed: f64,
    derivatives: &mut Derivatives,
) -> Result<(), ElementError> {
    let freedoms = 3 * coordinates.len();
    derivatives.hessians = vec![SymmetricMatrix::zeros(freedoms); derivatives.values.len()];
    for row_start in (0..freedoms).step_by(HESSIAN_CHUNK) {
        for column_start in (0..=row_start).step_by(HESSIAN_CHUNK) {
            let seeded = map_coordinates(coordinates, |x, freedom| {
                let mut dual = HyperDualSVec64::<HESSIAN_CHUNK, HESSIAN_CHUNK>::from(x);
                if let Some(index) = index_in_chunk(freedom, row_start, HESSIAN_CHUNK) {
                    dual = dual.derivative1(index);
                    dual.eps1 *= seed;
                }
                if let Some(index) = index_in_chunk(freedom, column_start, HESSIAN_CHUNK) {
                    dual = dual.derivative2(index);
                    dual.eps2 *= seed;
                }
                dual
            });
            let outputs = quantity.evaluate(&seeded)?;
            for (hessian, output) in derivatives.hessians.iter_mut().zip(outputs) {
                let size = Const::<HESSIAN_CHUNK>;
                let block = output.eps1eps2.unwrap_generic(size, size);
                let packed = hessian.packed_mut();
                for row in row_start..freedoms.min(row_start + HESSIAN_CHUNK) {
                    for column in column_start..=row.min(column_start + HESSIAN_CHUNK - 1) {
                        packed[row * (row + 1) / 2 + column] =
                            block[(row - row_start, column - column_start)];
                    }
                }
            }
        }
    }
    Ok(())
}

/// Each coordinate and its number among the degrees of freedom, turned into a dual number.
fn map_coordinates<D>(coordinates: &[[f64; 3]], dual: impl Fn(f64, usize) -> D) -> Vec<[D; 3]> {
    let point = |(node, x): (usize, &[f64; 3])| std::array::from_fn(|k| dual(x[k], 3 * node + k));
    coordinates.iter().enumerate().map(point).collect()
}

fn index_in_chunk(freedom: usize, start: usize, size: usize) -> Option<usize> {
    freedom.checked_sub(start).filter(|index| *index < size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Basis, Frame};

    /// x_0² x_j + Σ sin x over all coordinates, a function with every kind of entry in its Hessian.
    struct Sample;

    impl Quantity for Sample {
        fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError> {
            let flat = coordinates.as_flattened();
            let sum: D = flat.iter().map(|x| flat[0] * flat[0] * *x + x.sin()).sum();
            Ok(vec![sum, sum * 2.0])
        }
    }

    #[test]
    fn chunks_cover_every_entry() {
        for n in [3usize, 4, 5, 6, 7, 8, 13] {
            let masters: Vec<_> = (0..n).map(|i| std::array::from_fn(|k| 0.1 * (3 * i + k) as f64)).collect();
            let frame =
                Frame::given([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], None).unwrap();
            let element = Element::new([0.7, -0.3, 0.2], &masters, frame, 2.0).with_basis(Basis::Linear);
            let mut derivatives = differentiate(&Sample, &element, Mode::Hessian).unwrap();
            derivatives.scale(1, 2.0, 0).unwrap();
            let coordinates = coordinates_of(&element);
            let x = coordinates.as_flattened();
            let sum: f64 = x.iter().sum();
            for i in 0..x.len() {
                let expected = x[0] * x[0] + x[i].cos() + if i == 0 { 2.0 * x[0] * sum } else { 0.0 };
                assert!((derivatives.gradients[1][i] - 2.0 * expected).abs() < 1e-13);
                for j in 0..x.len() {
                    let mut expected = if i == j { -x[i].sin() } else { 0.0 };
                    expected += 2.0 * x[0] * (f64::from(i == 0) + f64::from(j == 0));
                    expected += if i == 0 && j == 0 { 2.0 * sum } else { 0.0 };
                    let found = derivatives.hessians[1].get(i, j);
                    assert!(
                        (found - 2.0 * expected).abs() < 1e-13,
                        "n = {n}, ({i}, {j}): {found} {expected}"
                    );
                }
            }
        }
    }
}
