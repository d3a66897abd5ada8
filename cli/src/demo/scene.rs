//! The picture: slave nodes, master facets and smooth surface in one VTU file.
//!
//! Points and cells carry `part`: 0 slave nodes, 1 master facets, 2 smooth surface. Points carry besides
//!
//! | array | slave nodes | master facets | smooth surface |
//! | --- | --- | --- | --- |
//! | `gap` | signed gap g | height of the node over the smooth surface | 0 |
//! | `normal` | unit normal of the smooth surface at the foot | unit normal of the facets around | unit normal |
//! | `outcome` | number of [`legend`] | the same, of its height | 0 |
//! | `masters` | number of master nodes | 0 | 0 |
//! | `facet_height` | 0 | height of the node over the smooth surface | height of the facet over this point |
//!
//! Where there is no gap or height (its outcome says why), the number is NaN and the normal zero.

use std::path::Path;

use diffuse_contact::Point;
use diffuse_contact::surface::Facet;
use diffuse_contact_mesh::{ElementKind, VtuFile};

use super::picture::unit;
use super::sampling::{Sample, SmoothSurface};
use crate::error::CliError;
use crate::output;
use crate::surface::legend;
use crate::surface::nodes::{SlaveNode, SlaveNodes};
use crate::surface::slaves::Surfaces;

/// The number of contact.
const CONTACT: i32 = 0;

/// `part` of the slave nodes.
const SLAVE_NODES: i32 = 0;
/// `part` of the master facets.
const FACETS: i32 = 1;
/// `part` of the smooth surface.
const SMOOTH: i32 = 2;

/// Writes the file.
pub fn write(
    path: &Path,
    surfaces: &Surfaces,
    nodes: &SlaveNodes,
    smooth: &SmoothSurface,
) -> Result<(), CliError> {
    let mut scene = Scene::default();
    for (&node, found) in surfaces.slaves.iter().zip(&nodes.nodes) {
        scene.add_slave_node(surfaces.mesh.nodes()[node], found);
    }
    scene.add_facets(surfaces, smooth);
    scene.add_smooth_surface(smooth);
    output::write_vtu(path, &scene.grid())
}

/// The arrays of the file, point by point and cell by cell.
#[derive(Default)]
struct Scene {
    points: Vec<Point>,
    gap: Vec<f64>,
    normal: Vec<Point>,
    outcome: Vec<i32>,
    masters: Vec<i32>,
    facet_height: Vec<f64>,
    part: Vec<i32>,
    cells: Vec<(ElementKind, Vec<usize>)>,
    cell_part: Vec<i32>,
}

impl Scene {
    fn add_slave_node(&mut self, position: Point, node: &SlaveNode) {
        let vertex = self.points.len();
        self.points.push(position);
        self.gap.push(if node.outcome.is_contact() { node.point.gap } else { f64::NAN });
        self.normal.push(node.point.normal);
        self.outcome.push(legend::number(node.outcome));
        self.masters.push(i32::try_from(node.masters).unwrap_or(i32::MAX));
        self.facet_height.push(0.0);
        self.part.push(SLAVE_NODES);
        self.cells.push((ElementKind::Point1, vec![vertex]));
        self.cell_part.push(SLAVE_NODES);
    }

    fn add_facets(&mut self, surfaces: &Surfaces, smooth: &SmoothSurface) {
        let first = self.points.len();
        let nodes = smooth.nodes.iter().zip(&smooth.node_normals).zip(&smooth.node_heights);
        for ((&node, &normal), height) in nodes {
            self.points.push(surfaces.mesh.nodes()[node]);
            // Zero stays zero.
            self.normal.push(unit(normal).unwrap_or(normal));
            let value = height.unwrap_or(f64::NAN);
            self.gap.push(value);
            self.facet_height.push(value);
            self.outcome.push(height.err().map_or(CONTACT, legend::number));
            self.masters.push(0);
            self.part.push(FACETS);
        }
        let place = |node: &usize| smooth.nodes.partition_point(|other| other < node);
        self.add_cells(&surfaces.master, |node| first + place(node), FACETS);
    }

    fn add_smooth_surface(&mut self, smooth: &SmoothSurface) {
        let first = self.points.len();
        for &Sample { position, normal, facet_height } in &smooth.samples {
            self.points.push(position);
            self.normal.push(normal);
            self.gap.push(0.0);
            self.facet_height.push(facet_height);
            self.outcome.push(CONTACT);
            self.masters.push(0);
            self.part.push(SMOOTH);
        }
        self.add_cells(&smooth.pieces, |point| first + point, SMOOTH);
    }

    fn add_cells(&mut self, facets: &[Facet], place: impl Fn(&usize) -> usize, part: i32) {
        for facet in facets {
            let kind = match facet {
                Facet::Triangle(_) => ElementKind::Triangle3,
                Facet::Quadrilateral(_) => ElementKind::Quadrilateral4,
            };
            self.cells.push((kind, facet.corners().iter().map(&place).collect()));
            self.cell_part.push(part);
        }
    }

    fn grid(&self) -> VtuFile<'_> {
        VtuFile::new()
            .points(&self.points)
            .cells(self.cells.iter().map(|(kind, nodes)| (*kind, nodes.as_slice())))
            .point_scalars("gap", &self.gap)
            .point_vectors("normal", &self.normal)
            .point_i32("outcome", &self.outcome)
            .point_i32("masters", &self.masters)
            .point_scalars("facet_height", &self.facet_height)
            .point_i32("part", &self.part)
            .cell_i32("part", &self.cell_part)
    }
}
