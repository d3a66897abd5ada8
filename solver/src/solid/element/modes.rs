//! Incompatible modes: where they are in equilibrium, and the tangent without them.
//!
//! An element with modes α has the energy min_α W(x, α) of its nodes x alone. Modes are sought from rest each time, so that no history of
//! theirs is to be kept. Where W has no minimum that is found so, there is no answer.

use nalgebra::{SMatrix, SVector, Vector3};

use super::{Points, Scratch, Step, Typed};
use crate::solid::SolidError;

/// Modes of an element with modes.
const MODES: usize = 3;
/// Their coordinates.
const OWN: usize = 3 * MODES;
/// The same, rounded up to a multiple of eight.
const WIDTH: usize = 16;
/// Steps of Newton's method that are enough for any stable state seen.
const MOST_STEPS: usize = 40;
/// Halvings of a step.
const MOST_HALVINGS: usize = 12;
/// What is left of the forces on modes, relative to those of strains of 1: rounding.
const ROUNDING: f64 = 1e-14;
/// What may be left where no step makes it less.
const STAGNATION: f64 = 1e-11;

type Forces = SVector<f64, OWN>;
type Stiffness = SMatrix<f64, OWN, OWN>;

pub(super) fn unstable(element: usize) -> SolidError {
    SolidError::UnstableModes { element, name: None }
}

/// Makes the points of dilatation exact for uniform strains and pressures on distorted elements: the volume is that of the points of
/// distortion, and so is the mean of each node's gradient.
pub(super) fn correct<const N: usize, const P: usize, const Q: usize>(
    dilatation: &mut Points<N, Q>,
    distortion: &Points<N, P>,
    volume: f64,
    nodes: usize,
) {
    let scale = volume / dilatation.weights.iter().sum::<f64>();
    dilatation.weights.iter_mut().for_each(|weight| *weight *= scale);
    for node in 0..nodes {
        let integral = |gradients: &[[Vector3<f64>; N]], weights: &[f64]| -> Vector3<f64> {
            gradients.iter().zip(weights).map(|(gradient, weight)| gradient[node] * *weight).sum()
        };
        let missing = integral(&distortion.gradients, &distortion.weights)
            - integral(&dilatation.gradients, &dilatation.weights);
        dilatation.gradients.iter_mut().for_each(|gradient| gradient[node] += missing / volume);
    }
}

/// Takes the modes, the coordinates from `first` on, out of a lower triangle: K_cc − K_ci K_ii⁻¹ K_ic. `None` if K_ii is not positive
/// definite.
pub(super) fn condense<const W: usize>(full: &mut [[f64; W]; W], first: usize) -> Option<()> {
    let own = Stiffness::from_fn(|i, j| full[first + i.max(j)][first + i.min(j)]);
    let factor = own.cholesky()?.unpack();
    let mut shares = vec![Forces::zeros(); first];
    for (column, share) in shares.iter_mut().enumerate() {
        *share = Forces::from_fn(|i, _| full[first + i][column]);
        factor.solve_lower_triangular_mut(share);
    }
    for i in 0..first {
        for j in 0..=i {
            full[i][j] -= shares[i].dot(&shares[j]);
        }
    }
    Some(())
}

impl<const N: usize, const P: usize, const Q: usize, const W: usize, const I: usize> Typed<N, P, Q, W, I> {
    /// `corners` with the modes in equilibrium, by Newton's method from rest.
    pub(super) fn with_modes(
        &self,
        step: Step<'_>,
        mut corners: [Vector3<f64>; N],
        scratch: &mut Scratch,
    ) -> Result<[Vector3<f64>; N], SolidError> {
        let unit = step.law.longitudinal_modulus() * self.mode_scale();
        let (mut forces, mut stiffness) = self.on_modes(step, &corners, scratch)?;
        for _ in 0..MOST_STEPS {
            let size = forces.norm();
            if size == 0.0 {
                return Ok(corners);
            }
            let factor = stiffness.cholesky().ok_or_else(|| unstable(step.index))?;
            let full = -factor.solve(&forces);
            if size <= ROUNDING * unit {
                // What is left goes into the nodes' forces: the last step takes it.
                return Ok(moved(&corners, &full));
            }
            let found = (0..MOST_HALVINGS).find_map(|halvings| {
                let moved = moved(&corners, &(full * 0.5_f64.powi(halvings as i32)));
                let (forces, stiffness) = self.on_modes(step, &moved, scratch).ok()?;
                (forces.norm() < size).then_some((moved, forces, stiffness))
            });
            match found {
                Some(found) => (corners, forces, stiffness) = found,
                None if size <= STAGNATION * unit => return Ok(corners),
                None => break,
            }
        }
        Err(unstable(step.index))
    }

    /// The integral of the largest gradient of a mode over the element, area.
    fn mode_scale(&self) -> f64 {
        let modes = self.distortion.gradients.iter().flat_map(|gradients| &gradients[N - I..]);
        self.volume * modes.map(|gradient| gradient.norm_squared()).fold(0.0, f64::max).sqrt()
    }

    /// Forces on the modes and their derivative by them.
    fn on_modes(
        &self,
        step: Step<'_>,
        corners: &[Vector3<f64>; N],
        scratch: &mut Scratch,
    ) -> Result<(Forces, Stiffness), SolidError> {
        let modes_of = |gradients: &[Vector3<f64>; N]| -> [Vector3<f64>; MODES] {
            std::array::from_fn(|k| gradients[N - I + k])
        };
        let mut total = [Vector3::zeros(); MODES];
        scratch.clear::<MODES, P, Q, WIDTH>();
        for point in 0..P {
            let (deformed, gradients) = self.distorted(step, point, corners)?;
            let (gradients, weight) = (modes_of(&gradients), self.distortion.weights[point]);
            let stress = deformed.answer.kirchhoff() * weight;
            let forces = gradients.map(|gradient| stress * gradient);
            (0..MODES).for_each(|k| total[k] += forces[k]);
            scratch.add_distortion::<MODES, WIDTH>(point, &deformed, &gradients, &forces, weight);
        }
        for point in 0..Q {
            let moved = self.dilatation.deform(step.index, point, corners)?;
            let (gradients, weight) = (modes_of(&moved.gradients), self.dilatation.weights[point]);
            let volumetric = step.law.volumetric(moved.jacobian);
            let load = weight * moved.jacobian * volumetric.pressure;
            (0..MODES).for_each(|k| total[k] += gradients[k] * load);
            scratch.add_area(&gradients, load);
            let stiffness = weight * moved.jacobian.powi(2) * volumetric.stiffness;
            scratch.add_dilatation::<MODES, WIDTH>(6 * P + point, &gradients, stiffness);
        }
        let mut full = scratch.product::<WIDTH>();
        scratch.scatter::<MODES, WIDTH>(1.0, &mut full);
        let forces = Forces::from_fn(|i, _| total[i / 3][i % 3]);
        Ok((forces, Stiffness::from_fn(|i, j| full[i.max(j)][i.min(j)])))
    }
}

/// The nodes where they are, the modes moved.
fn moved<const N: usize>(corners: &[Vector3<f64>; N], by: &Forces) -> [Vector3<f64>; N] {
    let mut moved = *corners;
    for (mode, position) in moved[N - MODES..].iter_mut().enumerate() {
        *position += by.fixed_view::<3, 1>(3 * mode, 0);
    }
    moved
}
