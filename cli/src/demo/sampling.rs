//! The smooth surface, sampled finely: every facet is subdivided, and every point of the subdivision is taken for a
//! slave node of its own and moved to its foot.

use std::collections::BTreeMap;

use diffuse_contact::interface::{ContactInterface, Contacts, InterfaceOptions, Outcome};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

use crate::contact_mesh::SetArguments;
use crate::error::CliError;
use crate::surface::slaves::Surfaces;

/// Pieces along each side of a facet, …
const FINEST: usize = 6;
/// … fewer, but at least this many, on meshes so large that …
const COARSEST: usize = 2;
/// … the pieces would outnumber this.
const MOST_PIECES: usize = 100_000;
/// A point of the smooth surface.
#[derive(Clone, Copy)]
pub struct Sample {
    /// Its position.
    pub position: Point,
    /// Unit normal of the smooth surface.
    pub normal: Point,
    /// Signed height of the facet over the smooth surface at this point.
    pub facet_height: f64,
}

/// The smooth surface as a fine mesh.
pub struct SmoothSurface {
    /// Its points, each once also where facets meet.
    pub samples: Vec<Sample>,
    /// Pieces between them.
    pub pieces: Vec<Facet>,
    /// Nodes of the master surface, ascending.
    pub nodes: Vec<usize>,
    /// Their normals on the facets, not normalised.
    pub node_normals: Vec<Point>,
    /// Signed height of each over the smooth surface, or what became of it.
    pub node_heights: Vec<Result<f64, Outcome>>,
    /// Points left out because they have no foot, with the pieces at them.
    pub left_out: usize,
    /// Pieces along each side of a facet.
    pub subdivisions: usize,
}

/// Samples the smooth surface over all master facets.
pub fn sample(
    surfaces: &Surfaces,
    sets: &SetArguments,
    options: InterfaceOptions,
) -> Result<SmoothSurface, CliError> {
    let nodes = surfaces.mesh.nodes();
    let refused = |error| surfaces.interface_error(sets, error);
    let master = MasterSurface::new(nodes, surfaces.master.clone())
        .map_err(|error| surfaces.master_error(&sets.master, error))?;
    let master_nodes: Vec<usize> = master.nodes().iter().map(|&node| node as usize).collect();
    let node_normals =
        master.node_normals(nodes).map_err(|error| surfaces.master_error(&sets.master, error))?;
    let subdivisions = subdivisions(surfaces.master.len());
    let lattice = Lattice::new(&surfaces.master, subdivisions);
    let flat: Vec<Point> = lattice.points.iter().map(|mixture| mixture.position(nodes)).collect();
    let mut positions: Vec<Point> = nodes.iter().chain(&flat).copied().collect();
    let slaves = (nodes.len()..positions.len()).collect();
    let options = options.with_areas(false);
    let mut interface = ContactInterface::new(master, slaves, &[], &positions, options).map_err(refused)?;
    interface.refresh_pairing(&positions).map_err(refused)?;
    // The smooth surface is where a point is its own foot: the first projection starts from the facet, the second from so close that
    // a third would not show.
    let first = projections(interface.evaluate(Mode::Value).map_err(refused)?);
    for (position, found) in positions[nodes.len()..].iter_mut().zip(&first) {
        *position = found.map_or(*position, |(foot, _)| foot);
    }
    interface.update(&positions).map_err(refused)?;
    let second = projections(interface.evaluate(Mode::Value).map_err(refused)?);
    let mut found = SmoothSurface {
        samples: Vec::with_capacity(flat.len()),
        pieces: Vec::new(),
        node_heights: vec![Ok(0.0); master_nodes.len()],
        nodes: master_nodes,
        node_normals,
        left_out: 0,
        subdivisions,
    };
    let mut index = Vec::with_capacity(flat.len());
    for ((mixture, &point), (first, second)) in
        lattice.points.iter().zip(&flat).zip(first.into_iter().zip(second))
    {
        // At a border the second projection may end beyond it.
        let sample = first.map(|first| sample_at(point, second.unwrap_or(first)));
        if let Some(node) = mixture.node() {
            let place = found.nodes.partition_point(|&other| other < node);
            found.node_heights[place] = sample.map(|sample| sample.facet_height);
        }
        index.push(sample.is_ok().then_some(found.samples.len()));
        found.left_out += usize::from(sample.is_err());
        found.samples.extend(sample);
    }
    let pieces = lattice.pieces.iter().filter_map(|piece| {
        let corners: Option<Vec<usize>> = piece.corners().iter().map(|&point| index[point]).collect();
        facet_of(&corners?)
    });
    found.pieces = pieces.collect();
    Ok(found)
}

/// Foot and normal of each slave, or what became of it.
fn projections(contacts: &Contacts) -> Vec<Result<(Point, Point), Outcome>> {
    let found = contacts.iter().map(|contact| match contact.outcome {
        Outcome::Contact { .. } => Ok((contact.point.foot, contact.point.normal)),
        none @ Outcome::None(_) => Err(none),
    });
    found.collect()
}

fn sample_at(facet_point: Point, (position, normal): (Point, Point)) -> Sample {
    let facet_height = (0..3).map(|k| (facet_point[k] - position[k]) * normal[k]).sum();
    Sample { position, normal, facet_height }
}

/// A facet with three or four corners.
fn facet_of(corners: &[usize]) -> Option<Facet> {
    match *corners {
        [a, b, c] => Some(Facet::Triangle([a, b, c])),
        [a, b, c, d] => Some(Facet::Quadrilateral([a, b, c, d])),
        _ => None,
    }
}

fn subdivisions(facets: usize) -> usize {
    (COARSEST..=FINEST).rev().find(|side| facets * side * side <= MOST_PIECES).unwrap_or(COARSEST)
}

/// A point of a facet: a mixture of its corners in whole parts of subdivisions². Where facets meet, both describe a
/// point by the same mixture, so the fine mesh has no cracks.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Mixture(Vec<(usize, usize)>);

impl Mixture {
    fn new(corners: &[usize], parts: &[usize]) -> Self {
        let mut mixture: Vec<_> = corners.iter().copied().zip(parts.iter().copied()).collect();
        mixture.retain(|(_, parts)| *parts > 0);
        mixture.sort_unstable();
        Self(mixture)
    }

    /// The node this point is, unless it lies between nodes.
    fn node(&self) -> Option<usize> {
        if let [(node, _)] = self.0[..] { Some(node) } else { None }
    }

    fn position(&self, nodes: &[Point]) -> Point {
        let total: usize = self.0.iter().map(|(_, parts)| parts).sum();
        [0, 1, 2].map(|k| {
            let sum: f64 = self.0.iter().map(|&(node, parts)| parts as f64 * nodes[node][k]).sum();
            sum / total as f64
        })
    }
}

/// All points of the subdivided facets and the pieces between them.
struct Lattice {
    points: Vec<Mixture>,
    pieces: Vec<Facet>,
}

impl Lattice {
    fn new(facets: &[Facet], subdivisions: usize) -> Self {
        let mut points = BTreeMap::new();
        let mut pieces = Vec::new();
        for facet in facets {
            match facet {
                Facet::Triangle(corners) => {
                    subdivide_triangle(corners, subdivisions, &mut points, &mut pieces)
                }
                Facet::Quadrilateral(corners) => {
                    subdivide_quadrilateral(corners, subdivisions, &mut points, &mut pieces);
                }
            }
        }
        // Numbers were given in the order of first use; put the points in that order.
        let mut points: Vec<(Mixture, usize)> = points.into_iter().collect();
        points.sort_unstable_by_key(|(_, number)| *number);
        Self { points: points.into_iter().map(|(mixture, _)| mixture).collect(), pieces }
    }
}

/// Number of a point, a new one if it has none.
fn number(points: &mut BTreeMap<Mixture, usize>, mixture: Mixture) -> usize {
    let next = points.len();
    *points.entry(mixture).or_insert(next)
}

fn subdivide_quadrilateral(
    corners: &[usize; 4],
    side: usize,
    points: &mut BTreeMap<Mixture, usize>,
    pieces: &mut Vec<Facet>,
) {
    let mut at = |i: usize, j: usize| {
        let parts = [(side - i) * (side - j), i * (side - j), i * j, (side - i) * j];
        number(points, Mixture::new(corners, &parts))
    };
    for j in 0..side {
        for i in 0..side {
            pieces.push(Facet::Quadrilateral([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
        }
    }
}

fn subdivide_triangle(
    corners: &[usize; 3],
    side: usize,
    points: &mut BTreeMap<Mixture, usize>,
    pieces: &mut Vec<Facet>,
) {
    let mut at = |i: usize, j: usize| {
        let parts = [(side - i - j) * side, i * side, j * side];
        number(points, Mixture::new(corners, &parts))
    };
    for j in 0..side {
        for i in 0..side - j {
            pieces.push(Facet::Triangle([at(i, j), at(i + 1, j), at(i, j + 1)]));
            if i + j + 1 < side {
                pieces.push(Facet::Triangle([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_that_meet_share_their_points() {
        // A quadrilateral and a triangle with one side in common, each with three pieces along a side.
        let facets = [Facet::Quadrilateral([0, 1, 2, 3]), Facet::Triangle([2, 1, 4])];
        let lattice = Lattice::new(&facets, 3);
        assert_eq!(lattice.points.len(), 16 + 10 - 4);
        assert_eq!(lattice.pieces.len(), 9 + 9);
    }

    #[test]
    fn the_pieces_cover_the_facet_in_its_sense() {
        let nodes = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        for (facet, area) in [(Facet::Quadrilateral([0, 1, 2, 3]), 2.0), (Facet::Triangle([0, 1, 2]), 1.0)] {
            let lattice = Lattice::new(&[facet], 5);
            let points: Vec<Point> = lattice.points.iter().map(|mixture| mixture.position(&nodes)).collect();
            let sum: f64 = lattice.pieces.iter().map(|piece| signed_area(piece.corners(), &points)).sum();
            assert!((sum - area).abs() < 1e-14, "{facet:?}: {sum}");
            assert!(lattice.pieces.iter().all(|piece| signed_area(piece.corners(), &points) > 0.0));
        }
    }

    fn signed_area(corners: &[usize], points: &[Point]) -> f64 {
        let next = corners.iter().cycle().skip(1);
        corners
            .iter()
            .zip(next)
            .map(|(&i, &j)| 0.5 * (points[i][0] * points[j][1] - points[j][0] * points[i][1]))
            .sum()
    }

    #[test]
    fn large_meshes_are_sampled_more_coarsely() {
        assert_eq!(subdivisions(100), FINEST);
        assert_eq!(subdivisions(10_000), 3);
        assert_eq!(subdivisions(10_000_000), COARSEST);
    }
}
