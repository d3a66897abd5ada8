//! A solid ball, whole, half, quarter or eighth.

use diffuse_contact_mesh::ElementKind;

use super::cylinder::{core, opposite, round_point};
use super::grading::{graded_steps, mirrored};
use super::lattice::{ButterflyLattice, steps};
use super::{HalfSpace, divisions, kept, length, ratio};
use crate::model::{Part, ShapeError};

/// A solid ball around the origin. The mesh has a core, a rounded cube, with layers around it, so that no hexahedron is
/// degenerate. It is refined towards the pole on an axis by a grading above 1 of the other two axes and a grading of the
/// layers below 1.
///
/// Faces: `outer`, and `x0`, `y0`, `z0` where it is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Ball {
    /// Radius, length.
    pub radius: f64,
    /// What is left of it: one half space gives half a ball, two give a quarter, three an eighth.
    pub keep: Vec<HalfSpace>,
    /// Cells of the core from the centre to its side, layers around the core.
    pub divisions: [usize; 2],
    /// Half the width of the core over the radius.
    pub core: f64,
    /// Along x, y, z: the size of the core's last cell over that at the centre.
    pub grading: [f64; 3],
    /// Thickness of the outermost layer over that of the innermost.
    pub layer_grading: f64,
}

impl Ball {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        length("radius", self.radius)?;
        core("core", self.core)?;
        self.grading.into_iter().try_for_each(|value| ratio("grading", value))?;
        ratio("layer_grading", self.layer_grading)?;
        opposite(&self.keep)?;
        let [half, layers] = self.divisions.map(|n| n as f64);
        divisions(&self.divisions, (2.0 * half + 1.0).powi(3) + (24.0 * half * half + 2.0) * layers)
    }

    /// Its mesh of elements of a kind, tetrahedra or hexahedra; a cell is six tetrahedra.
    pub fn part(&self, kind: ElementKind) -> Result<Part, ShapeError> {
        self.check()?;
        let steps = steps(kind);
        let [half, layers] = self.divisions.map(|count| steps * count);
        let lattice = lattice(kind, half, layers, &self.keep);
        let cells = self.grading.map(|ratio| graded_steps(self.divisions[0], ratio, steps));
        let depth = graded_steps(self.divisions[1], self.layer_grading, steps);
        let (mut part, places) = lattice.part(|(at, layer)| {
            let cube = std::array::from_fn(|axis| mirrored(&cells[axis], at[axis]));
            round_point::<3>(cube, self.core, depth[layer]).map(|x| self.radius * x)
        });
        let outside = part.outside();
        part.name_face("outer", &outside, |node| places[node].1 == layers);
        for axis in 0..3 {
            if kept(&self.keep, axis, 1).1 {
                part.name_face(["x0", "y0", "z0"][axis], &outside, |node| places[node].0[axis] == 0);
            }
        }
        Ok(part)
    }
}

/// The lattice of a ball, or of its surface.
pub(super) fn lattice(kind: ElementKind, half: usize, layers: usize, keep: &[HalfSpace]) -> ButterflyLattice {
    let ranges = [0, 1, 2].map(|axis| kept(keep, axis, half as i64).0);
    ButterflyLattice {
        kind,
        low: ranges.map(|range| range[0]),
        high: ranges.map(|range| range[1]),
        half: half as i64,
        round: 3,
        layers,
    }
}
