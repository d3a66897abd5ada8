//! Parametric shapes.
//!
//! | solid | | rigid | |
//! | --- | --- | --- | --- |
//! | [`Block`] | a box of graded cells | [`RigidPlane`] | plane, normal +z |
//! | [`Pipe`] | a pipe, whole or a sector | [`RigidWave`] | z = a sin(2πx/λ) |
//! | [`Cylinder`] | a full cylinder, half or quarter | [`RigidCylinder`] | cylinder, whole or a sector |
//! | [`Ball`] | a full ball, half, quarter or eighth | [`RigidSphere`], [`RigidTorus`] | sphere and torus or parts of them |
//! | [`Strip`] | a bar bent along a path, a coil | | |
//!
//! Every shape has public fields, `check`, which finds the first number out of range, and `part`, which calls `check` and
//! makes the [`Part`]. Lengths are in the deck's unit, angles in degrees.

mod ball;
mod block;
mod cylinder;
mod grading;
mod lattice;
mod pipe;
mod rigid;
mod rigid_sphere;
mod strip;

pub use ball::Ball;
pub use block::Block;
pub use cylinder::Cylinder;
pub use pipe::Pipe;
pub use rigid::{Facets, RigidCylinder, RigidPlane, RigidTorus, RigidWave, Side};
pub use rigid_sphere::RigidSphere;
pub use strip::{Strip, StripPiece};

use diffuse_contact_mesh::ElementKind;

use super::{MAX_NODES, Part, ShapeError};

/// The longest length: its cube, times as many nodes as there may be, is finite.
const MAX_LENGTH: f64 = 1e50;
/// The shortest length, for the same reason.
const MIN_LENGTH: f64 = 1e-50;
/// The most a size of a cell may differ from the first to the last one.
const MAX_GRADING: f64 = 1e6;

/// The kinds of element that solid shapes can be made of, with their names in decks. `"hex8i"` is `"hex8"` with incompatible modes, which
/// belong to the elements of a part, [`Cells::set_incompatible_modes`](super::Cells::set_incompatible_modes), and not to its mesh.
pub const KINDS: [(&str, ElementKind); 5] = [
    ("hex8", ElementKind::Hexahedron8),
    ("hex20", ElementKind::Hexahedron20),
    ("hex27", ElementKind::Hexahedron27),
    ("tet4", ElementKind::Tetrahedron4),
    ("tet10", ElementKind::Tetrahedron10),
];

/// Any of the shapes.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // Each is what its content says.
pub enum Shape {
    Block(Block),
    Pipe(Pipe),
    Cylinder(Cylinder),
    Ball(Ball),
    Strip(Strip),
    RigidPlane(RigidPlane),
    RigidWave(RigidWave),
    RigidCylinder(RigidCylinder),
    RigidSphere(RigidSphere),
    RigidTorus(RigidTorus),
}

impl Shape {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        match self {
            Self::Block(shape) => shape.check(),
            Self::Pipe(shape) => shape.check(),
            Self::Cylinder(shape) => shape.check(),
            Self::Ball(shape) => shape.check(),
            Self::Strip(shape) => shape.check(),
            Self::RigidPlane(shape) => shape.check(),
            Self::RigidWave(shape) => shape.check(),
            Self::RigidCylinder(shape) => shape.check(),
            Self::RigidSphere(shape) => shape.check(),
            Self::RigidTorus(shape) => shape.check(),
        }
    }

    /// Its mesh. `kind`: of a solid's elements, tetrahedra or hexahedra.
    pub fn part(&self, kind: ElementKind) -> Result<Part, ShapeError> {
        match self {
            Self::Block(shape) => shape.part(kind),
            Self::Pipe(shape) => shape.part(kind),
            Self::Cylinder(shape) => shape.part(kind),
            Self::Ball(shape) => shape.part(kind),
            Self::Strip(shape) => shape.part(kind),
            Self::RigidPlane(shape) => shape.part(),
            Self::RigidWave(shape) => shape.part(),
            Self::RigidCylinder(shape) => shape.part(),
            Self::RigidSphere(shape) => shape.part(),
            Self::RigidTorus(shape) => shape.part(),
        }
    }

    /// Numbers of cells, in the order of its `divisions`.
    pub fn divisions_mut(&mut self) -> &mut [usize] {
        match self {
            Self::Block(shape) => &mut shape.divisions,
            Self::Pipe(shape) => &mut shape.divisions,
            Self::Cylinder(shape) => &mut shape.divisions,
            Self::Ball(shape) => &mut shape.divisions,
            Self::Strip(shape) => &mut shape.divisions,
            Self::RigidPlane(shape) => &mut shape.divisions,
            Self::RigidWave(shape) => &mut shape.divisions,
            Self::RigidCylinder(shape) => &mut shape.divisions,
            Self::RigidSphere(shape) => std::slice::from_mut(&mut shape.divisions),
            Self::RigidTorus(shape) => &mut shape.divisions,
        }
    }

    /// Whether it is a surface without a body.
    pub const fn is_rigid(&self) -> bool {
        !matches!(self, Self::Block(_) | Self::Pipe(_) | Self::Cylinder(_) | Self::Ball(_) | Self::Strip(_))
    }
}

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Axis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

impl Axis {
    /// Name in decks.
    pub const fn name(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }

    /// Where the local axis `k` of a shape along z lies when the shape is along this axis: axes are exchanged cyclically.
    const fn global(self, k: usize) -> usize {
        (k + self as usize + 1) % 3
    }

    /// A point in local axes, the third one along this axis.
    fn point(self, local: [f64; 3]) -> [f64; 3] {
        let mut point = [0.0; 3];
        (0..3).for_each(|k| point[self.global(k)] = local[k]);
        point
    }
}

/// One side of a plane through the centre: what is kept of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HalfSpace {
    /// Axis normal to the plane.
    pub axis: Axis,
    /// Whether the side of positive coordinates is kept, or that of negative ones.
    pub positive: bool,
}

impl HalfSpace {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self { axis: Axis::X, positive: false },
        Self { axis: Axis::X, positive: true },
        Self { axis: Axis::Y, positive: false },
        Self { axis: Axis::Y, positive: true },
        Self { axis: Axis::Z, positive: false },
        Self { axis: Axis::Z, positive: true },
    ];

    /// Name in decks.
    pub const fn name(self) -> &'static str {
        ["x-", "x+", "y-", "y+", "z-", "z+"][2 * self.axis as usize + self.positive as usize]
    }
}

/// The range of a lattice of 2n cells over a whole diameter along a global axis, and whether the lattice is cut.
fn kept(keep: &[HalfSpace], axis: usize, n: i64) -> ([i64; 2], bool) {
    match keep.iter().rev().find(|half| half.axis as usize == axis) {
        None => ([-n, n], false),
        Some(HalfSpace { positive: true, .. }) => ([0, n], true),
        Some(HalfSpace { positive: false, .. }) => ([-n, 0], true),
    }
}

/// Checks that a length is in a sensible range.
fn length(field: &'static str, value: f64) -> Result<(), ShapeError> {
    let sensible = (MIN_LENGTH..=MAX_LENGTH).contains(&value);
    in_range(sensible, field, "a positive length (1e-50 to 1e50)", value)
}

/// Checks a ratio of sizes of cells.
fn ratio(field: &'static str, value: f64) -> Result<(), ShapeError> {
    in_range((1.0 / MAX_GRADING..=MAX_GRADING).contains(&value), field, "from 1e-6 to 1e6", value)
}

/// Checks a range of angles and returns whether it is a whole turn.
fn turn(field: &'static str, [start, end]: [f64; 2]) -> Result<bool, ShapeError> {
    for angle in [start, end] {
        in_range(angle.abs() <= 3600.0, field, "made of angles from -3600 to 3600 degrees", angle)?;
    }
    let range = "a start and a larger end, at most 360 degrees apart";
    in_range(end > start && end - start <= 360.0, field, range, end - start)?;
    Ok(end - start == 360.0)
}

/// About what a node of a deformable part takes in a run, besides factors: its elements' stiffness and states, and its rows of K.
const BYTES_PER_NODE: usize = 18_000;

/// About what a node of a rigid part takes: its positions, its forces and its place in the surface.
const BYTES_PER_RIGID_NODE: usize = 1_000;

/// Checks that numbers of cells of a deformable part are positive and that there are not too many nodes.
fn divisions(counts: &[usize], nodes: f64) -> Result<(), ShapeError> {
    divisions_with(counts, nodes, BYTES_PER_NODE)
}

/// The same of a rigid part.
fn rigid_divisions(counts: &[usize], nodes: f64) -> Result<(), ShapeError> {
    divisions_with(counts, nodes, BYTES_PER_RIGID_NODE)
}

fn divisions_with(counts: &[usize], nodes: f64, bytes_per_node: usize) -> Result<(), ShapeError> {
    for &count in counts {
        in_range(count >= 1, "divisions", "at least 1", count as f64)?;
    }
    if !(nodes <= MAX_NODES as f64) {
        return Err(ShapeError::TooManyNodes { count: nodes, limit: MAX_NODES });
    }
    // Asked for and given back: systems that refuse it at once would otherwise end the program in the middle of its work.
    match Vec::<u8>::new().try_reserve_exact(nodes as usize * bytes_per_node) {
        Ok(()) => Ok(()),
        Err(_) => {
            let gigabytes = nodes * bytes_per_node as f64 / 1e9;
            Err(ShapeError::NoMemory { count: nodes, gigabytes })
        }
    }
}

fn in_range(holds: bool, field: &'static str, range: &'static str, value: f64) -> Result<(), ShapeError> {
    if holds { Ok(()) } else { Err(ShapeError::OutOfRange { field, range, value }) }
}

/// Checks a range of angles with the number of cells in it, each of which spans less than half a turn, and returns whether it is a whole
/// turn.
fn arc(field: &'static str, angles: [f64; 2], count: usize) -> Result<bool, ShapeError> {
    let whole = turn(field, angles)?;
    let cell = (angles[1] - angles[0]) / count as f64;
    in_range(!whole || count >= 3, "divisions", "at least 3 around a whole turn", count as f64)?;
    in_range(cell < 180.0, "divisions", "so many that a cell spans less than 180 degrees", count as f64)?;
    Ok(whole)
}
