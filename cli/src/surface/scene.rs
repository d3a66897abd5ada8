//! The picture: the slave surface with what was found at its nodes.

use std::path::Path;

use diffuse_contact::Point;
use diffuse_contact::interface::{ContactElement, Outcome};
use diffuse_contact_mesh::{ElementKind, VtuFile};

use super::legend;
use super::nodes::{SlaveNode, SlaveNodes};
use super::slaves::Surfaces;
use crate::error::CliError;
use crate::output;

/// Writes the file. Its arrays are described by [`legend::help`].
pub fn write(
    path: &Path,
    surfaces: &Surfaces,
    nodes: &SlaveNodes,
    element: ContactElement,
) -> Result<(), CliError> {
    let points: Vec<Point> = surfaces.slaves.iter().map(|&node| surfaces.mesh.nodes()[node]).collect();
    // Slaves are ascending, and every corner is one.
    let place = |node: &usize| surfaces.slaves.binary_search(node).unwrap_or_default();
    let facets = surfaces.slave_facets.iter().map(|facet| {
        let corners: Vec<usize> = facet.corners().iter().map(place).collect();
        let kind = if corners.len() == 3 { ElementKind::Triangle3 } else { ElementKind::Quadrilateral4 };
        (kind, corners)
    });
    let mut cells: Vec<(ElementKind, Vec<usize>)> = facets.collect();
    if !surfaces.has_areas {
        cells.extend((0..points.len()).map(|node| (ElementKind::Point1, vec![node])));
    }
    let scalars = |of: &dyn Fn(&SlaveNode) -> f64| -> Vec<f64> { nodes.nodes.iter().map(of).collect() };
    let vectors = |of: &dyn Fn(&SlaveNode) -> Point| -> Vec<Point> { nodes.nodes.iter().map(of).collect() };
    let integers = |of: &dyn Fn(&SlaveNode) -> i32| -> Vec<i32> { nodes.nodes.iter().map(of).collect() };
    let no_number = |node: &SlaveNode, number: f64| if node.outcome.is_contact() { number } else { f64::NAN };
    let degree = |outcome| match outcome {
        Outcome::Contact { fallback } => i32::from(element.degree(fallback)),
        Outcome::None(_) => 0,
    };
    let mut grid = VtuFile::new()
        .points(points)
        .cells(cells.iter().map(|(kind, nodes)| (*kind, nodes.as_slice())))
        .point_scalars("gap", scalars(&|node| no_number(node, node.point.gap)))
        .point_vectors("normal", vectors(&|node| node.point.normal))
        .point_vectors("foot", vectors(&|node| node.point.foot.map(|x| no_number(node, x))))
        .point_i32("outcome", integers(&|node| legend::number(node.outcome)))
        .point_i32("masters", integers(&|node| i32::try_from(node.masters).unwrap_or(i32::MAX)))
        .point_i32("basis", integers(&|node| degree(node.outcome)));
    if surfaces.has_areas {
        grid = grid.point_scalars("area", scalars(&|node| node.area));
    }
    output::write_vtu(path, &grid)
}
