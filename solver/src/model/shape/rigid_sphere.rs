//! A rigid sphere.

use diffuse_contact_mesh::ElementKind;

use super::ball::lattice;
use super::cylinder::{opposite, round_point};
use super::grading::{graded, mirrored};
use super::rigid::{Facets, Side, finished};
use super::{HalfSpace, kept, length, ratio, rigid_divisions};
use crate::model::{Part, ShapeError};

/// A sphere around the origin, whole or cut: the six faces of a cube, bulged. Node sets: `x0`, `y0`, `z0` where it is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidSphere {
    /// Radius, length.
    pub radius: f64,
    /// What is left of it.
    pub keep: Vec<HalfSpace>,
    /// Cells from the middle of a face of the cube to its edge: an eighth of a turn.
    pub divisions: usize,
    /// Along x, y, z: the size of the last cell over that at the middle.
    pub grading: [f64; 3],
    /// Triangles or quadrilaterals.
    pub facets: Facets,
    /// Which side is touched.
    pub side: Side,
}

impl RigidSphere {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        length("radius", self.radius)?;
        self.grading.into_iter().try_for_each(|value| ratio("grading", value))?;
        opposite(&self.keep)?;
        rigid_divisions(&[self.divisions], self.node_count())
    }

    /// The nodes of the cube's faces: all of the cube's but those within, one axis after the other.
    fn node_count(&self) -> f64 {
        let n = self.divisions as f64;
        let is_cut = |axis| kept(&self.keep, axis, 1).1;
        let all = [0, 1, 2].map(|axis| if is_cut(axis) { n + 1.0 } else { 2.0 * n + 1.0 });
        let within = [0, 1, 2].map(|axis| if is_cut(axis) { n } else { 2.0 * n - 1.0 });
        let faces = [0, 1, 2].map(|axis| if is_cut(axis) { 1.0 } else { 2.0 });
        faces[0] * all[1] * all[2] + within[0] * (faces[1] * all[2] + within[1] * faces[2])
    }

    /// Its mesh.
    pub fn part(&self) -> Result<Part, ShapeError> {
        self.check()?;
        let cells = self.grading.map(|ratio| graded(self.divisions, ratio));
        let (part, places) = lattice(ElementKind::Hexahedron8, self.divisions, 0, &self.keep).rim(|at| {
            let cube = std::array::from_fn(|axis| mirrored(&cells[axis], at[axis]));
            round_point::<3>(cube, 1.0, 1.0).map(|x| self.radius * x)
        });
        let mut part = finished(part, self.facets, self.side);
        for axis in 0..3 {
            if kept(&self.keep, axis, 1).1 {
                part.name_face(["x0", "y0", "z0"][axis], &[], |node| places[node][axis] == 0);
            }
        }
        Ok(part)
    }
}
