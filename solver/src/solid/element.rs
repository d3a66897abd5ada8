//! One hexahedron.
//!
//! Loops instead of `array::map`, which is not always inlined.

use nalgebra::{Matrix3, Vector3};

use super::product::{AtPoints, Strains, product};
use super::{COORDINATES, POINTS, SolidError, TRIANGLE, shape};
use crate::material::{Hencky, Isochoric, PointState};

/// What does not change: nodes and the geometry at the start.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub nodes: [usize; 8],
    /// Gradients of the shape functions at the integration points by reference positions, 1 per length.
    gradients: [[Vector3<f64>; 8]; POINTS],
    /// Reference volume that belongs to each point.
    pub weights: [f64; POINTS],
    /// V, their sum.
    volume: f64,
}

/// An integration point of a deformed element.
pub(super) struct Point {
    /// det F > 0.
    pub jacobian: f64,
    /// Gradients of the shape functions by current positions.
    gradients: [Vector3<f64>; 8],
    pub answer: Isochoric,
}

/// Memory of a tangent under construction.
pub(super) struct Scratch {
    /// B of each point.
    strains: AtPoints,
    /// C B times the point's volume.
    stresses: AtPoints,
}

impl Default for Scratch {
    fn default() -> Self {
        Self { strains: [[[0.0; COORDINATES]; 6]; POINTS], stresses: [[[0.0; COORDINATES]; 6]; POINTS] }
    }
}

/// The parts of the tangent that are not Bᵀ C B, by pairs of nodes a ≥ b, at a(a+1)/2 + b.
struct Pairs {
    /// Σ w ∇Nₐ·τ ∇N_b, on the diagonal of the pair's block.
    geometric: [f64; 36],
    /// Σ w J ∇Nₐ × ∇N_b, the axial vector of the pair's block of ∂²v/∂x∂x.
    area: [Vector3<f64>; 36],
}

impl Element {
    pub fn new(positions: &[[f64; 3]], nodes: [usize; 8], index: usize) -> Result<Self, SolidError> {
        if let Some(&node) = nodes.iter().find(|&&node| node >= positions.len()) {
            return Err(SolidError::NodeOutOfRange {
                element: index,
                name: None,
                node,
                count: positions.len(),
            });
        }
        let corners = relative(positions, &nodes);
        let mut gradients = [[Vector3::zeros(); 8]; POINTS];
        let mut weights = [0.0; POINTS];
        for point in 0..POINTS {
            let natural = shape::gradients(point).map(Vector3::from);
            let tangents = gradient(&corners, &natural);
            let jacobian = tangents.determinant();
            let bad = || SolidError::BadElement { element: index, name: None, point, jacobian };
            if !(jacobian > 0.0 && jacobian < f64::INFINITY) {
                return Err(bad());
            }
            let inverse = tangents.try_inverse().ok_or_else(bad)?;
            gradients[point] = natural.map(|by_natural| inverse.tr_mul(&by_natural));
            if !gradients[point].iter().all(|gradient| gradient.norm_squared().is_finite()) {
                return Err(bad());
            }
            weights[point] = jacobian;
        }
        Ok(Self { nodes, gradients, weights, volume: weights.iter().sum() })
    }

    /// Forces, states and, if asked for, the tangent's lower triangle.
    #[expect(clippy::too_many_arguments, reason = "three results in slots of their own, and their inputs")]
    pub fn evaluate(
        &self,
        index: usize,
        law: &Hencky,
        positions: &[[f64; 3]],
        committed: &[PointState],
        force: &mut [f64; COORDINATES],
        states: &mut [PointState],
        tangent: Option<&mut [f64; TRIANGLE]>,
        scratch: &mut Scratch,
    ) -> Result<(), SolidError> {
        let corners = relative(positions, &self.nodes);
        let mut isochoric = [Vector3::zeros(); 8];
        // ∂v/∂x
        let mut by_volume = [Vector3::zeros(); 8];
        let mut current_volume = 0.0;
        let mut pairs = Pairs { geometric: [0.0; 36], area: [Vector3::zeros(); 36] };
        for point in 0..POINTS {
            let deformed = self.deform(index, point, law, &corners, &committed[point])?;
            let weight = self.weights[point];
            let volume = weight * deformed.jacobian;
            let stress = deformed.answer.kirchhoff() * weight;
            let mut forces = [Vector3::zeros(); 8];
            for a in 0..8 {
                forces[a] = stress * deformed.gradients[a];
                isochoric[a] += forces[a];
                by_volume[a] += deformed.gradients[a] * volume;
            }
            current_volume += volume;
            states[point] = deformed.answer.state;
            if tangent.is_some() {
                pairs.add(&deformed.gradients, &forces, volume);
                let strains = &mut scratch.strains[point];
                deformed.strains(strains);
                apply(&deformed.answer, weight, strains, &mut scratch.stresses[point]);
            }
        }

        let volumetric = law.volumetric(current_volume / self.volume);
        for a in 0..8 {
            let total = isochoric[a] + by_volume[a] * volumetric.pressure;
            force[3 * a..3 * a + 3].copy_from_slice(total.as_slice());
        }
        if let Some(tangent) = tangent {
            let mut full = product(&scratch.strains, &scratch.stresses);
            pairs.scatter(volumetric.pressure, &mut full);
            let stiffness = volumetric.stiffness / self.volume;
            let mut entries = tangent.iter_mut();
            for i in 0..COORDINATES {
                let factor = stiffness * by_volume[i / 3][i % 3];
                for (j, entry) in entries.by_ref().take(i + 1).enumerate() {
                    *entry = full[i][j] + factor * by_volume[j / 3][j % 3];
                }
            }
        }
        Ok(())
    }

    pub fn stored_energy(
        &self,
        index: usize,
        law: &Hencky,
        positions: &[[f64; 3]],
        committed: &[PointState],
    ) -> Result<f64, SolidError> {
        let mut isochoric = 0.0;
        let ratio = self.for_each_point(index, law, positions, committed, |point, deformed| {
            isochoric += self.weights[point] * deformed.answer.energy;
        })?;
        Ok(isochoric + self.volume * law.volumetric(ratio).energy)
    }

    /// Calls `visit` at each point and returns θ = v/V.
    pub fn for_each_point(
        &self,
        index: usize,
        law: &Hencky,
        positions: &[[f64; 3]],
        committed: &[PointState],
        mut visit: impl FnMut(usize, &Point),
    ) -> Result<f64, SolidError> {
        let corners = relative(positions, &self.nodes);
        let mut current_volume = 0.0;
        for point in 0..POINTS {
            let deformed = self.deform(index, point, law, &corners, &committed[point])?;
            current_volume += self.weights[point] * deformed.jacobian;
            visit(point, &deformed);
        }
        Ok(current_volume / self.volume)
    }

    #[inline]
    fn deform(
        &self,
        element: usize,
        point: usize,
        law: &Hencky,
        corners: &[Vector3<f64>; 8],
        committed: &PointState,
    ) -> Result<Point, SolidError> {
        let deformation_gradient = gradient(corners, &self.gradients[point]);
        let jacobian = deformation_gradient.determinant();
        let inverted = || SolidError::Inverted { element, name: None, point, jacobian };
        if !(jacobian > 0.0 && jacobian < f64::INFINITY) {
            return Err(inverted());
        }
        let inverse = deformation_gradient.try_inverse().ok_or_else(inverted)?;
        let answer = law
            .isochoric(&deformation_gradient, committed)
            .map_err(|source| SolidError::Unresolved { element, name: None, point, source })?;
        let mut gradients = [Vector3::zeros(); 8];
        for a in 0..8 {
            gradients[a] = inverse.tr_mul(&self.gradients[point][a]);
        }
        Ok(Point { jacobian, gradients, answer })
    }
}

impl Point {
    /// B: the strains of a unit displacement of each coordinate.
    #[inline]
    fn strains(&self, strains: &mut Strains) {
        let axes = &self.answer.axes;
        for a in 0..8 {
            let along = axes.tr_mul(&self.gradients[a]);
            for i in 0..3 {
                let column = 3 * a + i;
                let axis = [axes[(i, 0)], axes[(i, 1)], axes[(i, 2)]];
                for k in 0..3 {
                    let (l, m) = ((k + 1) % 3, (k + 2) % 3);
                    strains[k][column] = along[k] * axis[k];
                    strains[3 + k][column] = along[l] * axis[m] + along[m] * axis[l];
                }
            }
        }
    }
}

/// C B, times the point's volume.
#[inline]
fn apply(answer: &Isochoric, weight: f64, strains: &Strains, stresses: &mut Strains) {
    let normal = answer.normal * weight;
    let shear = answer.shear * weight;
    for k in 0..3 {
        for column in 0..COORDINATES {
            stresses[k][column] = normal[(k, 0)] * strains[0][column]
                + normal[(k, 1)] * strains[1][column]
                + normal[(k, 2)] * strains[2][column];
            stresses[3 + k][column] = shear[k] * strains[3 + k][column];
        }
    }
}

impl Pairs {
    /// `forces` are the point's, w τ ∇N.
    #[inline]
    fn add(&mut self, gradients: &[Vector3<f64>; 8], forces: &[Vector3<f64>; 8], volume: f64) {
        let mut pair = 0;
        for a in 0..8 {
            let area = gradients[a] * volume;
            for b in 0..=a {
                self.geometric[pair] += forces[a].dot(&gradients[b]);
                self.area[pair] += area.cross(&gradients[b]);
                pair += 1;
            }
        }
    }

    fn scatter(&self, pressure: f64, full: &mut [[f64; COORDINATES]; COORDINATES]) {
        let mut pair = 0;
        for a in 0..8 {
            for b in 0..=a {
                let area = self.area[pair] * pressure;
                for k in 0..3 {
                    let (l, m) = ((k + 1) % 3, (k + 2) % 3);
                    full[3 * a + k][3 * b + k] += self.geometric[pair];
                    full[3 * a + l][3 * b + m] += area[k];
                    full[3 * a + m][3 * b + l] -= area[k];
                }
                pair += 1;
            }
        }
    }
}

/// Positions of the nodes relative to the first: gradients do not see where the element is, and digits are kept far from
/// the origin.
#[inline]
fn relative(positions: &[[f64; 3]], nodes: &[usize; 8]) -> [Vector3<f64>; 8] {
    let origin = Vector3::from(positions[nodes[0]]);
    let mut corners = [Vector3::zeros(); 8];
    for a in 0..8 {
        corners[a] = Vector3::from(positions[nodes[a]]) - origin;
    }
    corners
}

/// Σ xₐ ⊗ ∇Nₐ.
#[inline]
fn gradient(corners: &[Vector3<f64>; 8], gradients: &[Vector3<f64>; 8]) -> Matrix3<f64> {
    let mut sum = Matrix3::zeros();
    for a in 0..8 {
        for j in 0..3 {
            for i in 0..3 {
                sum[(i, j)] += corners[a][i] * gradients[a][j];
            }
        }
    }
    sum
}
