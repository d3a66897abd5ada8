//! The two surfaces of the demonstration, with the nodes of the master surface alone.

use diffuse_contact::pairing::{NearestNodes, node_normals};
use diffuse_contact::{Basis, ElementError, Point};
use diffuse_contact_mesh::Facet;

use crate::args::DemoArguments;
use crate::contact_mesh::ContactMesh;
use crate::error::CliError;

/// Master facets and slave nodes.
pub struct Surfaces {
    /// File name of the mesh.
    pub mesh: String,
    /// Name of the master set.
    pub master_set: String,
    /// Name of the slave set.
    pub slave_set: String,
    /// Nodes of the master facets, in a tree.
    pub master: NearestNodes,
    /// The master facets, as indices into the master nodes.
    pub facets: Vec<Facet>,
    /// Outward normals of the master nodes, as long as the area they belong to.
    pub normals: Vec<Point>,
    /// Slave nodes.
    pub slaves: Vec<Point>,
}

/// Reads the mesh and picks the two sets.
pub fn read(arguments: &DemoArguments) -> Result<Surfaces, CliError> {
    let sets = &arguments.sets;
    let ContactMesh { name, mesh, facets, slaves } = ContactMesh::read(arguments.mesh.as_deref(), sets)?;
    let no_surface =
        |reason: ElementError| CliError::Surface { mesh: name.clone(), set: sets.master.clone(), reason };
    let (points, facets) = renumbered(mesh.nodes(), &facets);
    let needed = Basis::Quadratic.size();
    if points.len() < needed {
        return Err(no_surface(ElementError::TooFewNodes { found: points.len(), needed }));
    }
    let corners: Vec<&[usize]> = facets.iter().map(Facet::nodes).collect();
    let normals = node_normals(&points, &corners);
    let master = NearestNodes::new(points).map_err(no_surface)?;
    Ok(Surfaces {
        master_set: sets.master.clone(),
        slave_set: sets.slave.clone(),
        master,
        normals,
        slaves: slaves.into_iter().map(|node| mesh.nodes()[node]).collect(),
        facets,
        mesh: name,
    })
}

/// The nodes the facets use, in the order of the mesh, and the facets in terms of them.
fn renumbered(nodes: &[Point], facets: &[Facet]) -> (Vec<Point>, Vec<Facet>) {
    let mut index = vec![None; nodes.len()];
    for &node in facets.iter().flat_map(Facet::nodes) {
        index[node] = Some(0);
    }
    let mut points = Vec::new();
    for (new, &point) in index.iter_mut().zip(nodes) {
        if let Some(new) = new {
            *new = points.len();
            points.push(point);
        }
    }
    let new = |node: usize| index[node].unwrap_or_default();
    let facets = facets
        .iter()
        .map(|facet| match *facet {
            Facet::Triangle(corners) => Facet::Triangle(corners.map(new)),
            Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(new)),
        })
        .collect();
    (points, facets)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_nodes_of_the_facets_are_kept() {
        let nodes: Vec<Point> = (0..6).map(|k| [f64::from(k), 0.0, 0.0]).collect();
        let (points, facets) = renumbered(&nodes, &[Facet::Triangle([5, 1, 3])]);
        assert_eq!(points, [nodes[1], nodes[3], nodes[5]]);
        assert_eq!(facets, [Facet::Triangle([2, 0, 1])]);
    }
}
