//! Planes of symmetry that the boundary conditions speak of and the interface does not name, and those that it names for nothing.

use std::collections::{BTreeMap, BTreeSet};

use diffuse_contact::Point;
use diffuse_contact::interface::ContactElement;
use diffuse_contact::neighbourhood::NeighbourRule;
use diffuse_contact::surface::{Facet, SymmetryPlane};

use super::{Integration, Interaction};
use crate::statics::Problem;

/// Nodes are in a plane when they are as near to it as this part of the master's extent; so is a plane that is named.
const ON_PLANE: f64 = 1e-6;

/// Sine of the angle between a facet and the perpendicular to a plane from which their mirror image makes another surface: half a degree.
const ASLANT: f64 = 0.01;

/// The line of the deck that names the planes of an interaction and those that its boundary conditions propose; `None` if they propose
/// none, or there are no nodal domains, which alone need them.
///
/// Proposed is a plane across an axis in which a border of the master lies whose nodes rest along this axis, if nothing that deforms is
/// beyond it. Clamped edges, whose nodes rest along all axes, are no sign of symmetry, and neither are those of rigid masters: there the
/// slave's nodes in the plane speak.
pub fn symmetry_line(interaction: &Interaction, problem: &Problem, deformable: &[bool]) -> Option<String> {
    let ContactElement::Diffuse { search, .. } = interaction.options().interface.element else { return None };
    if search.rule != NeighbourRule::Domains {
        return None;
    }
    let positions = problem.start_positions();
    let named = interaction.options().symmetry.iter().filter(|plane| !is_idle(plane, interaction, positions));
    let proposed = proposed(interaction, problem, deformable);
    let planes: Vec<String> = named.chain(&proposed).map(written).collect();
    (!proposed.is_empty()).then(|| format!("symmetry = [{}]", planes.join(", ")))
}

/// The planes of an interaction, as decks have them, in which no edge lies where its surfaces end.
pub fn idle_planes(interaction: &Interaction, positions: &[Point]) -> Vec<String> {
    let planes = interaction.options().symmetry.iter();
    planes.filter(|plane| is_idle(plane, interaction, positions)).map(written).collect()
}

/// The planes of an interaction across an axis, as decks have them, with how many of its deformable nodes in them nothing prescribes along
/// that axis: its mirror image would move the other way.
pub fn free_planes(
    interaction: &Interaction,
    problem: &Problem,
    deformable: &[bool],
) -> Vec<(String, usize)> {
    let positions = problem.start_positions();
    let prescribed = problem.supports().prescribed();
    let nodes: BTreeSet<usize> =
        interaction.facets().iter().flat_map(|facet| facet.corners()).copied().collect();
    let tolerance = ON_PLANE * extent(&nodes, positions);
    let of_plane = |plane: &SymmetryPlane| {
        let axis = (0..3).find(|&axis| plane.normal[axis].abs() > 1.0 - ON_PLANE)?;
        let is_free = |&&node: &&usize| {
            deformable[node] && !prescribed[node][axis] && height(plane, positions[node]).abs() <= tolerance
        };
        let count = nodes.iter().filter(is_free).count();
        (count > 0).then(|| (written(plane), count))
    };
    interaction.options().symmetry.iter().filter_map(of_plane).collect()
}

/// The planes across an axis in which the slave ends where boundary conditions are those of symmetry, as decks have them, but which a rigid
/// master crosses, so that they cannot be named. Over faces the slave's own smooth surface then ends there as at a border. Where it meets
/// the plane at right angles that makes no difference.
pub fn crossed_planes(interaction: &Interaction, problem: &Problem, deformable: &[bool]) -> Vec<String> {
    let options = interaction.options();
    let is_smooth = matches!(options.interface.element, ContactElement::Diffuse { .. });
    if options.integration == Integration::Nodes || options.self_contact || !is_smooth {
        return Vec::new();
    }
    let (positions, rests) = (problem.start_positions(), problem.supports().at_rest());
    let (slave, master) = interaction.sides();
    let nodes_of = |side: &[Facet]| -> BTreeSet<usize> {
        side.iter().flat_map(|facet| facet.corners()).copied().collect()
    };
    let (slaves, masters) = (nodes_of(slave), nodes_of(master));
    let tolerance = ON_PLANE * extent(&slaves, positions);
    let edges = edges(slave);
    let mut planes = Vec::new();
    for axis in 0..3 {
        let along = |node: usize| positions[node][axis];
        let all = slaves.iter().map(|&node| along(node));
        let [low, high] =
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        for (end, side) in [(low, 1.0), (high, -1.0)] {
            let is_in = |node: usize| (along(node) - end).abs() <= tolerance;
            let at_end = |facet: &&Facet| {
                let corners = facet.corners();
                let mut own = (0..corners.len()).map(|k| edge(corners[k], corners[(k + 1) % corners.len()]));
                own.any(|edge| edges[&edge] == 1 && edge.iter().all(|&node| is_in(node)))
            };
            let is_aslant = |facet: &Facet| slant(facet.corners(), positions, axis) > ASLANT;
            let mut in_plane = slaves.iter().copied().filter(|&node| is_in(node));
            let is_crossed = low < high
                && slave.iter().filter(at_end).any(is_aslant)
                && in_plane.clone().all(|node| deformable[node] && rests[node][axis])
                && in_plane.any(|node| rests[node] != [true; 3])
                && masters.iter().all(|&node| !deformable[node])
                && masters.iter().any(|&node| side * (along(node) - end) < -tolerance);
            if is_crossed {
                planes.push(written(&plane(axis, end, side, tolerance)));
            }
        }
    }
    planes
}

/// |n·e| of a facet's mean normal and an axis.
fn slant(corners: &[usize], positions: &[Point], axis: usize) -> f64 {
    let x = |k: usize| positions[corners[k % corners.len()]];
    let minus = |a: Point, b: Point| [0, 1, 2].map(|k| a[k] - b[k]);
    let [a, b] = if corners.len() == 3 {
        [minus(x(1), x(0)), minus(x(2), x(0))]
    } else {
        [minus(x(2), x(0)), minus(x(3), x(1))]
    };
    let normal = [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
    normal[axis].abs() / dot(normal, normal).sqrt()
}

fn edge(from: usize, to: usize) -> [usize; 2] {
    [from.min(to), from.max(to)]
}

/// How many facets each edge has.
fn edges(facets: &[Facet]) -> BTreeMap<[usize; 2], usize> {
    let mut edges = BTreeMap::new();
    for corners in facets.iter().map(|facet| facet.corners()) {
        for (k, &from) in corners.iter().enumerate() {
            *edges.entry(edge(from, corners[(k + 1) % corners.len()])).or_default() += 1;
        }
    }
    edges
}

/// How far from a plane a point lies, on the side of the model.
fn height(plane: &SymmetryPlane, x: Point) -> f64 {
    dot(plane.normal, [0, 1, 2].map(|axis| x[axis] - plane.point[axis]))
}

fn is_idle(plane: &SymmetryPlane, interaction: &Interaction, positions: &[Point]) -> bool {
    let edges = edges(interaction.facets());
    let border = || edges.iter().filter(|(_, facets)| **facets == 1).map(|(edge, _)| edge);
    let tolerance = ON_PLANE * extent(&border().flatten().copied().collect(), positions);
    let is_in = |&node: &usize| height(plane, positions[node]).abs() <= tolerance;
    !border().any(|edge| edge.iter().all(is_in))
}

fn dot(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn proposed(interaction: &Interaction, problem: &Problem, deformable: &[bool]) -> Vec<SymmetryPlane> {
    let positions = problem.start_positions();
    let rests = problem.supports().at_rest();
    let nodes: BTreeSet<usize> =
        interaction.facets().iter().flat_map(|facet| facet.corners()).copied().collect();
    let mut planes: Vec<SymmetryPlane> = Vec::new();
    for master in interaction.passes().map(|pass| pass.master()) {
        let border: Vec<[usize; 2]> = master.border_edges().collect();
        let border_nodes: BTreeSet<usize> = border.iter().flatten().copied().collect();
        for axis in 0..3 {
            let along = |node: usize| positions[node][axis];
            let all = master.nodes().iter().map(|&node| along(node as usize));
            let [low, high] =
                all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
            for (end, side) in [(low, 1.0), (high, -1.0)] {
                let tolerance = ON_PLANE * extent(&border_nodes, positions);
                let is_in = |node: usize| (along(node) - end).abs() <= tolerance;
                let is_beyond = |node: usize| side * (along(node) - end) < -tolerance && deformable[node];
                let edges = border.iter().filter(|edge| edge.iter().all(|&node| is_in(node)));
                let of_edges: BTreeSet<usize> = edges.flatten().copied().collect();
                let mut in_plane = nodes.iter().copied().filter(|&node| is_in(node) && deformable[node]);
                let is_proposed = low < high
                    && !of_edges.is_empty()
                    && of_edges.iter().all(|&node| rests[node][axis])
                    && in_plane.clone().all(|node| rests[node][axis])
                    && in_plane.any(|node| rests[node] != [true; 3])
                    && !nodes.iter().any(|&node| is_beyond(node));
                let plane = plane(axis, end, side, tolerance);
                let is_known = |other: &SymmetryPlane| is_same(other, &plane, tolerance);
                if is_proposed && !interaction.options().symmetry.iter().chain(&planes).any(is_known) {
                    planes.push(plane);
                }
            }
        }
    }
    planes
}

/// Largest extent along an axis, length.
fn extent(nodes: &BTreeSet<usize>, positions: &[Point]) -> f64 {
    let extent = |axis: usize| {
        let along = nodes.iter().map(|&node| positions[node][axis]);
        let ends = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        ends[1] - ends[0]
    };
    (0..3).map(extent).fold(0.0, f64::max)
}

/// The plane across an axis at this coordinate, with the model on the side of this sign.
fn plane(axis: usize, coordinate: f64, side: f64, tolerance: f64) -> SymmetryPlane {
    let mut point = [0.0; 3];
    point[axis] = if coordinate.abs() <= tolerance { 0.0 } else { coordinate };
    let mut normal = [0.0; 3];
    normal[axis] = side;
    SymmetryPlane { point, normal }
}

/// Whether two planes are one, whichever side the model is said to be on.
fn is_same(one: &SymmetryPlane, other: &SymmetryPlane, tolerance: f64) -> bool {
    dot(one.normal, other.normal).abs() > 1.0 - ON_PLANE && height(other, one.point).abs() <= tolerance
}

/// A plane as decks have it: the name of an axis where that says it.
fn written(plane: &SymmetryPlane) -> String {
    let name = (0..3).find(|&axis| *plane == SymmetryPlane::across(axis, [0.0; 3]));
    let vector = |[x, y, z]: Point| format!("[{x:?}, {y:?}, {z:?}]");
    name.map_or_else(
        || format!("{{ point = {}, normal = {} }}", vector(plane.point), vector(plane.normal)),
        |axis| format!("\"{}\"", ["x", "y", "z"][axis]),
    )
}
