//! A pipe, whole or a sector.

use diffuse_contact_mesh::ElementKind;

use super::grading::graded_steps;
use super::lattice::{HexLattice, steps};
use super::{Axis, arc, divisions, in_range, length, ratio, turn};
use crate::model::motion::sine_cosine;
use crate::model::{Part, ShapeError};

/// A pipe around a coordinate axis, from 0 to `length` along it. Angles begin at the next axis and grow towards the one after
/// it: from x towards y for a pipe along z, from y towards z along x, from z towards x along y.
///
/// Faces: `inner`, `outer`, `bottom` (at 0 along the axis), `top`, and of a sector `start` and `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pipe {
    /// Its axis.
    pub axis: Axis,
    /// Inner radius, length.
    pub inner_radius: f64,
    /// Outer radius, length.
    pub outer_radius: f64,
    /// First and last angle, degrees; 360 apart is a whole pipe.
    pub angles: [f64; 2],
    /// Extent along the axis, length.
    pub length: f64,
    /// Cells around, through the wall, along.
    pub divisions: [usize; 3],
    /// Around, through the wall, along: the size of the last cell over that of the first. A whole pipe is not graded around.
    pub grading: [f64; 3],
}

impl Pipe {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        length("inner_radius", self.inner_radius)?;
        length("outer_radius", self.outer_radius)?;
        in_range(
            self.outer_radius > self.inner_radius,
            "outer_radius",
            "above inner_radius",
            self.outer_radius,
        )?;
        length("length", self.length)?;
        let whole = turn("angles", self.angles)?;
        self.grading.into_iter().try_for_each(|value| ratio("grading", value))?;
        in_range(!whole || self.grading[0] == 1.0, "grading", "1 around a whole pipe", self.grading[0])?;
        arc("angles", self.angles, self.divisions[0])?;
        divisions(&self.divisions, self.divisions.iter().map(|&n| n as f64 + 1.0).product())
    }

    /// Its mesh of elements of a kind, tetrahedra or hexahedra; a cell is six tetrahedra.
    pub fn part(&self, kind: ElementKind) -> Result<Part, ShapeError> {
        self.check()?;
        let steps = steps(kind);
        let whole = turn("angles", self.angles)?;
        let [around, through, along] = self.divisions;
        let [turned, depth, height] = [(around, 0), (through, 1), (along, 2)]
            .map(|(count, k)| graded_steps(count, self.grading[k], steps));
        let directions: Vec<(f64, f64)> = turned
            .iter()
            .map(|part| sine_cosine(self.angles[0] + (self.angles[1] - self.angles[0]) * part))
            .collect();
        let position = |[i, j, k]: [usize; 3]| {
            let radius = self.inner_radius + (self.outer_radius - self.inner_radius) * depth[i];
            let (sine, cosine) = directions[j];
            self.axis.point([radius * cosine, radius * sine, self.length * height[k]])
        };
        let lattice = HexLattice { cells: [through, around, along], cyclic: whole, kind };
        Ok(lattice.part(position, [["inner", "outer"], ["start", "end"], ["bottom", "top"]]))
    }
}
