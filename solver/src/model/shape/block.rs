//! A box.

use diffuse_contact_mesh::ElementKind;

use super::grading::graded_steps;
use super::lattice::{HexLattice, steps};
use super::{divisions, in_range, length, ratio};
use crate::model::{Part, ShapeError};

/// A box along the axes, also a plate. Faces: `x-`, `x+`, `y-`, `y+`, `z-`, `z+`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Corner with the smallest coordinates, length.
    pub origin: [f64; 3],
    /// Edges along x, y, z, length.
    pub size: [f64; 3],
    /// Cells along x, y, z.
    pub divisions: [usize; 3],
    /// Along each axis the size of the last cell over that of the first.
    pub grading: [f64; 3],
}

impl Block {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        for value in self.origin {
            in_range(value.abs() <= super::MAX_LENGTH, "origin", "finite (up to 1e50)", value)?;
        }
        self.size.into_iter().try_for_each(|value| length("size", value))?;
        self.grading.into_iter().try_for_each(|value| ratio("grading", value))?;
        divisions(&self.divisions, self.divisions.iter().map(|&n| n as f64 + 1.0).product())
    }

    /// Its mesh of elements of a kind, tetrahedra or hexahedra; a cell is six tetrahedra.
    pub fn part(&self, kind: ElementKind) -> Result<Part, ShapeError> {
        self.check()?;
        let steps = steps(kind);
        let ends: [Vec<f64>; 3] =
            std::array::from_fn(|axis| graded_steps(self.divisions[axis], self.grading[axis], steps));
        let position = |at: [usize; 3]| {
            std::array::from_fn(|axis| self.origin[axis] + self.size[axis] * ends[axis][at[axis]])
        };
        let lattice = HexLattice { cells: self.divisions, cyclic: false, kind };
        Ok(lattice.part(position, [["x-", "x+"], ["y-", "y+"], ["z-", "z+"]]))
    }
}
