//! One element of any kind.
//!
//! Incompatible modes count as nodes of their own after the element's, where they are.
//!
//! Loops instead of `array::map`, which is not always inlined.

mod modes;
mod tangent;

use diffuse_contact_mesh::ElementKind;
use nalgebra::{Matrix3, Vector3};

use super::SolidError;
use super::reference::{self, Reference};
use crate::material::{Isochoric, Law, PointState};
use crate::model::Cell;

/// An element of a kind with `N` nodes, the last `I` of which are incompatible modes, `P` points of distortion and `Q` points of dilatation;
/// with `Q` = 0 its volume as a whole is what changes the pressure. `W`: 3 N, rounded up to a multiple of eight.
#[derive(Clone, Debug)]
pub(super) struct Typed<const N: usize, const P: usize, const Q: usize, const W: usize, const I: usize> {
    /// Those of modes are the first node: a mode at rest is where it is.
    nodes: [usize; N],
    distortion: Points<N, P>,
    dilatation: Points<N, Q>,
    /// V, reference volume.
    volume: f64,
}

/// Integration points of an element at the start.
#[derive(Clone, Debug)]
struct Points<const N: usize, const P: usize> {
    /// Gradients of the shape functions by reference positions, 1 per length.
    gradients: [[Vector3<f64>; N]; P],
    /// Reference volume that belongs to each point.
    weights: [f64; P],
}

/// What does not change: nodes and the geometry at the start.
///
/// Hexahedra of first order have one pressure. Where bending is not locked by shear as well, a pressure that does not follow it takes
/// stiffness away: a wedge in one layer was half as stiff as a beam. So all others have several.
#[derive(Clone, Debug)]
pub(super) enum Element {
    Tetrahedron4(Box<Typed<4, 1, 1, 16, 0>>),
    Tetrahedron10(Box<Typed<10, 4, 4, 32, 0>>),
    Wedge6(Box<Typed<6, 6, 6, 24, 0>>),
    Wedge15(Box<Typed<15, 9, 6, 48, 0>>),
    Hexahedron8(Box<Typed<8, 8, 0, 24, 0>>),
    /// With three incompatible modes.
    Incompatible(Box<Typed<11, 8, 6, 40, 3>>),
    Hexahedron20(Box<Typed<20, 27, 8, 64, 0>>),
    Hexahedron27(Box<Typed<27, 27, 8, 88, 0>>),
}

/// The same of an element of any kind.
macro_rules! each {
    ($element:expr, $typed:pat => $result:expr) => {
        match $element {
            Element::Tetrahedron4($typed) => $result,
            Element::Tetrahedron10($typed) => $result,
            Element::Wedge6($typed) => $result,
            Element::Wedge15($typed) => $result,
            Element::Hexahedron8($typed) => $result,
            Element::Incompatible($typed) => $result,
            Element::Hexahedron20($typed) => $result,
            Element::Hexahedron27($typed) => $result,
        }
    };
}

/// What an element is evaluated for.
#[derive(Clone, Copy)]
pub(super) struct Step<'a> {
    /// The element's place, for errors.
    pub index: usize,
    pub law: &'a Law,
    /// Positions of all nodes.
    pub positions: &'a [[f64; 3]],
    /// States of the element's points at the beginning of the step.
    pub committed: &'a [PointState],
}

/// Where the results of an element go.
pub(super) struct Results<'a> {
    /// Three for each node.
    pub forces: &'a mut [f64],
    /// One for each point.
    pub states: &'a mut [PointState],
    /// The lower triangle row by row; empty if it is not asked for.
    pub tangent: &'a mut [f64],
}

/// The deformation at a point.
struct Moved<const N: usize> {
    /// det F > 0.
    jacobian: f64,
    deformation_gradient: Matrix3<f64>,
    /// Of the shape functions by current positions.
    gradients: [Vector3<f64>; N],
}

/// A point of distortion of a deformed element.
pub(super) struct Deformed {
    /// det F > 0.
    pub jacobian: f64,
    pub answer: Isochoric,
}

/// Memory of a tangent under construction.
#[derive(Default)]
pub(super) struct Scratch {
    /// B: six rows for each point of distortion, then one for each of dilatation.
    strains: Vec<f64>,
    /// C B times the point's volume.
    stresses: Vec<f64>,
    /// By pairs of nodes a ≥ b, at a(a+1)/2 + b: Σ w ∇Nₐ·τ ∇N_b, on the diagonal of the pair's block.
    geometric: Vec<f64>,
    /// By pairs: Σ w J p ∇Nₐ × ∇N_b, the axial vector of the pair's block; with p = 1 for a pressure that is not known yet.
    area: Vec<Vector3<f64>>,
}

impl Element {
    /// An element on its nodes.
    pub fn new(cell: Cell<'_>, positions: &[[f64; 3]], index: usize) -> Result<Self, SolidError> {
        let Cell { kind, nodes, incompatible_modes } = cell;
        if let Some(&node) = nodes.iter().find(|&&node| node >= positions.len()) {
            return Err(SolidError::NodeOutOfRange {
                element: index,
                name: None,
                node,
                count: positions.len(),
            });
        }
        let reference = Reference::of(kind, incompatible_modes);
        macro_rules! typed {
            ($variant:ident) => {
                Self::$variant(Box::new(Typed::new(reference, positions, nodes, index)?))
            };
        }
        Ok(match kind {
            ElementKind::Tetrahedron4 => typed!(Tetrahedron4),
            ElementKind::Tetrahedron10 => typed!(Tetrahedron10),
            ElementKind::Wedge6 => typed!(Wedge6),
            ElementKind::Wedge15 => typed!(Wedge15),
            ElementKind::Hexahedron20 => typed!(Hexahedron20),
            ElementKind::Hexahedron27 => typed!(Hexahedron27),
            ElementKind::Hexahedron8 if incompatible_modes => typed!(Incompatible),
            ElementKind::Hexahedron8 => typed!(Hexahedron8),
            // Cells are solids, and so is what Reference::of knows.
            _ => unreachable!("{kind:?} is no solid"),
        })
    }

    pub fn kind(&self) -> ElementKind {
        match self {
            Self::Tetrahedron4(_) => ElementKind::Tetrahedron4,
            Self::Tetrahedron10(_) => ElementKind::Tetrahedron10,
            Self::Wedge6(_) => ElementKind::Wedge6,
            Self::Wedge15(_) => ElementKind::Wedge15,
            Self::Hexahedron8(_) | Self::Incompatible(_) => ElementKind::Hexahedron8,
            Self::Hexahedron20(_) => ElementKind::Hexahedron20,
            Self::Hexahedron27(_) => ElementKind::Hexahedron27,
        }
    }

    pub fn nodes(&self) -> &[usize] {
        each!(self, element => element.own_nodes())
    }

    /// What all elements like this one have in common.
    pub fn reference(&self) -> &'static Reference {
        Reference::of(self.kind(), matches!(self, Self::Incompatible(_)))
    }

    /// Reference volume.
    pub fn volume(&self) -> f64 {
        each!(self, element => element.volume)
    }

    /// Number of points of distortion.
    pub fn points(&self) -> usize {
        each!(self, element => element.distortion.weights.len())
    }

    /// Forces, states and, if there is room for it, the tangent's lower triangle.
    pub fn evaluate(
        &self,
        step: Step<'_>,
        results: Results<'_>,
        scratch: &mut Scratch,
    ) -> Result<(), SolidError> {
        each!(self, element => element.evaluate(step, results, scratch))
    }

    pub fn stored_energy(&self, step: Step<'_>, scratch: &mut Scratch) -> Result<f64, SolidError> {
        each!(self, element => element.stored_energy(step, scratch))
    }

    /// Calls `visit` with each point of distortion and the pressure there.
    pub fn for_each_point(
        &self,
        step: Step<'_>,
        visit: impl FnMut(&Deformed, f64),
    ) -> Result<(), SolidError> {
        each!(self, element => element.for_each_point(self.reference(), step, visit))
    }
}

impl<const N: usize, const P: usize> Points<N, P> {
    fn new(
        reference: &reference::Points,
        corners: &[Vector3<f64>; N],
        index: usize,
    ) -> Result<Self, SolidError> {
        // Modes take the map of the element's centre, so that their gradients have the mean 0 (Taylor, Beresford and Wilson 1976).
        let modes = N - reference.modes;
        let at_centre = Matrix3::from_fn(|i, j| {
            reference
                .centre
                .iter()
                .zip(corners)
                .map(|(gradient, corner)| corner[i] * gradient[j])
                .sum::<f64>()
        });
        let mut gradients = [[Vector3::zeros(); N]; P];
        let mut weights = [0.0; P];
        for point in 0..P {
            let natural: [Vector3<f64>; N] = std::array::from_fn(|a| reference.gradients[point][a]);
            let tangents = gradient(corners, &natural);
            let jacobian = tangents.determinant();
            let bad = || SolidError::BadElement { element: index, name: None, point, jacobian };
            if !(jacobian > 0.0 && jacobian < f64::INFINITY) {
                return Err(bad());
            }
            let inverse = tangents.try_inverse().ok_or_else(bad)?;
            gradients[point] = natural.map(|by_natural| inverse.tr_mul(&by_natural));
            for mode in modes..N {
                // The inverse times its determinant; a flat centre is one of no volume around.
                let cofactors: Matrix3<f64> =
                    at_centre.try_inverse().ok_or_else(bad)? * at_centre.determinant();
                gradients[point][mode] = cofactors.tr_mul(&natural[mode]) / jacobian;
            }
            if !gradients[point].iter().all(|gradient| gradient.norm_squared().is_finite()) {
                return Err(bad());
            }
            weights[point] = reference.weights[point] * jacobian;
        }
        Ok(Self { gradients, weights })
    }

    /// The deformation at a point.
    #[inline]
    fn deform(
        &self,
        index: usize,
        point: usize,
        corners: &[Vector3<f64>; N],
    ) -> Result<Moved<N>, SolidError> {
        let deformation_gradient = gradient(corners, &self.gradients[point]);
        let jacobian = deformation_gradient.determinant();
        let inverted = || SolidError::Inverted { element: index, name: None, point, jacobian };
        if !(jacobian > 0.0 && jacobian < f64::INFINITY) {
            return Err(inverted());
        }
        let inverse = deformation_gradient.try_inverse().ok_or_else(inverted)?;
        let mut gradients = [Vector3::zeros(); N];
        for a in 0..N {
            gradients[a] = inverse.tr_mul(&self.gradients[point][a]);
        }
        Ok(Moved { jacobian, deformation_gradient, gradients })
    }
}

impl<const N: usize, const P: usize, const Q: usize, const W: usize, const I: usize> Typed<N, P, Q, W, I> {
    /// Whether the pressure is that of the mean dilatation.
    const IS_MEAN: bool = Q == 0;

    fn new(
        reference: &Reference,
        positions: &[[f64; 3]],
        nodes: &[usize],
        index: usize,
    ) -> Result<Self, SolidError> {
        let own: [usize; N] = std::array::from_fn(|a| if a < N - I { nodes[a] } else { nodes[0] });
        let corners = relative(positions, &own);
        let distortion = Points::new(&reference.distortion, &corners, index)?;
        let mut dilatation = Points::new(&reference.dilatation, &corners, index)?;
        let volume = distortion.weights.iter().sum();
        if I > 0 {
            modes::correct(&mut dilatation, &distortion, volume, N - I);
        }
        Ok(Self { nodes: own, distortion, dilatation, volume })
    }

    fn own_nodes(&self) -> &[usize] {
        &self.nodes[..N - I]
    }

    /// Where the nodes are relative to the first, and the modes in equilibrium with them.
    fn placed(&self, step: Step<'_>, scratch: &mut Scratch) -> Result<[Vector3<f64>; N], SolidError> {
        let corners = relative(step.positions, &self.nodes);
        if I == 0 { Ok(corners) } else { self.with_modes(step, corners, scratch) }
    }

    fn evaluate(
        &self,
        step: Step<'_>,
        results: Results<'_>,
        scratch: &mut Scratch,
    ) -> Result<(), SolidError> {
        let Results { forces: total, states, tangent } = results;
        let with_tangent = !tangent.is_empty();
        let corners = self.placed(step, scratch)?;
        let mut isochoric = [Vector3::zeros(); N];
        // Σ p ∂v/∂x, with p = 1 while it is not known.
        let mut by_volume = [Vector3::zeros(); N];
        let mut current_volume = 0.0;
        if with_tangent {
            scratch.clear::<N, P, Q, W>();
        }
        for point in 0..P {
            let (deformed, gradients) = self.distorted(step, point, &corners)?;
            let weight = self.distortion.weights[point];
            let stress = deformed.answer.kirchhoff() * weight;
            let mut forces = [Vector3::zeros(); N];
            for a in 0..N {
                forces[a] = stress * gradients[a];
                isochoric[a] += forces[a];
            }
            states[point] = deformed.answer.state;
            let volume = weight * deformed.jacobian;
            if Self::IS_MEAN {
                current_volume += volume;
                (0..N).for_each(|a| by_volume[a] += gradients[a] * volume);
            }
            if with_tangent {
                scratch.add_distortion::<N, W>(point, &deformed, &gradients, &forces, weight);
                if Self::IS_MEAN {
                    scratch.add_area(&gradients, volume);
                }
            }
        }
        self.add_dilatation(step, &corners, &mut by_volume, with_tangent.then_some(&mut *scratch))?;
        let mean = Self::IS_MEAN.then(|| step.law.volumetric(current_volume / self.volume));
        let pressure = mean.as_ref().map_or(1.0, |mean| mean.pressure);
        for (total, (isochoric, by_volume)) in
            total.as_chunks_mut::<3>().0.iter_mut().zip(isochoric.iter().zip(&by_volume))
        {
            *total = (isochoric + by_volume * pressure).into();
        }
        if with_tangent {
            let full = Self::tangent(step.index, pressure, scratch)?;
            let stiffness = mean.map_or(0.0, |mean| mean.stiffness / self.volume);
            let mut entries = tangent.iter_mut();
            for i in 0..3 * (N - I) {
                let factor = stiffness * by_volume[i / 3][i % 3];
                for (j, entry) in entries.by_ref().take(i + 1).enumerate() {
                    *entry = full[i][j] + factor * by_volume[j / 3][j % 3];
                }
            }
        }
        Ok(())
    }

    /// Adds what acts on the volume at the points of dilatation; to the tangent, too, if it is there.
    fn add_dilatation(
        &self,
        step: Step<'_>,
        corners: &[Vector3<f64>; N],
        by_volume: &mut [Vector3<f64>; N],
        mut tangent: Option<&mut Scratch>,
    ) -> Result<(), SolidError> {
        for point in 0..Q {
            let Moved { jacobian, gradients, .. } = self.dilatation.deform(step.index, point, corners)?;
            let weight = self.dilatation.weights[point];
            let volumetric = step.law.volumetric(jacobian);
            let load = weight * jacobian * volumetric.pressure;
            (0..N).for_each(|a| by_volume[a] += gradients[a] * load);
            if let Some(scratch) = &mut tangent {
                scratch.add_area(&gradients, load);
                let stiffness = weight * jacobian.powi(2) * volumetric.stiffness;
                scratch.add_dilatation::<N, W>(6 * P + point, &gradients, stiffness);
            }
        }
        Ok(())
    }

    /// The tangent with this pressure where it is a mean one; modes follow the nodes.
    fn tangent(index: usize, pressure: f64, scratch: &Scratch) -> Result<[[f64; W]; W], SolidError> {
        let mut full = scratch.product::<W>();
        scratch.scatter::<N, W>(pressure, &mut full);
        if I > 0 {
            modes::condense(&mut full, 3 * (N - I)).ok_or_else(|| modes::unstable(index))?;
        }
        Ok(full)
    }

    fn stored_energy(&self, step: Step<'_>, scratch: &mut Scratch) -> Result<f64, SolidError> {
        let (mut energy, mut current_volume) = (0.0, 0.0);
        let corners = self.placed(step, scratch)?;
        for point in 0..P {
            let (deformed, _) = self.distorted(step, point, &corners)?;
            current_volume += self.distortion.weights[point] * deformed.jacobian;
            energy += self.distortion.weights[point] * deformed.answer.energy;
        }
        if Self::IS_MEAN {
            return Ok(energy + self.volume * step.law.volumetric(current_volume / self.volume).energy);
        }
        for point in 0..Q {
            let Moved { jacobian, .. } = self.dilatation.deform(step.index, point, &corners)?;
            energy += self.dilatation.weights[point] * step.law.volumetric(jacobian).energy;
        }
        Ok(energy)
    }

    fn for_each_point(
        &self,
        reference: &Reference,
        step: Step<'_>,
        mut visit: impl FnMut(&Deformed, f64),
    ) -> Result<(), SolidError> {
        let corners = self.placed(step, &mut Scratch::default())?;
        let mut points = Vec::with_capacity(P);
        let mut current_volume = 0.0;
        for point in 0..P {
            let (deformed, _) = self.distorted(step, point, &corners)?;
            current_volume += self.distortion.weights[point] * deformed.jacobian;
            points.push(deformed);
        }
        let mut pressures = [0.0; Q];
        for (point, pressure) in pressures.iter_mut().enumerate() {
            let Moved { jacobian, .. } = self.dilatation.deform(step.index, point, &corners)?;
            *pressure = step.law.volumetric(jacobian).pressure;
        }
        let mean = Self::IS_MEAN.then(|| step.law.volumetric(current_volume / self.volume).pressure);
        for (point, weights) in points.iter().zip(&reference.pressure) {
            let own: f64 = weights.iter().zip(&pressures).map(|(weight, pressure)| weight * pressure).sum();
            visit(point, mean.unwrap_or(own));
        }
        Ok(())
    }

    /// A point of distortion, with the gradients of the shape functions by current positions.
    #[inline]
    fn distorted(
        &self,
        step: Step<'_>,
        point: usize,
        corners: &[Vector3<f64>; N],
    ) -> Result<(Deformed, [Vector3<f64>; N]), SolidError> {
        let Moved { jacobian, deformation_gradient, gradients } =
            self.distortion.deform(step.index, point, corners)?;
        let unresolved = |source| SolidError::Unresolved { element: step.index, name: None, point, source };
        let answer = step.law.isochoric(&deformation_gradient, &step.committed[point]).map_err(unresolved)?;
        Ok((Deformed { jacobian, answer }, gradients))
    }
}

/// Positions of the nodes relative to the first: gradients do not see where the element is, and digits are kept far from
/// the origin.
#[inline]
fn relative<const N: usize>(positions: &[[f64; 3]], nodes: &[usize; N]) -> [Vector3<f64>; N] {
    let origin = Vector3::from(positions[nodes[0]]);
    let mut corners = [Vector3::zeros(); N];
    for a in 0..N {
        corners[a] = Vector3::from(positions[nodes[a]]) - origin;
    }
    corners
}

/// Σ xₐ ⊗ ∇Nₐ.
#[inline]
fn gradient<const N: usize>(corners: &[Vector3<f64>; N], gradients: &[Vector3<f64>; N]) -> Matrix3<f64> {
    let mut sum = Matrix3::zeros();
    for a in 0..N {
        for j in 0..3 {
            for i in 0..3 {
                sum[(i, j)] += corners[a][i] * gradients[a][j];
            }
        }
    }
    sum
}
