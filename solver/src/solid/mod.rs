//! Hexahedra with eight nodes at finite strain, free of volumetric locking.
//!
//! The stored energy of an element is that of the isochoric part of the deformation gradient F at each of 2 × 2 × 2
//! integration points, and V U(θ) of the element's volume, θ = v/V. Forces are its gradient by the positions of the nodes, so
//! they depend on F at the points and on v alone, and the tangent is symmetric. One pressure U'(θ) an element is the mean
//! dilatation method; it does not lock as ν → 0.5.
//!
//! Everything refers to the positions at the start (total description).

mod element;
mod error;
mod product;
mod recovery;
mod shape;

use std::ops::Range;

use rayon::prelude::*;

pub use self::error::{ElementName, SolidError};
pub use self::recovery::{NodalFields, PointFields, Recovery};

use self::element::{Element, Scratch};
use crate::material::{Hencky, PointState};
use crate::model::Body;

/// Integration points of an element.
pub const POINTS: usize = 8;
/// Coordinates of an element's nodes: node by node, x, y, z.
pub const COORDINATES: usize = 24;
/// Entries of the lower triangle of an element's tangent.
pub const TRIANGLE: usize = COORDINATES * (COORDINATES + 1) / 2;

/// Elements that a thread takes at once.
const PIECE: usize = 16;

/// How much is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Forces and states.
    Residual,
    /// Tangents too.
    Tangent,
}

/// All hexahedra of a model at their positions at the start.
#[derive(Clone, Debug)]
pub struct Solid {
    nodes: usize,
    elements: Vec<Element>,
    bodies: Vec<BodyElements>,
}

#[derive(Clone, Debug)]
struct BodyElements {
    law: Hencky,
    elements: Range<usize>,
    /// The part's name.
    name: String,
    /// Numbers of the elements in the mesh file; none if there is no file.
    labels: Vec<u64>,
}

impl BodyElements {
    /// Of the element with this index.
    fn name_of(&self, element: usize) -> ElementName {
        let own = element - self.elements.start;
        ElementName { part: self.name.clone(), number: own + 1, label: self.labels.get(own).copied() }
    }
}

/// What [`Solid::evaluate`] found, element by element in the order of [`Solid::elements`]. Made once and used again.
#[derive(Clone, Debug, Default)]
pub struct SolidResponse {
    /// Internal forces on the nodes, force: the gradient of the stored energy. At equilibrium they equal the loads.
    pub forces: Vec<[f64; COORDINATES]>,
    /// Derivatives of the forces, force per length: the lower triangle row by row, entry (i, j ≤ i) at i(i+1)/2 + j. Empty
    /// after [`Order::Residual`].
    pub tangents: Vec<[f64; TRIANGLE]>,
    /// States at the end of the step, [`POINTS`] an element.
    pub states: Vec<PointState>,
}

impl Solid {
    /// The hexahedra of `bodies` on `nodes`, positions at the start. Nodes outside the bodies are allowed.
    ///
    /// # Errors
    /// A bad material, a node that is missing or not finite, an element whose Jacobian at an integration point is not positive.
    pub fn new(nodes: &[[f64; 3]], bodies: &[Body]) -> Result<Self, SolidError> {
        error::check_finite(nodes)?;
        let mut elements = Vec::with_capacity(bodies.iter().map(|body| body.elements.len()).sum());
        let mut parts = Vec::with_capacity(bodies.len());
        for (index, body) in bodies.iter().enumerate() {
            let law =
                Hencky::new(&body.material).map_err(|source| SolidError::Material { body: index, source })?;
            let start = elements.len();
            let (name, labels) = (body.name.clone(), body.labels.clone());
            let part = BodyElements { law, elements: start..start + body.elements.len(), name, labels };
            for corners in &body.elements {
                let element = Element::new(nodes, *corners, elements.len());
                elements.push(element.map_err(|error| error.named(|element| part.name_of(element)))?);
            }
            parts.push(part);
        }
        Ok(Self { nodes: nodes.len(), elements, bodies: parts })
    }

    /// Number of elements.
    #[must_use]
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// Whether there are no elements.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// The nodes of each element, body by body.
    pub fn elements(&self) -> impl ExactSizeIterator<Item = &[usize; 8]> + Clone {
        self.elements.iter().map(|element| &element.nodes)
    }

    /// The elements of a body, by its index.
    ///
    /// # Panics
    /// If there is no such body.
    #[must_use]
    pub fn body(&self, index: usize) -> Range<usize> {
        self.bodies[index].elements.clone()
    }

    /// The states at the start, [`POINTS`] an element.
    #[must_use]
    pub fn states(&self) -> Vec<PointState> {
        vec![PointState::VIRGIN; POINTS * self.len()]
    }

    /// Forces, and on request tangents, at `positions` of all nodes, for the step from the `committed` states. The result does
    /// not depend on the number of threads, bit for bit.
    ///
    /// # Errors
    /// Wrong lengths, a position that is not finite, an element turned inside out at an integration point or deformed beyond
    /// what numbers resolve: the first one is named. Then `out` is of no use.
    pub fn evaluate(
        &self,
        positions: &[[f64; 3]],
        committed: &[PointState],
        order: Order,
        out: &mut SolidResponse,
    ) -> Result<(), SolidError> {
        self.check(positions, committed)?;
        let count = self.len();
        out.forces.resize(count, [0.0; COORDINATES]);
        out.states.resize(POINTS * count, PointState::VIRGIN);
        let tangents = match order {
            Order::Residual => 0,
            Order::Tangent => count,
        };
        out.tangents.resize(tangents, [0.0; TRIANGLE]);

        let pieces = out
            .forces
            .par_chunks_mut(PIECE)
            .zip_eq(out.states.par_chunks_mut(PIECE * POINTS))
            .enumerate()
            .map(|(piece, (forces, states))| (piece * PIECE, forces, states));
        let run = |first: usize,
                   forces: &mut [[f64; COORDINATES]],
                   states: &mut [PointState],
                   tangents: Option<&mut [[f64; TRIANGLE]]>| {
            self.evaluate_piece(first, positions, committed, forces, states, tangents)
        };
        let failure = match order {
            Order::Residual => pieces
                .map(|(first, forces, states)| run(first, forces, states, None))
                .reduce(|| None, Option::or),
            Order::Tangent => pieces
                .zip_eq(out.tangents.par_chunks_mut(PIECE))
                .map(|((first, forces, states), tangents)| run(first, forces, states, Some(tangents)))
                .reduce(|| None, Option::or),
        };
        failure.map_or(Ok(()), |error| Err(self.named(error)))
    }

    /// The elements from `first` on, one after the other.
    fn evaluate_piece(
        &self,
        first: usize,
        positions: &[[f64; 3]],
        committed: &[PointState],
        forces: &mut [[f64; COORDINATES]],
        states: &mut [PointState],
        mut tangents: Option<&mut [[f64; TRIANGLE]]>,
    ) -> Option<SolidError> {
        let mut scratch = Scratch::default();
        for (slot, force) in forces.iter_mut().enumerate() {
            let index = first + slot;
            let points = POINTS * index..POINTS * (index + 1);
            let result = self.elements[index].evaluate(
                index,
                self.law(index),
                positions,
                &committed[points],
                force,
                &mut states[POINTS * slot..POINTS * (slot + 1)],
                tangents.as_deref_mut().map(|tangents| &mut tangents[slot]),
                &mut scratch,
            );
            if let Err(error) = result {
                return Some(error);
            }
        }
        None
    }

    /// The stored elastic energy of all elements, force times length.
    ///
    /// # Errors
    /// Those of [`Solid::evaluate`].
    pub fn stored_energy(&self, positions: &[[f64; 3]], committed: &[PointState]) -> Result<f64, SolidError> {
        self.check(positions, committed)?;
        let mut total = 0.0;
        for (index, element) in self.elements.iter().enumerate() {
            let states = &committed[POINTS * index..POINTS * (index + 1)];
            let energy = element.stored_energy(index, self.law(index), positions, states);
            total += energy.map_err(|error| self.named(error))?;
        }
        Ok(total)
    }

    fn check(&self, positions: &[[f64; 3]], committed: &[PointState]) -> Result<(), SolidError> {
        error::check_count("positions", positions.len(), self.nodes)?;
        error::check_count("states", committed.len(), POINTS * self.len())?;
        error::check_finite(positions)
    }

    fn law(&self, element: usize) -> &Hencky {
        &self.body_of(element).law
    }

    fn body_of(&self, element: usize) -> &BodyElements {
        let body = self.bodies.partition_point(|body| body.elements.end <= element);
        &self.bodies[body]
    }

    /// An error with the name of its element.
    fn named(&self, error: SolidError) -> SolidError {
        error.named(|element| self.body_of(element).name_of(element))
    }
}
