//! Faces with nodes in the middle of their edges.
//!
//! Surfaces are made of flat facets, of which a face of second order has four or five. What follows from where things lie is theirs: the
//! gap, the pieces of a face, the pressures. Forces are those of the face itself, by all of its shape functions: only they are in
//! equilibrium with a uniform stress inside.

use std::collections::HashMap;

use super::FaceRule;
use super::carried::{Carried, carried, carried_by_quadratic};
use crate::interface::InterfaceError;
use crate::surface::{Facet, MasterSurface, Shape, SurfaceError, shape_of, sort};
use crate::vector::Vector3;
use crate::{Mode, Point};

/// The most nodes of a face.
pub(super) const MOST_NODES: usize = 9;

/// In the place of a node that a window does not have.
pub(super) const BEYOND: usize = usize::MAX;

/// A face of second order: a triangle with 6 nodes, a quadrilateral with 8 or 9. Corners come first, then the middles of the edges from
/// the first corner on, then the centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QuadraticFace {
    nodes: [usize; MOST_NODES],
    count: usize,
}

impl QuadraticFace {
    /// A face by its nodes; `None` if these are not 6, 8 or 9.
    pub fn new(nodes: &[usize]) -> Option<Self> {
        let mut own = [0; MOST_NODES];
        let is_known = matches!(nodes.len(), 6 | 8 | 9);
        is_known.then(|| {
            own[..nodes.len()].copy_from_slice(nodes);
            Self { nodes: own, count: nodes.len() }
        })
    }

    /// Its nodes.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes[..self.count]
    }

    /// The flat facets between all of its nodes, oriented as it is: a triangle at each corner and what the middles enclose, or four
    /// quadrilaterals around the centre.
    pub fn facets(&self) -> Vec<Facet> {
        let corners = if self.count == 6 { 3 } else { 4 };
        let (corner, middle) = self.nodes[..2 * corners].split_at(corners);
        let before = |k: usize| middle[(k + corners - 1) % corners];
        if self.count == 9 {
            let centre = self.nodes[8];
            return (0..4).map(|k| Facet::Quadrilateral([corner[k], middle[k], centre, before(k)])).collect();
        }
        let inner = match *middle {
            [a, b, c, d] => Facet::Quadrilateral([a, b, c, d]),
            _ => Facet::Triangle([middle[0], middle[1], middle[2]]),
        };
        (0..corners).map(|k| Facet::Triangle([before(k), corner[k], middle[k]])).chain([inner]).collect()
    }

    /// With other numbers for its nodes.
    pub(super) fn renumbered(&self, number: impl Fn(usize) -> usize) -> Self {
        let mut renumbered = *self;
        renumbered.nodes[..self.count].iter_mut().for_each(|node| *node = number(*node));
        renumbered
    }

    /// Natural coordinates of its nodes: from 0 to 1 on a triangle, from −1 to 1 on a quadrilateral.
    fn natural(&self) -> &'static [[f64; 2]] {
        const TRIANGLE: [[f64; 2]; 6] =
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
        const QUADRILATERAL: [[f64; 2]; 9] = [
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, 1.0],
            [-1.0, 1.0],
            [0.0, -1.0],
            [1.0, 0.0],
            [0.0, 1.0],
            [-1.0, 0.0],
            [0.0, 0.0],
        ];
        if self.count == 6 { &TRIANGLE } else { &QUADRILATERAL[..self.count] }
    }
}

/// What carries the forces of a facet: itself, or the face that it is a part of.
#[derive(Clone, Copy, Debug)]
pub(super) enum Carrying {
    Facet(Facet),
    /// The face, and where in it the facet's centre is.
    Face(QuadraticFace, [f64; 2]),
    /// A face with nodes beyond the window, and whether it is a quadrilateral.
    Beyond(bool),
}

impl Carrying {
    /// The nodes that forces act on.
    pub fn nodes(&self) -> &[usize] {
        match self {
            Self::Facet(facet) => facet.corners(),
            Self::Face(face, _) => face.nodes(),
            Self::Beyond(_) => &[],
        }
    }

    /// Where the nodes' shape functions of a place have it.
    pub fn point(&self, functions: &[f64; MOST_NODES], positions: &[Point]) -> Point {
        let mut x = [0.0; 3];
        for (&node, n) in self.nodes().iter().zip(functions) {
            (0..3).for_each(|axis| x[axis] += n * positions[node][axis]);
        }
        x
    }

    /// A force through a point.
    pub fn carried(&self, positions: &[Point], point: Point, force: Point, mode: Mode) -> Option<Carried> {
        match self {
            Self::Facet(facet) => carried(&shape_of(facet, positions), point, force, mode),
            Self::Face(face, start) => {
                let mut nodes = [[0.0; 3]; MOST_NODES];
                for (x, &node) in nodes.iter_mut().zip(face.nodes()) {
                    *x = positions[node];
                }
                carried_by_quadratic(&nodes[..face.count], *start, point, force, mode)
            }
            Self::Beyond(_) => None,
        }
    }

    /// The shape functions of the nodes at a place of a facet, seen along the facet's normal; `None` if the face is not there.
    pub fn functions(
        &self,
        facet: &Shape,
        natural: [f64; 2],
        positions: &[Point],
    ) -> Option<[f64; MOST_NODES]> {
        let mut functions = [0.0; MOST_NODES];
        match self {
            Self::Facet(_) => functions[..4].copy_from_slice(&facet.functions(natural)),
            Self::Face(face, _) => {
                let (point, along) = (facet.point(natural), facet.normal());
                let carried = self.carried(positions, point.into(), along.into(), Mode::Value)?;
                for (function, &part) in functions.iter_mut().zip(&carried.forces[1..=face.count]) {
                    *function = Vector3::from(part).dot(&along);
                }
            }
            Self::Beyond(_) => return None,
        }
        Some(functions)
    }
}

/// For each facet of both sides what carries its forces.
#[derive(Clone, Debug, Default)]
pub(super) struct Carriers {
    pub faces: Vec<Carrying>,
    pub facets: Vec<Carrying>,
    /// All nodes that carry, ascending.
    pub nodes: Vec<usize>,
}

impl Carriers {
    /// Looks for the face that each facet of both sides is a part of: the one that has all of its corners. Facets without one carry their
    /// own forces. Nodes beyond a window are [`BEYOND`].
    pub fn new(faces: &[Facet], master: &MasterSurface, quadratic: &[QuadraticFace]) -> Self {
        let mut around: HashMap<usize, Vec<&QuadraticFace>> = HashMap::new();
        for face in quadratic {
            let known = face.nodes().iter().filter(|&&node| node != BEYOND);
            known.for_each(|&node| around.entry(node).or_default().push(face));
        }
        let of = |facet: Facet| {
            let corners = facet.corners();
            let place = |face: &QuadraticFace, node: usize| face.nodes().iter().position(|&own| own == node);
            let found = around.get(&corners[0]).into_iter().flatten().find_map(|&face| {
                let places: Option<Vec<usize>> = corners.iter().map(|&node| place(face, node)).collect();
                let natural = places?.into_iter().map(|k| face.natural()[k]);
                let sum = natural.fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]]);
                Some((*face, sum.map(|x| x / corners.len() as f64)))
            });
            match found {
                Some((face, _)) if face.nodes().contains(&BEYOND) => Carrying::Beyond(face.count > 6),
                Some((face, start)) => Carrying::Face(face, start),
                None => Carrying::Facet(facet),
            }
        };
        let faces: Vec<Carrying> = faces.iter().map(|&face| of(face)).collect();
        let facets: Vec<Carrying> = (0..master.facet_count()).map(|facet| of(master.facet(facet))).collect();
        let mut nodes: Vec<usize> = faces.iter().chain(&facets).flat_map(Carrying::nodes).copied().collect();
        sort(&mut nodes);
        Self { faces, facets, nodes }
    }

    /// The rule that a uniform pressure needs between a face and a facet: the shape functions of quadrilaterals with 8 and 9 nodes have
    /// the third and fourth degree.
    pub fn rule(&self, (face, facet): (usize, u32), wanted: FaceRule) -> FaceRule {
        let is_quadrilateral = |carrying: &Carrying| match carrying {
            Carrying::Facet(_) => false,
            Carrying::Face(face, _) => face.count > 6,
            Carrying::Beyond(is_quadrilateral) => *is_quadrilateral,
        };
        let both = [&self.faces[face], &self.facets[facet as usize]];
        if both.into_iter().any(is_quadrilateral) { FaceRule::Fourth } else { wanted }
    }
}

/// Checks that all nodes of the faces exist, and none stands twice in one.
pub(super) fn check(quadratic: &[QuadraticFace], positions: &[Point]) -> Result<(), InterfaceError> {
    let count = positions.len();
    for (facet, face) in quadratic.iter().enumerate() {
        if let Some(&node) = face.nodes().iter().find(|&&node| node >= count) {
            return Err(SurfaceError::NodeOutOfRange { facet, node, count }.into());
        }
    }
    check_distinct(quadratic)
}

/// Checks that no node stands twice in one of the faces.
pub(super) fn check_distinct(quadratic: &[QuadraticFace]) -> Result<(), InterfaceError> {
    for (facet, face) in quadratic.iter().enumerate() {
        let nodes = face.nodes();
        if let Some(place) = (1..nodes.len()).find(|&place| nodes[..place].contains(&nodes[place])) {
            return Err(SurfaceError::RepeatedNode { facet, node: nodes[place] }.into());
        }
    }
    Ok(())
}
