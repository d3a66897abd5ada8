//! Solid elements at finite strain: tetrahedra, wedges and hexahedra of first and second order.
//!
//! The stored energy of an element is that of the isochoric part of the deformation gradient F at each of its integration points, and of
//! the change of volume. Forces are its gradient by the positions of the nodes, and the tangent is symmetric.
//!
//! * **Hexahedra with 8 nodes**: V U(θ) of the element's volume, θ = v/V. One pressure U'(θ) an element is the mean dilatation method; it
//!   does not lock as ν → 0.5.
//! * **With incompatible modes** these take three vectors more, Σ α_k (1 − ξ_k²), that are at equilibrium within the element: a function of
//!   its nodes, so that the stored energy is one of these alone and no history is kept. They bend, and do not lock as ν → 0.5: the
//!   dilatation is taken at the centres of the faces. Under a pressure above the shear modulus they lose their stiffness against hourglass
//!   motions.
//! * **All others**: U(det F) at each point. Tetrahedra with 4 nodes and wedges with 6 lock in bending and as ν → 0.5: they fill meshes.
//!   Those of second order do not lock in bending. Hexahedra with 20 and 27 nodes have 3 × 3 × 3 points of distortion but 2 × 2 × 2 of
//!   dilatation (selective integration), wedges with 15 nodes 9 and 6, so that they do not lock as ν → 0.5; tetrahedra with 10 nodes have
//!   four of both and lock little.
//!
//! Everything refers to the positions at the start (total description).

mod element;
mod error;
mod product;
mod recovery;
mod reference;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

pub use self::error::{ElementName, SolidError};
pub use self::recovery::{NodalFields, PointFields, Recovery};
pub use self::reference::{FacePoint, face_points};

use self::element::{Element, Results, Scratch, Step};
use crate::material::{Law, PointState};
use crate::model::Body;

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

/// All solid elements of a model at their positions at the start.
#[derive(Clone, Debug)]
pub struct Solid {
    nodes: usize,
    elements: Vec<Element>,
    /// For each element where its numbers begin, and the end.
    starts: Vec<Start>,
    bodies: Vec<BodyElements>,
    /// What [`parts`](Self::parts) found.
    parts: OnceLock<Vec<(String, Vec<usize>)>>,
}

/// Where the numbers of an element begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Start {
    /// In a list of three forces for each node of each element.
    forces: usize,
    /// In a list of points.
    points: usize,
    /// In a list of lower triangles.
    tangents: usize,
}

#[derive(Clone, Debug)]
struct BodyElements {
    law: Law,
    elements: Range<usize>,
    /// The name of its part.
    part: String,
    /// The body's, which names the material's set where the part has several.
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
    /// Internal forces, force: the gradient of the stored energy, three for each node of each element. At equilibrium their sums equal
    /// the loads.
    pub forces: Vec<f64>,
    /// Derivatives of the forces, force per length: the lower triangle row by row, entry (i, j ≤ i) at i(i+1)/2 + j. Empty
    /// after [`Order::Residual`].
    pub tangents: Vec<f64>,
    /// States at the end of the step, one for each point of each element.
    pub states: Vec<PointState>,
}

/// An element with what was found for it.
#[derive(Clone, Copy, Debug)]
pub struct ElementResponse<'a> {
    /// Its nodes.
    pub nodes: &'a [usize],
    /// Internal forces on them, three each.
    pub forces: &'a [f64],
    /// The lower triangle of their derivative; empty after [`Order::Residual`].
    pub tangent: &'a [f64],
}

/// The nodes of elements, ascending, apart where no chain of shared nodes leads from one to another.
fn pieces(elements: &[Element]) -> Vec<Vec<usize>> {
    let used: BTreeSet<usize> = elements.iter().flat_map(Element::nodes).copied().collect();
    // From each node a way down to the least one of its piece.
    let mut towards: Vec<usize> = (0..used.last().map_or(0, |last| last + 1)).collect();
    let least = |towards: &mut Vec<usize>, mut node: usize| {
        while towards[node] != node {
            towards[node] = towards[towards[node]];
            node = towards[node];
        }
        node
    };
    for element in elements {
        for pair in element.nodes().windows(2) {
            let (a, b) = (least(&mut towards, pair[0]), least(&mut towards, pair[1]));
            towards[a.max(b)] = a.min(b);
        }
    }
    let mut pieces: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for node in used {
        pieces.entry(least(&mut towards, node)).or_default().push(node);
    }
    pieces.into_values().collect()
}

impl Solid {
    /// The elements of `bodies` on `nodes`, positions at the start. Nodes outside the bodies are allowed.
    ///
    /// # Errors
    /// A bad material, a node that is missing or not finite, an element whose Jacobian at an integration point is not positive.
    pub fn new(nodes: &[[f64; 3]], bodies: &[Body]) -> Result<Self, SolidError> {
        error::check_finite(nodes)?;
        let mut elements = Vec::with_capacity(bodies.iter().map(|body| body.elements.len()).sum());
        let mut parts = Vec::with_capacity(bodies.len());
        for (index, body) in bodies.iter().enumerate() {
            let law =
                Law::new(&body.material).map_err(|source| SolidError::Material { body: index, source })?;
            let start = elements.len();
            let (part, name, labels) = (body.part.clone(), body.name.clone(), body.labels.clone());
            let part = BodyElements { law, elements: start..start + body.elements.len(), part, name, labels };
            for cell in body.elements.iter() {
                let element = Element::new(cell, nodes, elements.len());
                elements.push(element.map_err(|error| error.named(|element| part.name_of(element)))?);
            }
            parts.push(part);
        }
        let ends = elements.iter().scan(Start::default(), |end, element: &Element| {
            let coordinates = 3 * element.nodes().len();
            end.forces += coordinates;
            end.points += element.points();
            end.tangents += coordinates * (coordinates + 1) / 2;
            Some(*end)
        });
        let starts = std::iter::once(Start::default()).chain(ends).collect();
        Ok(Self { nodes: nodes.len(), elements, starts, bodies: parts, parts: OnceLock::new() })
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// The nodes of each element, body by body.
    pub fn elements(&self) -> impl ExactSizeIterator<Item = &[usize]> + Clone {
        self.elements.iter().map(Element::nodes)
    }

    /// The points of an element in lists of all points.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn points(&self, element: usize) -> Range<usize> {
        self.starts[element].points..self.starts[element + 1].points
    }

    /// What [`evaluate`](Self::evaluate) found for each element.
    pub fn responses<'a>(&'a self, response: &'a SolidResponse) -> impl Iterator<Item = ElementResponse<'a>> {
        let with_tangents = !response.tangents.is_empty();
        self.elements.iter().zip(self.starts.windows(2)).map(move |(element, starts)| ElementResponse {
            nodes: element.nodes(),
            forces: &response.forces[starts[0].forces..starts[1].forces],
            tangent: if with_tangents {
                &response.tangents[starts[0].tangents..starts[1].tangents]
            } else {
                &[]
            },
        })
    }

    /// The elements of a body, by its index.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn body(&self, index: usize) -> Range<usize> {
        self.bodies[index].elements.clone()
    }

    /// What elements hold together: the parts by their names in the deck, with their nodes. Pieces of a part that share no node are parts of
    /// their own, named by a node of theirs.
    pub fn parts(&self) -> &[(String, Vec<usize>)] {
        self.parts.get_or_init(|| self.find_parts())
    }

    fn find_parts(&self) -> Vec<(String, Vec<usize>)> {
        let mut parts = Vec::new();
        // Materials of a part are bodies one after the other.
        for bodies in self.bodies.chunk_by(|one, next| one.part == next.part) {
            let elements = bodies[0].elements.start..bodies[bodies.len() - 1].elements.end;
            let pieces = pieces(&self.elements[elements]);
            let (part, count) = (&bodies[0].part, pieces.len());
            let named = |nodes: Vec<usize>| match count {
                1 => (part.clone(), nodes),
                _ => (format!("{part}, the piece of node {} of the results", nodes[0]), nodes),
            };
            parts.extend(pieces.into_iter().map(named));
        }
        parts
    }

    /// The states at the start, one for each point of each element.
    pub fn states(&self) -> Vec<PointState> {
        vec![PointState::VIRGIN; self.end().points]
    }

    fn end(&self) -> Start {
        self.starts.last().copied().unwrap_or_default()
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
        let end = self.end();
        out.forces.resize(end.forces, 0.0);
        out.states.resize(end.points, PointState::VIRGIN);
        out.tangents.resize(if order == Order::Tangent { end.tangents } else { 0 }, 0.0);
        let all = Results { forces: &mut out.forces, states: &mut out.states, tangent: &mut out.tangents };
        let pieces = self.pieces(all);
        let failure = pieces
            .into_par_iter()
            .map(|(elements, results)| self.evaluate_piece(elements, positions, committed, results).err())
            .reduce(|| None, Option::or);
        failure.map_or(Ok(()), |error| Err(self.named(error)))
    }

    /// A few elements each, with the room for their results.
    fn pieces<'a>(&self, mut rest: Results<'a>) -> Vec<(Range<usize>, Results<'a>)> {
        let count = self.len();
        let pieces = (0..count).step_by(PIECE).map(|first| first..count.min(first + PIECE));
        pieces
            .map(|elements| {
                let piece = rest.split_off(self.starts[elements.start], self.starts[elements.end]);
                (elements, piece)
            })
            .collect()
    }

    /// Some elements, one after the other.
    fn evaluate_piece(
        &self,
        elements: Range<usize>,
        positions: &[[f64; 3]],
        committed: &[PointState],
        mut rest: Results<'_>,
    ) -> Result<(), SolidError> {
        let mut scratch = Scratch::default();
        for index in elements {
            let results = rest.split_off(self.starts[index], self.starts[index + 1]);
            self.elements[index].evaluate(self.step(index, positions, committed), results, &mut scratch)?;
        }
        Ok(())
    }

    fn step<'a>(&'a self, index: usize, positions: &'a [[f64; 3]], states: &'a [PointState]) -> Step<'a> {
        Step { index, law: self.law(index), positions, committed: &states[self.points(index)] }
    }

    /// The stored elastic energy of all elements, force times length.
    ///
    /// # Errors
    /// Those of [`Solid::evaluate`].
    pub fn stored_energy(&self, positions: &[[f64; 3]], committed: &[PointState]) -> Result<f64, SolidError> {
        self.check(positions, committed)?;
        let piece = |first: usize| {
            let mut scratch = Scratch::default();
            let elements = first..self.len().min(first + PIECE);
            let energy = |index: usize| {
                self.elements[index].stored_energy(self.step(index, positions, committed), &mut scratch)
            };
            elements.map(energy).sum::<Result<f64, SolidError>>()
        };
        let starts: Vec<usize> = (0..self.len()).step_by(PIECE).collect();
        // One order of the sum for any number of threads.
        let energies: Vec<Result<f64, SolidError>> = starts.into_par_iter().map(piece).collect();
        energies.into_iter().sum::<Result<f64, SolidError>>().map_err(|error| self.named(error))
    }

    /// c E L h, force, with c = 5e-16: about what rounding of coordinates makes of the forces on a node of the softest body. E is the least
    /// modulus, L the largest extent of the elements along an axis, h their mean size.
    pub fn rounding_of_forces(&self, positions: &[[f64; 3]]) -> f64 {
        const ROUNDING: f64 = 5e-16;
        let young = self.bodies.iter().map(|body| body.law.young_modulus()).fold(f64::INFINITY, f64::min);
        if self.is_empty() {
            return 0.0;
        }
        let extent = |axis: usize| {
            let along = self.elements().flatten().map(|&node| positions[node][axis]);
            let (low, high) = along.fold((f64::MAX, f64::MIN), |(low, high), x| (x.min(low), x.max(high)));
            high - low
        };
        let extent = (0..3).map(extent).fold(0.0, f64::max);
        let volume: f64 = self.elements.iter().map(Element::volume).sum();
        ROUNDING * young * extent * (volume / self.len().max(1) as f64).cbrt()
    }

    fn check(&self, positions: &[[f64; 3]], committed: &[PointState]) -> Result<(), SolidError> {
        error::check_count("positions", positions.len(), self.nodes)?;
        error::check_count("states", committed.len(), self.end().points)?;
        error::check_finite(positions)
    }

    fn law(&self, element: usize) -> &Law {
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

impl<'a> Results<'a> {
    /// Takes the part between two places from the beginning; without tangents there is none of them.
    fn split_off(&mut self, start: Start, end: Start) -> Self {
        let tangents = if self.tangent.is_empty() { 0 } else { end.tangents - start.tangents };
        Self {
            forces: take(&mut self.forces, end.forces - start.forces),
            states: take(&mut self.states, end.points - start.points),
            tangent: take(&mut self.tangent, tangents),
        }
    }
}

/// Takes the first entries off a slice.
fn take<'a, T>(slice: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, rest) = std::mem::take(slice).split_at_mut(count);
    *slice = rest;
    first
}
