//! The faceted surfaces of a contact: what is checked once, where the closest facet is, and where the surface ends.
//!
//! A [`MasterSurface`] is the connectivity of triangles and bilinear quadrilaterals, corners counter-clockwise
//! seen from outside. It holds no positions: everything geometric is asked of a [`SurfaceIndex`], made from the
//! positions of the moment with [`MasterSurface::at`].
//!
//! * [`SurfaceIndex::closest`]: the closest point of the surface for any grading, ties decided by a rule; exact
//!   on triangles and plane quadrilaterals, on warped ones the best of the edges and of the foot found from the middle.
//! * Crossing an edge: two facets belong to one sheet if the angle between their normals does not exceed the
//!   feature angle. What lies beyond a sharper edge, or on the far face of a thin plate, takes no part in a fit.
//! * Border: a point is beyond the border if the closest point of the surface lies on an edge that ends the
//!   sheet, and the point lies farther out than that in the plane of the facet.
//! * [`window`]: what some slaves can need of a surface, where nobody holds the whole.
//! * [`tributary_areas`]: the area that belongs to each slave node.
//!
//! ```
//! use diffuse_contact::surface::{Facet, MasterSurface};
//!
//! // Two squares side by side in the plane z = 0, outside above.
//! let positions =
//!     [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [2.0, 1.0, 0.0]];
//! let facets = vec![Facet::Quadrilateral([0, 1, 4, 3]), Facet::Quadrilateral([1, 2, 5, 4])];
//! let surface = MasterSurface::new(&positions, facets)?;
//! assert_eq!(surface.border_edges().count(), 6);
//!
//! let closest = surface.at(&positions)?.closest([1.5, 0.25, 0.5]).expect("a finite point");
//! assert_eq!((closest.facet, closest.distance, closest.on_border), (1, 0.5, false));
//! # Ok::<(), diffuse_contact::surface::SurfaceError>(())
//! ```

mod area;
mod auxiliary;
mod border;
mod cells;
mod checks;
mod conditioning;
mod domains;
mod error;
mod extents;
mod fits;
mod index;
mod lists;
mod own;
mod shape;
mod sheet_nodes;
mod sheets;
mod symmetry;
mod topology;
mod trim;
mod walk;
pub mod window;

pub use area::tributary_areas;
pub use error::SurfaceError;
pub use index::{ClosestPoint, SurfaceIndex};
pub use symmetry::SymmetryPlane;
pub use topology::MasterSurface;
pub use window::{Window, WindowError};

pub(crate) use auxiliary::between;
pub(crate) use border::{BorderScratch, Creases};
pub(crate) use checks::{check_facets, check_position};
pub(crate) use domains::{NodalDomains, grown};
pub(crate) use fits::Demands;
pub(crate) use index::Closest;
pub(crate) use lists::still_listed;
pub(crate) use own::{OwnSurface, connected_parts};
pub(crate) use shape::{Foot, Shape, shape_of};
pub(crate) use sheet_nodes::SheetNodes;
pub(crate) use sheets::{Carried, Listed, Sheets};
pub(crate) use symmetry::{Image, Symmetry};
pub(crate) use topology::NONE;
pub(crate) use trim::{Ratios, trimmed};
pub(crate) use walk::Walk;

/// One facet of a surface: indices of its corners in the positions of all nodes, counter-clockwise seen from
/// outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Facet {
    /// A plane triangle.
    Triangle([usize; 3]),
    /// A bilinear quadrilateral, plane or not.
    Quadrilateral([usize; 4]),
}

impl Facet {
    /// The corners in their order.
    pub const fn corners(&self) -> &[usize] {
        match self {
            Self::Triangle(corners) => corners,
            Self::Quadrilateral(corners) => corners,
        }
    }

    /// The same facet seen from its other side; the first corner stays the first.
    #[must_use]
    pub const fn flipped(self) -> Self {
        match self {
            Self::Triangle([a, b, c]) => Self::Triangle([a, c, b]),
            Self::Quadrilateral([a, b, c, d]) => Self::Quadrilateral([a, d, c, b]),
        }
    }
}

/// Ascending, each once.
pub(crate) fn sort<T: Ord>(numbers: &mut Vec<T>) {
    numbers.sort_unstable();
    numbers.dedup();
}

impl AsRef<[usize]> for Facet {
    fn as_ref(&self) -> &[usize] {
        self.corners()
    }
}
