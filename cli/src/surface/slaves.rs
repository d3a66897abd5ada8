//! Master surface and slave nodes of a mesh, ready for an interface.

use std::path::Path;

use diffuse_contact::interface::InterfaceError;
use diffuse_contact::surface::{Facet, SurfaceError, SymmetryPlane, tributary_areas};
use diffuse_contact_mesh::{self as mesh, Mesh, MeshError, PLATE_ON_CYLINDER};

use crate::contact_mesh::{ContactMeshError, SetArguments};
use crate::error::CliError;
use crate::input;

/// The name of the mesh that comes with the program, in messages and in the report.
const SHIPPED_NAME: &str = "plate_on_cylinder.msh (comes with the program)";

/// The two surfaces, in the mesh's numbering of the nodes.
pub struct Surfaces {
    /// File name of the mesh.
    pub name: String,
    /// The mesh.
    pub mesh: Mesh,
    /// Facets of the master set.
    pub master: Vec<Facet>,
    /// Slave nodes, ascending.
    pub slaves: Vec<usize>,
    /// Facets between slave nodes.
    pub slave_facets: Vec<Facet>,
    /// Whether every slave node is a corner of a slave facet, so that it has an area.
    pub has_areas: bool,
}

impl Surfaces {
    /// Reads a mesh file, or the mesh that comes with the program, and picks the two sets. A slave set of nodes alone has no facets.
    pub fn read(path: Option<&Path>, sets: &SetArguments) -> Result<Self, CliError> {
        let (name, mesh) = match path {
            Some(path) => {
                let (name, bytes) = input::read(path)?;
                let mesh = Mesh::from_bytes(&bytes, &name);
                (name, mesh)
            }
            None => (SHIPPED_NAME.to_owned(), Mesh::from_gmsh(PLATE_ON_CYLINDER, "plate_on_cylinder.msh")),
        };
        // The reader's own messages begin with the file, those about sets do not.
        let mesh = mesh.map_err(|reason| ContactMeshError::Mesh(reason.into()))?;
        let no_set = |reason: MeshError| ContactMeshError::Set { mesh: name.clone(), reason: reason.into() };
        let master = mesh.facets(&sets.master).map_err(no_set)?.iter().map(facet_of).collect();
        let slaves = mesh.nodes_of(&sets.slave).map_err(no_set)?;
        let is_slave = |node: &usize| slaves.binary_search(node).is_ok();
        let slave_facets: Vec<Facet> = mesh
            .facets(&sets.slave)
            .unwrap_or_default()
            .iter()
            .filter(|facet| facet.nodes().iter().all(is_slave))
            .map(facet_of)
            .collect();
        let mut is_corner = vec![false; mesh.nodes().len()];
        for &node in slave_facets.iter().flat_map(Facet::corners) {
            is_corner[node] = true;
        }
        let has_areas = slaves.iter().all(|&node| is_corner[node]);
        Ok(Self { name, mesh, master, slaves, slave_facets, has_areas })
    }

    /// What the master set is refused for.
    pub fn master_error(&self, set: &str, error: SurfaceError) -> CliError {
        self.error(set, self.surface_sentence(&self.master, error))
    }

    /// Root of the mean area of the master's facets, length.
    pub fn master_size(&self) -> f64 {
        let areas = tributary_areas(self.mesh.nodes(), &self.master);
        let total: f64 = areas.unwrap_or_default().into_iter().sum();
        (total / self.master.len().max(1) as f64).sqrt()
    }

    /// What the interface is refused for when its master gets these planes.
    pub fn symmetry_error(
        &self,
        sets: &SetArguments,
        planes: &[SymmetryPlane],
        error: InterfaceError,
    ) -> CliError {
        let InterfaceError::Surface(error) = error else { return self.interface_error(sets, error) };
        let SurfaceError::CutBySymmetry { plane, low, high } = error else {
            return self.master_error(&sets.master, error);
        };
        let axis =
            planes[plane].normal.iter().position(|&x| x != 0.0).map_or("?", |axis| ["x", "y", "z"][axis]);
        let sentence = format!(
            "the surface reaches from {axis} = {low} to {high}: with the plane of symmetry {axis} = 0 it has to lie on one side of it"
        );
        self.error(&sets.master, sentence)
    }

    /// What the interface is refused for.
    pub fn interface_error(&self, sets: &SetArguments, error: InterfaceError) -> CliError {
        let tag = |node: usize| self.mesh.node_tags()[node];
        let sentence = match error {
            InterfaceError::Surface(error) => self.surface_sentence(&self.slave_facets, error),
            InterfaceError::SlaveOnMaster { node } => {
                format!("node {} belongs to the set \"{}\", too", tag(node), sets.master)
            }
            InterfaceError::SlaveBehindSymmetry { node, distance, .. } => {
                let (node, master) = (tag(node), &sets.master);
                format!(
                    "node {node} lies {distance} behind a plane of symmetry, seen from the set \"{master}\""
                )
            }
            InterfaceError::HeldFrame => {
                let rule = "--frame-derivative held needs another --rule than domains, such as hull-layers";
                return ContactMeshError::Options(rule).into();
            }
            InterfaceError::NoSymmetry => {
                return ContactMeshError::Options("--symmetry needs --rule domains").into();
            }
            other => other.to_string(),
        };
        self.error(&sets.slave, sentence)
    }

    fn error(&self, set: &str, reason: String) -> CliError {
        ContactMeshError::Interface { mesh: self.name.clone(), set: set.to_owned(), reason }.into()
    }

    /// The library's statement, with facets and nodes named as in the file.
    fn surface_sentence(&self, facets: &[Facet], error: SurfaceError) -> String {
        let tag = |node: usize| self.mesh.node_tags()[node];
        let tags = |facet: usize| {
            let tags: Vec<String> =
                facets[facet].corners().iter().map(|&node| tag(node).to_string()).collect();
            tags.join(", ")
        };
        let corners = |facet: usize| format!("the facet with the nodes {}", tags(facet));
        // Its number in the set, from 1, tells a facet from another with the same nodes.
        let numbered = |facet: usize| format!("{} (nodes {})", facet + 1, tags(facet));
        match error {
            SurfaceError::NoArea { facet, .. } => format!("{} has no area", corners(facet)),
            SurfaceError::NotCyclic { facet, order } => {
                let order = order.map(|node| tag(node).to_string()).join(", ");
                format!("{} crosses itself: a cyclic order of them is {order}", corners(facet))
            }
            SurfaceError::NotConvex { facet, node, .. } => {
                format!("{} is not convex at node {}: split it into triangles", corners(facet), tag(node))
            }
            SurfaceError::RepeatedNode { facet, node } => {
                format!("{} has node {} for two of its corners", corners(facet), tag(node))
            }
            SurfaceError::BranchingEdge { nodes: [a, b], facets: [one, two, three] } => format!(
                "facets {}, {} and {}, and perhaps more, share the edge between the nodes {} and {}",
                numbered(one),
                numbered(two),
                numbered(three),
                tag(a),
                tag(b)
            ),
            SurfaceError::InconsistentOrientation { nodes: [a, b], facets: [one, two] } => format!(
                "facets {} and {} run through the edge from node {} to node {} in the same direction: one of them is \
                 flipped, or there twice",
                numbered(one),
                numbered(two),
                tag(a),
                tag(b)
            ),
            SurfaceError::NonFinitePosition { node, value } => {
                format!("node {} has the coordinate {value:e}, beyond 1e75", tag(node))
            }
            other => other.to_string(),
        }
    }
}

/// A facet of a mesh as one of a surface.
fn facet_of(facet: &mesh::Facet) -> Facet {
    match *facet {
        mesh::Facet::Triangle(corners) => Facet::Triangle(corners),
        mesh::Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners),
    }
}
