//! Structured meshes of quadrilaterals.

use diffuse_contact::Point;
use diffuse_contact::surface::Facet;

/// Nodes and facets of a grid of cells.
pub struct Patch {
    /// Node (i, j) at i + j (columns + 1).
    pub positions: Vec<Point>,
    /// Counter-clockwise in (i, j): outside is where ∂x/∂i × ∂x/∂j points to.
    pub facets: Vec<Facet>,
}

impl Patch {
    /// So many columns and rows of cells, with node (i, j) at `position(i, j)`.
    pub fn new([columns, rows]: [usize; 2], position: impl Fn(f64, f64) -> Point) -> Self {
        let stride = columns + 1;
        let positions = (0..=rows).flat_map(|j| (0..=columns).map(move |i| [i, j]));
        let positions = positions.map(|[i, j]| position(i as f64, j as f64)).collect();
        let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| i + stride * j));
        let facets = cells.map(|k| Facet::Quadrilateral([k, k + 1, k + 1 + stride, k + stride])).collect();
        Self { positions, facets }
    }
}

#[cfg(test)]
mod tests {
    use diffuse_contact::surface::MasterSurface;

    use super::*;

    #[test]
    fn outside_is_up() {
        let patch = Patch::new([3, 2], |i, j| [i, j, 0.0]);
        let surface = MasterSurface::new(&patch.positions, patch.facets).unwrap();
        assert_eq!(
            (surface.nodes().len(), surface.facet_count(), surface.border_edges().count()),
            (12, 6, 10)
        );
        let normals = surface.node_normals(&patch.positions).unwrap();
        assert!(normals.iter().all(|normal| normal[2] > 0.0));
    }
}
