//! Which facets meet where, and whether they make up an oriented surface.

use rayon::prelude::*;

use super::checks::{check_facets, check_position};
use super::{Facet, Shape, SurfaceError, SurfaceIndex};
use crate::Point;
use crate::vector::Vector3;

/// Stands for "no facet" and for the fourth corner of a triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// The master surface: which facets meet in which edges and nodes, checked once. Positions are no part of it.
///
/// Nodes are numbered twice: by the caller's index of all nodes, and, in flat arrays of this crate, by their
/// place in [`nodes`](Self::nodes). Everything public names the caller's indices.
#[derive(Clone, Debug)]
pub struct MasterSurface {
    /// The caller's indices of the nodes, ascending.
    nodes: Vec<u32>,
    /// Corners by place in `nodes`; the fourth of a triangle is [`NONE`].
    corners: Vec<[u32; 4]>,
    /// The facet across the edge from corner k to the next, or [`NONE`].
    neighbours: Vec<[u32; 4]>,
    /// Where the facets of a node begin in `facets_of_nodes`.
    offsets: Vec<u32>,
    /// Facets at each node, ascending.
    facets_of_nodes: Vec<u32>,
    /// Per facet, bit k where it is not known what lies across the edge from corner k to the next; none of a whole surface.
    cut: Vec<u8>,
}

/// An edge as one facet runs through it, ordered by its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// The lower and the higher end.
    ends: [u32; 2],
    facet: u32,
    edge: u8,
    /// From the lower to the higher end.
    ascending: bool,
}

impl MasterSurface {
    /// Checks that `facets` with these positions are an oriented surface, and connects them. The surface may have
    /// borders, holes and several parts. Sorting the edges dominates: about a second for a million nodes.
    ///
    /// # Errors
    /// [`SurfaceError::Empty`], [`SurfaceError::NodeOutOfRange`], [`SurfaceError::RepeatedNode`],
    /// [`SurfaceError::NonFinitePosition`], [`SurfaceError::NoArea`], [`SurfaceError::NotConvex`],
    /// [`SurfaceError::BranchingEdge`], [`SurfaceError::InconsistentOrientation`], [`SurfaceError::TooMany`].
    pub fn new(positions: &[Point], facets: Vec<Facet>) -> Result<Self, SurfaceError> {
        if facets.is_empty() {
            return Err(SurfaceError::Empty);
        }
        check_facets(positions, &facets)?;
        let (nodes, corners) = number_nodes(positions.len(), &facets);
        drop(facets);
        let neighbours = connect(&nodes, &corners)?;
        let (offsets, facets_of_nodes) = invert(nodes.len(), &corners);
        Ok(Self { nodes, corners, neighbours, offsets, facets_of_nodes, cut: Vec::new() })
    }

    /// A part of a surface that has been checked, whose nodes are the first positions. `is_border` tells whether the whole surface ends
    /// at an edge of a facet that no other facet of the part has: elsewhere the part is cut. There may be no facet.
    pub(crate) fn part(
        nodes: usize,
        corners: Vec<[u32; 4]>,
        is_border: impl Fn(usize, usize) -> bool,
    ) -> Result<Self, SurfaceError> {
        let nodes: Vec<u32> = (0..nodes as u32).collect();
        let neighbours = connect(&nodes, &corners)?;
        let (offsets, facets_of_nodes) = invert(nodes.len(), &corners);
        let mut surface = Self { nodes, corners, neighbours, offsets, facets_of_nodes, cut: Vec::new() };
        let of_facet = |facet: usize| {
            let edges = surface.across(facet).iter().enumerate();
            let cut = edges.map(|(edge, &other)| u8::from(other == NONE && !is_border(facet, edge)) << edge);
            cut.sum()
        };
        surface.cut = (0..surface.facet_count()).map(of_facet).collect();
        Ok(surface)
    }

    /// All facets seen from the other side: for a mesh whose corners run clockwise seen from outside.
    #[must_use]
    pub fn flipped(facets: &[Facet]) -> Vec<Facet> {
        facets.iter().map(|facet| facet.flipped()).collect()
    }

    /// The indices of the surface's nodes, ascending.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Number of facets.
    pub const fn facet_count(&self) -> usize {
        self.corners.len()
    }

    /// Number of positions that everything geometric needs: the highest index of a node, plus 1.
    pub fn positions_needed(&self) -> usize {
        self.nodes.last().map_or(0, |&node| node as usize + 1)
    }

    /// The `index`-th facet.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn facet(&self, index: usize) -> Facet {
        let node = |place: u32| self.nodes[place as usize] as usize;
        let [a, b, c, d] = self.corners[index];
        if d == NONE {
            Facet::Triangle([a, b, c].map(node))
        } else {
            Facet::Quadrilateral([a, b, c, d].map(node))
        }
    }

    /// The facets across the edges of a facet, in the order of its edges; `None` at a border, and where a part of a surface is cut.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn neighbours(&self, facet: usize) -> impl Iterator<Item = Option<usize>> {
        self.across(facet).iter().map(|&other| (other != NONE).then_some(other as usize))
    }

    /// The facets at a node, ascending; none if it is not a node of the surface.
    pub fn facets_at(&self, node: usize) -> impl Iterator<Item = usize> {
        let place = u32::try_from(node).ok().and_then(|node| self.nodes.binary_search(&node).ok());
        let facets = place.map_or(&[][..], |place| self.facets_of_place(place));
        facets.iter().map(|&facet| facet as usize)
    }

    /// The facets at the node with this place in [`nodes`](Self::nodes), ascending.
    pub(crate) fn facets_of_place(&self, place: usize) -> &[u32] {
        &self.facets_of_nodes[self.offsets[place] as usize..self.offsets[place + 1] as usize]
    }

    /// The edges that belong to one facet only, as that facet runs through them. Those at which a part of a surface is cut are none.
    pub fn border_edges(&self) -> impl Iterator<Item = [usize; 2]> {
        self.single_edges(false)
    }

    /// The edges at which a part of a surface is cut, as its facet runs through them: it is not known what lies across. None of a whole
    /// surface.
    pub fn cut_edges(&self) -> impl Iterator<Item = [usize; 2]> {
        self.single_edges(true)
    }

    fn single_edges(&self, cut: bool) -> impl Iterator<Item = [usize; 2]> {
        (0..self.facet_count()).flat_map(move |facet| {
            let corners = self.corners_of(facet);
            let count = corners.len();
            let node = |place: u32| self.nodes[place as usize] as usize;
            (0..count)
                .filter(move |&edge| self.neighbours[facet][edge] == NONE && self.is_cut(facet, edge) == cut)
                .map(move |edge| [node(corners[edge]), node(corners[(edge + 1) % count])])
        })
    }

    /// Whether this is a part of a surface, as a [`Window`](super::Window) holds it.
    pub const fn is_part(&self) -> bool {
        !self.cut.is_empty() || self.corners.is_empty()
    }

    /// Whether it is not known what lies across an edge.
    pub(crate) fn is_cut(&self, facet: usize, edge: usize) -> bool {
        self.cut.get(facet).is_some_and(|cut| cut >> edge & 1 == 1)
    }

    /// Outward normals of the nodes, in the order of [`nodes`](Self::nodes): the sum of the area vectors of the
    /// facets at each, not normalised.
    ///
    /// # Errors
    /// [`SurfaceError::TooFewPositions`], [`SurfaceError::NonFinitePosition`].
    pub fn node_normals(&self, positions: &[Point]) -> Result<Vec<Point>, SurfaceError> {
        self.check_positions(positions)?;
        let area = |facet: &u32| self.shape(*facet as usize, positions).area_vector();
        let normal = |ends: &[u32]| {
            let facets = &self.facets_of_nodes[ends[0] as usize..ends[1] as usize];
            facets.iter().map(area).sum::<Vector3>().into()
        };
        Ok(self.offsets.par_windows(2).map(normal).collect())
    }

    /// The surface at these positions, ready for searching.
    ///
    /// # Errors
    /// [`SurfaceError::TooFewPositions`], [`SurfaceError::NonFinitePosition`].
    pub fn at(&self, positions: &[Point]) -> Result<SurfaceIndex<'_>, SurfaceError> {
        self.check_positions(positions)?;
        Ok(SurfaceIndex::new(self, positions))
    }

    /// Checks the positions of the surface's nodes.
    pub(crate) fn check_positions(&self, positions: &[Point]) -> Result<(), SurfaceError> {
        let (found, needed) = (positions.len(), self.positions_needed());
        if found < needed {
            return Err(SurfaceError::TooFewPositions { found, needed });
        }
        self.nodes.iter().try_for_each(|&node| check_position(positions, node as usize))
    }

    /// Corners of a facet by place in [`nodes`](Self::nodes).
    pub(crate) fn corners_of(&self, facet: usize) -> &[u32] {
        let corners = &self.corners[facet];
        &corners[..if corners[3] == NONE { 3 } else { 4 }]
    }

    /// The facets across its edges, [`NONE`] at a border and where it is cut.
    pub(crate) fn across(&self, facet: usize) -> &[u32] {
        &self.neighbours[facet][..self.corners_of(facet).len()]
    }

    /// A facet in space, by positions of all nodes.
    pub(crate) fn shape(&self, facet: usize, positions: &[Point]) -> Shape {
        self.shape_by(facet, |place| positions[self.nodes[place as usize] as usize])
    }

    /// A facet in space, by a position for each place in [`nodes`](Self::nodes).
    pub(crate) fn shape_by(&self, facet: usize, position: impl Fn(u32) -> Point) -> Shape {
        let [a, b, c, d] = self.corners[facet];
        if d == NONE {
            Shape::Triangle([a, b, c].map(|place| position(place).into()))
        } else {
            Shape::Quadrilateral([a, b, c, d].map(|place| position(place).into()))
        }
    }
}

/// The nodes in ascending order, and the corners by their place among them.
fn number_nodes(count: usize, facets: &[Facet]) -> (Vec<u32>, Vec<[u32; 4]>) {
    let mut places = vec![NONE; count];
    for &node in facets.iter().flat_map(Facet::corners) {
        places[node] = 0;
    }
    let mut nodes = Vec::new();
    for (node, place) in places.iter_mut().enumerate().filter(|(_, place)| **place != NONE) {
        *place = nodes.len() as u32;
        nodes.push(node as u32);
    }
    let corners = facets
        .iter()
        .map(|facet| match facet {
            Facet::Triangle([a, b, c]) => [places[*a], places[*b], places[*c], NONE],
            Facet::Quadrilateral(corners) => corners.map(|node| places[node]),
        })
        .collect();
    (nodes, corners)
}

/// The facet across each edge, found by sorting the edges.
fn connect(nodes: &[u32], corners: &[[u32; 4]]) -> Result<Vec<[u32; 4]>, SurfaceError> {
    let mut sides: Vec<Side> = Vec::with_capacity(4 * corners.len());
    for (facet, corners) in corners.iter().enumerate() {
        let count = if corners[3] == NONE { 3 } else { 4 };
        for edge in 0..count {
            let [from, to] = [corners[edge], corners[(edge + 1) % count]];
            let ends = [from.min(to), from.max(to)];
            sides.push(Side { ends, facet: facet as u32, edge: edge as u8, ascending: from < to });
        }
    }
    sides.par_sort_unstable();
    let mut neighbours = vec![[NONE; 4]; corners.len()];
    for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
        let named = |places: [u32; 2]| places.map(|place| nodes[place as usize] as usize);
        match edge {
            [one, two] if one.ascending != two.ascending => {
                neighbours[one.facet as usize][usize::from(one.edge)] = two.facet;
                neighbours[two.facet as usize][usize::from(two.edge)] = one.facet;
            }
            [one, two] => {
                let [low, high] = one.ends;
                return Err(SurfaceError::InconsistentOrientation {
                    facets: [one.facet as usize, two.facet as usize],
                    nodes: named(if one.ascending { [low, high] } else { [high, low] }),
                });
            }
            [one, two, three, ..] => {
                let facets = [one, two, three].map(|side| side.facet as usize);
                return Err(SurfaceError::BranchingEdge { nodes: named(one.ends), facets });
            }
            _ => {}
        }
    }
    Ok(neighbours)
}

/// The facets at each node.
fn invert(nodes: usize, corners: &[[u32; 4]]) -> (Vec<u32>, Vec<u32>) {
    let mut offsets = vec![0u32; nodes + 1];
    for &place in corners.as_flattened().iter().filter(|&&place| place != NONE) {
        offsets[place as usize + 1] += 1;
    }
    for node in 0..nodes {
        offsets[node + 1] += offsets[node];
    }
    let mut next = offsets.clone();
    let mut facets = vec![0u32; offsets[nodes] as usize];
    for (facet, corners) in corners.iter().enumerate() {
        for &place in corners.iter().filter(|&&place| place != NONE) {
            facets[next[place as usize] as usize] = facet as u32;
            next[place as usize] += 1;
        }
    }
    (offsets, facets)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of two unit squares, the right one cut in two triangles.
    fn strip() -> (Vec<Point>, Vec<Facet>) {
        let positions = (0..6).map(|k| [f64::from(k % 3), f64::from(k / 3), 0.0]).collect();
        let facets =
            vec![Facet::Quadrilateral([0, 1, 4, 3]), Facet::Triangle([1, 2, 5]), Facet::Triangle([1, 5, 4])];
        (positions, facets)
    }

    fn refused(positions: &[Point], facets: Vec<Facet>) -> SurfaceError {
        MasterSurface::new(positions, facets).expect_err("a bad surface")
    }

    #[test]
    fn facets_know_their_neighbours_and_nodes_their_facets() {
        let (mut positions, facets) = strip();
        // A node of no facet in front shifts every index.
        positions.insert(0, [f64::NAN; 3]);
        let facets: Vec<Facet> = facets
            .iter()
            .map(|facet| match facet {
                Facet::Triangle(corners) => Facet::Triangle(corners.map(|k| k + 1)),
                Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|k| k + 1)),
            })
            .collect();
        let surface = MasterSurface::new(&positions, facets.clone()).unwrap();
        assert_eq!(surface.nodes(), [1, 2, 3, 4, 5, 6]);
        assert_eq!((surface.facet_count(), surface.positions_needed()), (3, 7));
        assert!((0..3).all(|k| surface.facet(k) == facets[k]));
        let neighbours = |facet| surface.neighbours(facet).collect::<Vec<_>>();
        assert_eq!(neighbours(0), [None, Some(2), None, None]);
        assert_eq!(neighbours(1), [None, None, Some(2)]);
        assert_eq!(neighbours(2), [Some(1), None, Some(0)]);
        assert_eq!(surface.facets_at(2).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(surface.facets_at(3).collect::<Vec<_>>(), [1]);
        assert_eq!(surface.facets_at(0).count() + surface.facets_at(99).count(), 0);
        let border: Vec<[usize; 2]> = surface.border_edges().collect();
        assert_eq!(border, [[1, 2], [5, 4], [4, 1], [2, 3], [3, 6], [6, 5]]);
        let normals = surface.node_normals(&positions).unwrap();
        assert_eq!(normals[0], [0.0, 0.0, 1.0]);
        assert_eq!(normals[2], [0.0, 0.0, 0.5]);
    }

    #[test]
    fn what_is_no_surface_is_refused_by_name() {
        let (positions, facets) = strip();
        assert_eq!(refused(&positions, Vec::new()), SurfaceError::Empty);
        let with = |facet: Facet| [facets.clone(), vec![facet]].concat();
        assert_eq!(
            refused(&positions, with(Facet::Triangle([0, 9, 2]))),
            SurfaceError::NodeOutOfRange { facet: 3, node: 9, count: 6 }
        );
        assert_eq!(
            refused(&positions, with(Facet::Quadrilateral([0, 1, 4, 1]))),
            SurfaceError::RepeatedNode { facet: 3, node: 1 }
        );
        assert_eq!(
            refused(&positions, with(Facet::Triangle([0, 1, 2]))),
            SurfaceError::NoArea { facet: 3, area: 0.0, extent: 2.0 }
        );
        assert!(
            matches!(
                refused(&positions, vec![Facet::Quadrilateral([0, 1, 3, 4])]),
                SurfaceError::NotCyclic { facet: 0, .. }
            ),
            "an outline that crosses itself"
        );
        for value in [f64::NAN, f64::INFINITY, 1e200] {
            let mut positions = positions.clone();
            positions[5][1] = value;
            let error = refused(&positions, facets.clone());
            assert!(matches!(error, SurfaceError::NonFinitePosition { node: 5, .. }), "{error}");
        }
        let tiny: Vec<Point> = positions.iter().map(|x| x.map(|x| x * 1e-100)).collect();
        assert!(matches!(refused(&tiny, facets.clone()), SurfaceError::NoArea { facet: 0, .. }));
    }

    #[test]
    fn a_quadrilateral_has_to_be_convex() {
        let facet = || vec![Facet::Quadrilateral([3, 2, 1, 0])];
        // Nodes in the order against that of the corners, so that node 3 is corner 0.
        let with_third = |third: Point| [[0.0, 1.0, 0.0], third, [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
        for unit in [1e-70, 1.0, 1e70] {
            let scaled = |third: Point| with_third(third).map(|x| x.map(|x| x * unit));
            let sine_at_third = |third: Point| match refused(&scaled(third), facet()) {
                SurfaceError::NotConvex { facet: 0, corner: 2, node: 1, sine } => sine,
                error => panic!("{error}"),
            };
            // A dart, and three corners on a line.
            assert!((sine_at_third([0.25, 0.25, 0.0]) + 0.8).abs() < 1e-12);
            assert!(sine_at_third([0.5, 0.5, 0.0]).abs() < 1e-12);
            // Convex though slender, and warped.
            for third in [[0.501, 0.5, 0.0], [1.0, 1.0, 0.8], [1e-3, 1.0, 0.0]] {
                assert!(MasterSurface::new(&scaled(third), facet()).is_ok(), "{third:?}");
            }
        }
        let dart = refused(&with_third([0.25, 0.25, 0.0]), facet());
        assert!(dart.to_string().contains("split it into triangles"), "{dart}");
    }

    /// A bow-tie with one wing larger than the other, so that area is left.
    #[test]
    fn corners_out_of_order_are_told_an_order() {
        let bow = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 1.0, 0.0]];
        let error = refused(&bow, vec![Facet::Quadrilateral([0, 1, 2, 3])]);
        assert_eq!(error, SurfaceError::NotCyclic { facet: 0, order: [0, 1, 3, 2] });
        assert!(error.to_string().contains("[0, 1, 3, 2] or the reverse"), "{error}");
        let SurfaceError::NotCyclic { order, .. } = error else { unreachable!() };
        assert!(MasterSurface::new(&bow, vec![Facet::Quadrilateral(order)]).is_ok());
    }

    #[test]
    fn a_flipped_facet_is_named_with_its_neighbour() {
        let (positions, mut facets) = strip();
        facets[2] = facets[2].flipped();
        assert_eq!(
            refused(&positions, facets.clone()),
            SurfaceError::InconsistentOrientation { facets: [0, 2], nodes: [1, 4] }
        );
        facets[2] = facets[2].flipped();
        assert!(MasterSurface::new(&positions, MasterSurface::flipped(&facets)).is_ok());
        facets.push(facets[0]);
        assert!(matches!(
            refused(&positions, facets),
            SurfaceError::BranchingEdge { .. } | SurfaceError::InconsistentOrientation { .. }
        ));
    }

    #[test]
    fn a_moebius_strip_has_no_outside() {
        let n = 12;
        let position = |k: usize| {
            let angle = std::f64::consts::TAU * (k / 2) as f64 / n as f64;
            let across = (k % 2) as f64 - 0.5;
            let radius = 2.0 + across * (0.5 * angle).cos();
            [radius * angle.cos(), radius * angle.sin(), across * (0.5 * angle).sin()]
        };
        let positions: Vec<Point> = (0..2 * n).map(position).collect();
        let mut facets: Vec<Facet> =
            (0..n - 1).map(|k| Facet::Quadrilateral([2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2])).collect();
        assert!(MasterSurface::new(&positions, facets.clone()).is_ok());
        facets.push(Facet::Quadrilateral([2 * n - 2, 2 * n - 1, 0, 1]));
        assert!(matches!(refused(&positions, facets), SurfaceError::InconsistentOrientation { .. }));
    }

    #[test]
    fn three_facets_at_an_edge_are_refused() {
        let mut positions = strip().0;
        positions.extend([[0.5, 0.5, 1.0], [0.5, 0.2, -1.0]]);
        let facets = vec![Facet::Triangle([0, 1, 4]), Facet::Triangle([1, 0, 6]), Facet::Triangle([0, 1, 7])];
        assert_eq!(
            refused(&positions, facets),
            SurfaceError::BranchingEdge { nodes: [0, 1], facets: [0, 1, 2] }
        );
    }
}
