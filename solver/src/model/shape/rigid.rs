//! Rigid surfaces over a rectangle of parameters.

use std::f64::consts::TAU;

use diffuse_contact::surface::Facet;

use super::{Axis, arc, in_range, length, rigid_divisions, turn};
use crate::model::motion::sine_cosine;
use crate::model::{Part, ShapeError};

/// What a rigid surface is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Facets {
    /// Bilinear quadrilaterals.
    #[default]
    Quadrilaterals,
    /// Each quadrilateral divided into two triangles, all along the same diagonal.
    Triangles,
}

/// Which side of a closed surface is touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Side {
    /// From outside.
    #[default]
    Outside,
    /// From inside.
    Inside,
}

/// Part of a plane z = 0 with a corner at the origin, touched from above. Node sets: `x-`, `x+`, `y-`, `y+`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidPlane {
    /// Extent along x and y, length.
    pub size: [f64; 2],
    /// Cells along x and y.
    pub divisions: [usize; 2],
    /// Triangles or quadrilaterals.
    pub facets: Facets,
}

/// The surface z = a sin(2πx/λ) over a rectangle with a corner at the origin, touched from above. Node sets: `x-`, `x+`,
/// `y-`, `y+`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidWave {
    /// Extent along x and y, length.
    pub size: [f64; 2],
    /// a, length; either sign.
    pub height: f64,
    /// λ, length.
    pub wavelength: f64,
    /// Cells along x and y.
    pub divisions: [usize; 2],
    /// Triangles or quadrilaterals.
    pub facets: Facets,
}

/// A cylinder around a coordinate axis, from 0 to `length` along it; angles as for a [`Pipe`](super::Pipe). Node sets:
/// `bottom`, `top`, and of a sector `start` and `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidCylinder {
    /// Its axis.
    pub axis: Axis,
    /// Radius, length.
    pub radius: f64,
    /// First and last angle, degrees; 360 apart is a whole cylinder.
    pub angles: [f64; 2],
    /// Extent along the axis, length.
    pub length: f64,
    /// Cells around and along.
    pub divisions: [usize; 2],
    /// Triangles or quadrilaterals.
    pub facets: Facets,
    /// Which side is touched.
    pub side: Side,
}

/// A torus around a coordinate axis, centre at the origin. Node sets: of a part around the axis `start` and `end`, of a part
/// around the tube `tube_start` and `tube_end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidTorus {
    /// Its axis.
    pub axis: Axis,
    /// Distance of the middle of the tube from the axis, length.
    pub radius: f64,
    /// Radius of the tube, length; below `radius`.
    pub tube_radius: f64,
    /// First and last angle around the axis, degrees, as for a [`Pipe`](super::Pipe).
    pub angles: [f64; 2],
    /// First and last angle around the tube, degrees: 0 is farthest from the axis, 90 highest along it.
    pub tube_angles: [f64; 2],
    /// Cells around the axis and around the tube.
    pub divisions: [usize; 2],
    /// Triangles or quadrilaterals.
    pub facets: Facets,
    /// Which side is touched.
    pub side: Side,
}

impl RigidPlane {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        self.size.into_iter().try_for_each(|value| length("size", value))?;
        rigid_divisions(&self.divisions, node_count(self.divisions, [false; 2]))
    }

    /// Its mesh.
    pub fn part(&self) -> Result<Part, ShapeError> {
        self.check()?;
        let [along_x, along_y] = self.divisions;
        let position = |[i, j]: [usize; 2]| {
            [self.size[0] * i as f64 / along_x as f64, self.size[1] * j as f64 / along_y as f64, 0.0]
        };
        let part = sheet(self.divisions, [false; 2], position, [["x-", "x+"], ["y-", "y+"]]);
        Ok(finished(part, self.facets, Side::Outside))
    }
}

impl RigidWave {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        self.size.into_iter().try_for_each(|value| length("size", value))?;
        in_range(self.height.abs() <= super::MAX_LENGTH, "height", "finite (up to 1e50)", self.height)?;
        length("wavelength", self.wavelength)?;
        rigid_divisions(&self.divisions, node_count(self.divisions, [false; 2]))
    }

    /// Its mesh.
    pub fn part(&self) -> Result<Part, ShapeError> {
        self.check()?;
        let [along_x, along_y] = self.divisions;
        let position = |[i, j]: [usize; 2]| {
            let x = self.size[0] * i as f64 / along_x as f64;
            let z = self.height * (TAU * (x / self.wavelength)).sin();
            [x, self.size[1] * j as f64 / along_y as f64, z]
        };
        let part = sheet(self.divisions, [false; 2], position, [["x-", "x+"], ["y-", "y+"]]);
        Ok(finished(part, self.facets, Side::Outside))
    }
}

impl RigidCylinder {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        length("radius", self.radius)?;
        length("length", self.length)?;
        let whole = arc("angles", self.angles, self.divisions[0])?;
        rigid_divisions(&self.divisions, node_count(self.divisions, [whole, false]))
    }

    /// Its mesh.
    pub fn part(&self) -> Result<Part, ShapeError> {
        self.check()?;
        let whole = turn("angles", self.angles)?;
        let position = |[i, j]: [usize; 2]| {
            let (sine, cosine) = direction(self.angles, i, self.divisions[0]);
            let height = self.length * j as f64 / self.divisions[1] as f64;
            self.axis.point([self.radius * cosine, self.radius * sine, height])
        };
        let part = sheet(self.divisions, [whole, false], position, [["start", "end"], ["bottom", "top"]]);
        Ok(finished(part, self.facets, self.side))
    }
}

impl RigidTorus {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        length("radius", self.radius)?;
        length("tube_radius", self.tube_radius)?;
        in_range(self.tube_radius < self.radius, "tube_radius", "below radius", self.tube_radius)?;
        let whole = [
            arc("angles", self.angles, self.divisions[0])?,
            arc("tube_angles", self.tube_angles, self.divisions[1])?,
        ];
        rigid_divisions(&self.divisions, node_count(self.divisions, whole))
    }

    /// Its mesh.
    pub fn part(&self) -> Result<Part, ShapeError> {
        self.check()?;
        let whole = [turn("angles", self.angles)?, turn("tube_angles", self.tube_angles)?];
        let position = |[i, j]: [usize; 2]| {
            let (sine, cosine) = direction(self.angles, i, self.divisions[0]);
            let (up, out) = direction(self.tube_angles, j, self.divisions[1]);
            let radius = self.radius + self.tube_radius * out;
            self.axis.point([radius * cosine, radius * sine, self.tube_radius * up])
        };
        let part = sheet(self.divisions, whole, position, [["start", "end"], ["tube_start", "tube_end"]]);
        Ok(finished(part, self.facets, self.side))
    }
}

/// Sine and cosine at the end of the cell before `k`.
fn direction([start, end]: [f64; 2], k: usize, count: usize) -> (f64, f64) {
    sine_cosine(start + (end - start) * (k as f64 / count as f64))
}

/// Of a [`sheet`].
fn node_count(cells: [usize; 2], closed: [bool; 2]) -> f64 {
    [0, 1].map(|k| cells[k] as f64 + if closed[k] { 0.0 } else { 1.0 }).iter().product()
}

/// Quadrilaterals over a rectangle of parameters, normals along the first direction times the second; `closed` directions
/// come back to where they begin. `edges` names the nodes at the beginning and the end of the others.
fn sheet(
    cells: [usize; 2],
    closed: [bool; 2],
    position: impl Fn([usize; 2]) -> [f64; 3],
    edges: [[&str; 2]; 2],
) -> Part {
    let counts = [0, 1].map(|k| if closed[k] { cells[k] } else { cells[k] + 1 });
    let node = |[i, j]: [usize; 2]| (i % counts[0]) + counts[0] * (j % counts[1]);
    let mut part = Part::default();
    for j in 0..counts[1] {
        part.nodes.extend((0..counts[0]).map(|i| position([i, j])));
    }
    for j in 0..cells[1] {
        for i in 0..cells[0] {
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(node);
            part.facets.push(Facet::Quadrilateral(corners));
        }
    }
    for k in (0..2).filter(|&k| !closed[k]) {
        for (name, end) in edges[k].into_iter().zip([0, cells[k]]) {
            part.name_face(name, &[], |node| [node % counts[0], node / counts[0]][k] == end);
        }
    }
    part
}

/// Facets turned to the side that is touched, and divided if asked for.
pub(super) fn finished(mut part: Part, facets: Facets, side: Side) -> Part {
    let divided = |facet: Facet| match (facet, facets) {
        (Facet::Quadrilateral([a, b, c, d]), Facets::Triangles) => {
            vec![Facet::Triangle([a, b, c]), Facet::Triangle([a, c, d])]
        }
        (facet, _) => vec![facet],
    };
    part.facets = part.facets.into_iter().flat_map(divided).collect();
    if side == Side::Inside {
        part.facets = part.facets.into_iter().map(Facet::flipped).collect();
    }
    part
}
