//! The slave's place in the master's first configuration on dual numbers, for domains of influence that stay what they are there.
//!
//! Ξ is the affine fit of the nodes' first positions by their positions in the average plane, taken at the slave; its weights ω
//! are those of the nodes seen from Ξ (`docs/equations.md`, \[T18\]). On reals Ξ is known: offsets are given from it. Its
//! derivatives come from Newton steps over dual numbers with the real Jacobian, as those of the plane do.

use num_dual::DualSVec64;

use super::RadialWeight;
use super::linear::Scalar;
use super::model::Model;
use super::plane::{AveragePlane, Turn};
use crate::{ElementError, MaterialNode};

/// The given place may be this far, over the domains of the nodes, from the root of its equations.
const PLACE_TOLERANCE: f64 = 1e-6;
/// As for the average plane; the weights of the plane follow, too, so each order takes two.
const PROPAGATION_STEPS: usize = 8;

/// How Ξ follows dual masters.
pub(super) struct Place {
    inverse_jacobian: [[f64; 3]; 3],
}

impl Place {
    /// # Errors
    /// [`ElementError::NotMaterialPlace`] if the given place is not a root.
    pub(super) fn find<W: RadialWeight>(
        model: &Model<'_, W>,
        plane: &AveragePlane,
        coordinates: &[[f64; 3]],
    ) -> Result<Self, ElementError> {
        let shift = std::array::from_fn(|k| DualSVec64::<3>::from(0.0).derivative(k));
        let constant: Vec<[DualSVec64<3>; 3]> = coordinates.iter().map(|x| x.map(DualSVec64::from)).collect();
        let (residual, _) = residual(model, plane, &constant, shift);
        let jacobian = residual.map(|r| {
            let eps = r.eps.unwrap_generic(nalgebra::Const::<3>, nalgebra::U1);
            [eps[0], eps[1], eps[2]]
        });
        let inverse = nalgebra::Matrix3::from(jacobian).transpose().try_inverse();
        let deviation = deviation(model, residual.map(|r| r.re));
        match inverse {
            Some(inverse) if deviation <= PLACE_TOLERANCE => {
                let inverse_jacobian = [0, 1, 2].map(|i| [0, 1, 2].map(|j| inverse[(i, j)]));
                Ok(Self { inverse_jacobian })
            }
            _ => Err(ElementError::NotMaterialPlace { deviation }),
        }
    }

    /// How far Ξ moves, and how the frame turns.
    pub(super) fn propagate<D: Scalar, W: RadialWeight>(
        &self,
        model: &Model<'_, W>,
        plane: &AveragePlane,
        coordinates: &[[D; 3]],
    ) -> ([D; 3], Turn<D>) {
        let mut shift = [D::zero(); 3];
        let (first, mut turn) = residual(model, plane, coordinates, shift);
        // The rounding error of the given place.
        let rest = first.map(|r| r.re());
        for _ in 0..PROPAGATION_STEPS {
            let (r, now) = residual(model, plane, coordinates, shift);
            turn = now;
            for (row, shift) in self.inverse_jacobian.iter().zip(&mut shift) {
                for (entry, (r, rest)) in row.iter().zip(r.iter().zip(rest)) {
                    *shift -= (*r - rest) * *entry;
                }
            }
        }
        (shift, turn)
    }
}

/// The affine fit of X_k − Ξ at the slave less the shift, and the frame it is made in.
fn residual<D: Scalar, W: RadialWeight>(
    model: &Model<'_, W>,
    plane: &AveragePlane,
    coordinates: &[[D; 3]],
    shift: [D; 3],
) -> ([D; 3], Turn<D>) {
    let weights: Vec<D> =
        model.material_squares(shift).into_iter().map(|square| model.fitting(square)).collect();
    let turn = plane.propagate(&coordinates[1..], &weights);
    // Σ ω, Σ ω a, Σ ω a a, Σ ω X, Σ ω X a
    let (mut total, mut first, mut second) = (D::zero(), [D::zero(); 2], [D::zero(); 3]);
    let (mut mean, mut products) = ([D::zero(); 3], [[D::zero(); 2]; 3]);
    for ((offset, &weight), node) in
        model.offsets(coordinates).into_iter().zip(&weights).zip(model.material_nodes())
    {
        let [a, b] = [0, 1].map(|k| turn[k][0] * offset[0] + turn[k][1] * offset[1] + turn[k][2] * offset[2]);
        total += weight;
        first[0] += weight * a;
        first[1] += weight * b;
        second[0] += weight * a * a;
        second[1] += weight * a * b;
        second[2] += weight * b * b;
        for k in 0..3 {
            mean[k] += weight * node.offset[k];
            products[k][0] += weight * a * node.offset[k];
            products[k][1] += weight * b * node.offset[k];
        }
    }
    // 1 + β·a is orthogonal to a and b.
    let determinant = second[0] * second[2] - second[1] * second[1];
    let beta = [
        -(second[2] * first[0] - second[1] * first[1]) / determinant,
        -(second[0] * first[1] - second[1] * first[0]) / determinant,
    ];
    let divisor = total + beta[0] * first[0] + beta[1] * first[1];
    let affine = |k: usize| (mean[k] + beta[0] * products[k][0] + beta[1] * products[k][1]) / divisor;
    (std::array::from_fn(|k| affine(k) - shift[k]), turn)
}

/// The largest r that a step in the place would be.
fn deviation<W: RadialWeight>(model: &Model<'_, W>, step: [f64; 3]) -> f64 {
    let distance = |node: &MaterialNode| MaterialNode { offset: step, ..*node }.distance();
    model.material_nodes().iter().map(distance).fold(0.0, |x, y| if y <= x { x } else { y })
}
