//! A bar bent along a path: hairpins, serpentines, coils.

use diffuse_contact_mesh::ElementKind;

use super::grading::graded_steps;
use super::lattice::{HexLattice, steps};
use super::{divisions, in_range, length};
use crate::model::motion::sine_cosine;
use crate::model::{Part, ShapeError};

/// A bar of rectangular section whose centre line begins at the origin along x and goes on in the xy plane, piece by piece. Its width is
/// along z, from 0; pieces that rise make coils.
///
/// Faces: `start`, `end`, `left` and `right` of the way, `bottom` (at the smallest z of each section), `top`.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Straight and curved pieces, one after another.
    pub path: Vec<StripPiece>,
    /// From the right to the left of the way, length.
    pub thickness: f64,
    /// Along z, length.
    pub width: f64,
    /// Cells along, through the thickness, across the width. All are equally long along the centre line seen from above.
    pub divisions: [usize; 3],
}

/// A piece of a strip's centre line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripPiece {
    /// Seen from above, length.
    pub length: f64,
    /// What it turns by, degrees: positive to the left, 0 straight on.
    pub degrees: f64,
    /// What it rises by along z, length.
    pub rise: f64,
}

impl StripPiece {
    /// Straight on.
    pub const fn straight(length: f64) -> Self {
        Self { length, degrees: 0.0, rise: 0.0 }
    }

    /// An arc of this radius of the centre line, to the left by positive degrees.
    pub fn arc(radius: f64, degrees: f64) -> Self {
        Self { length: radius * degrees.abs().to_radians(), degrees, rise: 0.0 }
    }

    /// With this rise.
    #[must_use]
    pub const fn with_rise(self, rise: f64) -> Self {
        Self { rise, ..self }
    }
}

/// A point of the centre line, and its direction seen from above.
#[derive(Clone, Copy, Debug)]
struct Place {
    point: [f64; 3],
    degrees: f64,
}

impl Place {
    /// The place after a part of a piece.
    fn after(self, piece: &StripPiece, part: f64) -> Self {
        let Self { point: [x, y, z], degrees } = self;
        let turn = part * piece.degrees;
        let (sine, cosine) = sine_cosine(degrees);
        let (to_x, to_y) = if turn == 0.0 {
            (part * piece.length * cosine, part * piece.length * sine)
        } else {
            let radius = piece.length / piece.degrees.to_radians();
            let (end_sine, end_cosine) = sine_cosine(degrees + turn);
            (radius * (end_sine - sine), radius * (cosine - end_cosine))
        };
        Self { point: [x + to_x, y + to_y, z + part * piece.rise], degrees: degrees + turn }
    }
}

impl Strip {
    /// Finds the first number out of range.
    pub fn check(&self) -> Result<(), ShapeError> {
        length("thickness", self.thickness)?;
        length("width", self.width)?;
        in_range(!self.path.is_empty(), "path", "a list of at least one piece", 0.0)?;
        let cell = self.length() / self.divisions[0] as f64;
        for piece in &self.path {
            length("path", piece.length)?;
            in_range(
                piece.degrees.abs() <= 36_000.0,
                "path",
                "made of at most 100 turns each",
                piece.degrees,
            )?;
            let is_length = piece.rise.abs() <= super::MAX_LENGTH;
            in_range(is_length, "path", "made of rises up to 1e50", piece.rise)?;
            let radius = piece.length / piece.degrees.abs().to_radians();
            let range = "made of arcs whose radius is above half of the thickness";
            in_range(radius > 0.5 * self.thickness, "path", range, radius)?;
            let range = "so many that a cell spans less than 180 degrees";
            in_range(cell < 180_f64.to_radians() * radius, "divisions", range, self.divisions[0] as f64)?;
        }
        divisions(&self.divisions, self.divisions.iter().map(|&n| n as f64 + 1.0).product())
    }

    /// Of the centre line seen from above.
    fn length(&self) -> f64 {
        self.path.iter().map(|piece| piece.length).sum()
    }

    /// Places at these parts, from 0 to 1, of the length seen from above.
    fn places(&self, parts: &[f64]) -> Vec<Place> {
        let mut begins = Vec::new();
        let (mut way, mut begin) = (0.0, Place { point: [0.0; 3], degrees: 0.0 });
        for piece in &self.path {
            begins.push((way, begin));
            (way, begin) = (way + piece.length, begin.after(piece, 1.0));
        }
        let place = |part: &f64| {
            let at = part * way;
            let last = begins.partition_point(|(start, _)| *start <= at).saturating_sub(1);
            let ((start, begin), piece) = (begins[last], &self.path[last]);
            begin.after(piece, ((at - start) / piece.length).min(1.0))
        };
        parts.iter().map(place).collect()
    }

    /// Its mesh of elements of a kind, tetrahedra or hexahedra; a cell is six tetrahedra.
    pub fn part(&self, kind: ElementKind) -> Result<Part, ShapeError> {
        self.check()?;
        let steps = steps(kind);
        let [along, through, across] = self.divisions.map(|count| graded_steps(count, 1.0, steps));
        let places = self.places(&along);
        let position = |[i, j, k]: [usize; 3]| {
            let Place { point: [x, y, z], degrees } = places[i];
            let (sine, cosine) = sine_cosine(degrees);
            let left = self.thickness * (through[j] - 0.5);
            [x - left * sine, y + left * cosine, z + self.width * across[k]]
        };
        let lattice = HexLattice { cells: self.divisions, cyclic: false, kind };
        Ok(lattice.part(position, [["start", "end"], ["right", "left"], ["bottom", "top"]]))
    }
}
