//! A solid cylinder, whole, half or quarter.

use std::f64::consts::FRAC_PI_4;

use diffuse_contact_mesh::ElementKind;

use super::grading::{graded_steps, mirrored};
use super::lattice::{ButterflyLattice, steps};
use super::{Axis, HalfSpace, divisions, in_range, kept, length, ratio};
use crate::model::{Part, ShapeError};

/// A solid cylinder around a coordinate axis, from 0 to `length` along it. The mesh has a core, a rounded square, with layers
/// around it, so that no hexahedron is degenerate.
///
/// Faces: `outer`, `bottom` (at 0 along the axis), `top`, and `x0`, `y0`, `z0` where it is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Cylinder {
    /// Its axis.
    pub axis: Axis,
    /// Radius, length.
    pub radius: f64,
    /// Extent along the axis, length.
    pub length: f64,
    /// What is left of it: one half space across the axis gives half a cylinder, two give a quarter.
    pub keep: Vec<HalfSpace>,
    /// Cells of the core from the axis to its side (twice as many in each quarter of the circle), layers around the core,
    /// cells along the axis.
    pub divisions: [usize; 3],
    /// Half the width of the core over the radius.
    pub core: f64,
    /// Along x, y, z: the size of the core's last cell over that at the centre; along the cylinder the last over the first.
    pub grading: [f64; 3],
    /// Thickness of the outermost layer over that of the innermost.
    pub layer_grading: f64,
}

impl Cylinder {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        length("radius", self.radius)?;
        length("length", self.length)?;
        core("core", self.core)?;
        self.grading.into_iter().try_for_each(|value| ratio("grading", value))?;
        ratio("layer_grading", self.layer_grading)?;
        let along = self.keep.iter().filter(|half| half.axis == self.axis).count();
        in_range(along == 0, "keep", "made of half spaces across the axis", along as f64)?;
        opposite(&self.keep)?;
        let [half, layers, along] = self.divisions.map(|n| n as f64);
        let nodes = ((2.0 * half + 1.0).powi(2) + 8.0 * half * layers) * (along + 1.0);
        divisions(&self.divisions, nodes)
    }

    /// Its mesh of elements of a kind, tetrahedra or hexahedra; a cell is six tetrahedra.
    pub fn part(&self, kind: ElementKind) -> Result<Part, ShapeError> {
        self.check()?;
        let steps = steps(kind);
        let cells = self.divisions;
        let [half, layers, along] = cells.map(|count| steps * count);
        let [u, v, axial] = [0, 1, 2].map(|k| self.axis.global(k));
        let [(range_u, cut_u), (range_v, cut_v)] = [u, v].map(|axis| kept(&self.keep, axis, half as i64));
        let lattice = ButterflyLattice {
            kind,
            low: [range_u[0], range_v[0], 0],
            high: [range_u[1], range_v[1], along as i64],
            half: half as i64,
            round: 2,
            layers,
        };
        let [cells_u, cells_v] = [u, v].map(|axis| graded_steps(cells[0], self.grading[axis], steps));
        let height = graded_steps(cells[2], self.grading[axial], steps);
        let depth = graded_steps(cells[1], self.layer_grading, steps);
        let (mut part, places) = lattice.part(|([i, j, k], layer)| {
            let across = round_point([mirrored(&cells_u, i), mirrored(&cells_v, j)], self.core, depth[layer]);
            let [x, y] = across.map(|x| self.radius * x);
            self.axis.point([x, y, self.length * height[k as usize]])
        });
        let outside = part.outside();
        part.name_face("outer", &outside, |node| places[node].1 == layers);
        part.name_face("bottom", &outside, |node| places[node].0[2] == 0);
        part.name_face("top", &outside, |node| places[node].0[2] == along as i64);
        for (local, global, cut) in [(0, u, cut_u), (1, v, cut_v)] {
            if cut {
                part.name_face(["x0", "y0", "z0"][global], &outside, |node| places[node].0[local] == 0);
            }
        }
        Ok(part)
    }
}

/// Checks the relative size of a core: the corners of a larger one come too close to the outside.
pub(super) fn core(field: &'static str, value: f64) -> Result<(), ShapeError> {
    in_range((0.1..=0.6).contains(&value), field, "from 0.1 to 0.6", value)
}

/// Checks that no axis is cut from both sides.
pub(super) fn opposite(keep: &[HalfSpace]) -> Result<(), ShapeError> {
    let twice = (0..3).find(|&axis| keep.iter().filter(|half| half.axis as usize == axis).count() > 1);
    in_range(twice.is_none(), "keep", "made of at most one half space for each axis", keep.len() as f64)
}

/// The place in a disk or ball of radius 1 of a point of the cube from −1 to 1 that is the core, or of a layer over a point of
/// the cube's surface; `depth` is 0 for the core and 1 outside.
pub(super) fn round_point<const D: usize>(cube: [f64; D], core: f64, depth: f64) -> [f64; D] {
    let extent = cube.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if extent == 0.0 {
        return cube;
    }
    // On the sphere, lattice lines of the cube's faces are at equal angles.
    let tangents = cube.map(|x| (FRAC_PI_4 * (x / extent)).tan());
    let norm = tangents.iter().map(|x| x * x).sum::<f64>().sqrt();
    let direction = tangents.map(|x| x / norm);
    // Half way from the cube to the ball: neither the corners of the core nor the cells outside them are too blunt.
    let inner: [f64; D] = std::array::from_fn(|k| core * 0.5 * (cube[k] + extent * direction[k]));
    std::array::from_fn(|k| (1.0 - depth) * inner[k] + depth * direction[k])
}
