//! The error of the gap all over whole bodies: faces of one row of cells, curved rims, and the sharp edges between.
//!
//! Nodes lie on the exact surface of a body, slaves above it, at nine places of every cell.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use diffuse_contact::interface::{ContactElement, InterfaceOptions, Outcome};
use diffuse_contact::neighbourhood::NeighbourRule;
use diffuse_contact::surface::Facet;
use diffuse_contact::{FrameDerivative, Mode, Point, Weight};
use diffuse_contact_cli::contact_options::diffuse;
use nalgebra::Vector3;
use serde::Serialize;

use crate::study::{StudyError, paired};

/// Nodes nearer to one another than this are one.
const SAME: f64 = 1e-6;
/// Places along a cell where slaves are.
const PLACES: [f64; 3] = [0.1, 0.4, 0.7];
/// How far slaves are above the surface, over the shorter edges of the cells: more than arcs rise above their chords in holes.
const ABOVE: f64 = 0.2;
/// A step of differences, over the face.
const STEP: f64 = 1e-6;

/// A face of a body: a grid of cells, counter-clockwise in (s, t) seen from outside.
struct Face {
    name: &'static str,
    cells: [usize; 2],
    /// The surface over [0, 1]².
    at: Box<dyn Fn(f64, f64) -> Point>,
}

struct Body {
    name: &'static str,
    faces: Vec<Face>,
}

fn face(name: &'static str, cells: [usize; 2], at: impl Fn(f64, f64) -> Point + 'static) -> Face {
    Face { name, cells, at: Box::new(at) }
}

/// A body of revolution with a rectangular section: radii and height, cells around, between the radii, and along the axis.
fn ring(name: &'static str, [inner, outer, height]: [f64; 3], [around, across, along]: [usize; 3]) -> Body {
    let at = |r: f64, turn: f64, z: f64| {
        let (sin, cos) = (TAU * turn).sin_cos();
        [r * cos, r * sin, z]
    };
    let between = move |s: f64| inner + s * (outer - inner);
    Body {
        name,
        faces: vec![
            face("outside", [around, along], move |s, t| at(outer, s, height * t)),
            face("inside", [around, along], move |s, t| at(inner, 1.0 - s, height * t)),
            face("end", [across, around], move |s, t| at(between(s), t, height)),
            face("other end", [across, around], move |s, t| at(between(1.0 - s), t, 0.0)),
        ],
    }
}

/// A sphere of radius 5 with meridians that meet in its poles.
fn globe(name: &'static str, cells: [usize; 2]) -> Body {
    let at = |s: f64, t: f64| {
        let ((sin, cos), (sin_of_turn, cos_of_turn)) = ((PI * t).sin_cos(), (TAU * s).sin_cos());
        [5.0 * sin * cos_of_turn, 5.0 * sin * sin_of_turn, -5.0 * cos]
    };
    Body { name, faces: vec![face("all around", cells, at)] }
}

/// A sheet of metal between two offset surfaces of a middle one: `middle` gives point and unit normal over [0, 1]².
fn sheet(
    name: &'static str,
    thickness: f64,
    [along, across]: [usize; 2],
    middle: impl Fn(f64, f64) -> (Point, Point) + Copy + 'static,
) -> Body {
    let at = move |s: f64, t: f64, side: f64| {
        let (point, normal) = middle(s, t);
        [0, 1, 2].map(|k| point[k] + 0.5 * thickness * side * normal[k])
    };
    let even = |t: f64| 2.0 * t - 1.0;
    Body {
        name,
        faces: vec![
            face("one side", [along, across], move |s, t| at(s, t, 1.0)),
            face("other side", [along, across], move |s, t| at(1.0 - s, t, -1.0)),
            face("edge along", [along, 1], move |s, t| at(s, 0.0, even(t))),
            face("other edge along", [along, 1], move |s, t| at(1.0 - s, 1.0, even(t))),
            face("edge across", [1, across], move |s, t| at(0.0, t, even(s))),
            face("other edge across", [1, across], move |s, t| at(1.0, t, -even(s))),
        ],
    }
}

fn bodies() -> Vec<Body> {
    let bend = |s: f64, t: f64| {
        // Legs of length 6 and half a circle of radius 3 between.
        let (leg, radius, width) = (6.0, 3.0, 8.0);
        let way = s * (2.0 * leg + PI * radius) - leg;
        let angle = (way / radius).clamp(0.0, PI);
        let (sin, cos) = angle.sin_cos();
        let without = if way < 0.0 { way } else { way - radius * angle };
        let point = [radius * sin + without * cos, width * t, -radius * cos + without * sin];
        (point, [-sin, 0.0, cos])
    };
    let wavy = |s: f64, t: f64| {
        let (x, y) = (16.0 * s, 8.0 * t);
        let wave = TAU / 12.0;
        let slope = [0.5 * wave * (wave * x).cos(), 0.0];
        let length = (1.0 + slope[0] * slope[0]).sqrt();
        ([x, y, 0.5 * (wave * x).sin()], [-slope[0] / length, 0.0, 1.0 / length])
    };
    vec![
        ring("ring of 12 cells", [4.0, 5.0, 1.0], [12, 1, 1]),
        ring("ring of 24 cells", [4.0, 5.0, 1.0], [24, 2, 2]),
        ring("tube of 16 cells", [4.0, 5.0, 8.0], [16, 1, 6]),
        ring("hole of 12 cells", [1.0, 6.0, 0.5], [12, 8, 1]),
        ring("disc with a small hole", [0.25, 6.0, 1.0], [24, 8, 1]),
        sheet("bent sheet", 1.0, [24, 8], bend),
        sheet("wavy sheet", 1.0, [16, 8], wavy),
        globe("sphere of 16 × 8 cells", [16, 8]),
        globe("sphere of 40 × 20 cells", [40, 20]),
    ]
}

/// What was measured on a face of a body with an element.
#[derive(Clone, Debug, Serialize)]
pub struct BodyMeasurement {
    /// The body.
    pub body: &'static str,
    /// The face of it.
    pub face: &'static str,
    /// Whether cells are cut into triangles.
    pub triangles: bool,
    /// Name of the element.
    pub element: &'static str,
    /// Largest |gap error| over the mean edge of the face's cells.
    pub gap_max: f64,
    /// Slaves without contact.
    pub without: usize,
    /// Slaves on the face.
    pub slaves: usize,
}

/// Measures all bodies.
pub fn measure_bodies() -> Result<Vec<BodyMeasurement>, StudyError> {
    let smooth = diffuse(Weight::default(), FrameDerivative::CoMoving, NeighbourRule::Domains);
    let mut all = Vec::new();
    for body in bodies() {
        for triangles in [false, true] {
            for (name, element) in [("facets", ContactElement::NodeToFacet), ("smooth", smooth)] {
                all.extend(measure(&body, triangles, name, element)?);
            }
        }
    }
    Ok(all)
}

fn measure(
    body: &Body,
    triangles: bool,
    name: &'static str,
    element: ContactElement,
) -> Result<Vec<BodyMeasurement>, StudyError> {
    let (positions, facets) = body.mesh(triangles);
    let slaves: Vec<Vec<Point>> = body.faces.iter().map(Face::slaves).collect();
    let options = InterfaceOptions::default().with_element(element);
    let (mut interface, _) = paired(positions, facets, slaves.iter().flatten().copied(), options)?;
    let contacts = interface.evaluate(Mode::Value)?;
    let mut contacts = contacts.iter();
    let mut all = Vec::new();
    for (face, slaves) in body.faces.iter().zip(&slaves) {
        let (mut gap_max, mut without) = (0.0_f64, 0);
        let [shorter, longer] = face.edges();
        for contact in contacts.by_ref().take(slaves.len()) {
            match contact.outcome {
                Outcome::None(_) => without += 1,
                _ => gap_max = gap_max.max((contact.point.gap - ABOVE * shorter).abs()),
            }
        }
        let gap_max = gap_max / (0.5 * (shorter + longer));
        let (body, face, slaves) = (body.name, face.name, slaves.len());
        all.push(BodyMeasurement { body, face, triangles, element: name, gap_max, without, slaves });
    }
    Ok(all)
}

impl Body {
    /// Nodes that are there once, and facets.
    fn mesh(&self, triangles: bool) -> (Vec<Point>, Vec<Facet>) {
        let (mut positions, mut facets) = (Vec::new(), Vec::new());
        let mut known: BTreeMap<[i64; 3], usize> = BTreeMap::new();
        for Face { cells: [columns, rows], at, .. } in &self.faces {
            let mut node = |i: usize, j: usize| {
                let x = at(i as f64 / *columns as f64, j as f64 / *rows as f64);
                *known.entry(x.map(|x| (x / SAME).round() as i64)).or_insert_with(|| {
                    positions.push(x);
                    positions.len() - 1
                })
            };
            for j in 0..*rows {
                for i in 0..*columns {
                    let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
                    let corners = [a, b, c, d];
                    if let Some(k) = (0..4).find(|&k| corners[k] == corners[(k + 1) % 4]) {
                        // At a pole.
                        facets.push(Facet::Triangle([1, 2, 3].map(|next| corners[(k + next) % 4])));
                    } else if triangles {
                        let cut =
                            if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                        facets.extend(cut.map(Facet::Triangle));
                    } else {
                        facets.push(Facet::Quadrilateral([a, b, c, d]));
                    }
                }
            }
        }
        (positions, facets)
    }
}

impl Face {
    fn slaves(&self) -> Vec<Point> {
        let [columns, rows] = self.cells;
        let along = |count: usize| {
            (0..count).flat_map(move |k| PLACES.map(|place| (k as f64 + place) / count as f64))
        };
        let above = ABOVE * self.edges()[0];
        let over = |s: f64, t: f64| {
            let (point, normal) = ((self.at)(s, t), self.normal(s, t));
            [0, 1, 2].map(|k| point[k] + above * normal[k])
        };
        along(rows).flat_map(|t| along(columns).map(move |s| over(s, t))).collect()
    }

    /// Outward unit normal, by differences.
    fn normal(&self, s: f64, t: f64) -> Point {
        let along = |one: Point, two: Point| Vector3::from(two) - Vector3::from(one);
        let by_s = along((self.at)(s - STEP, t), (self.at)(s + STEP, t));
        let by_t = along((self.at)(s, t - STEP), (self.at)(s, t + STEP));
        by_s.cross(&by_t).normalize().into()
    }

    /// The mean lengths of the edges along s and along t, the shorter first.
    fn edges(&self) -> [f64; 2] {
        let [columns, rows] = self.cells;
        let at = |i: usize, j: usize| (self.at)(i as f64 / columns as f64, j as f64 / rows as f64);
        let distance = |x: Point, y: Point| (Vector3::from(x) - Vector3::from(y)).norm();
        let mut sums = [0.0; 2];
        for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
            sums[0] += distance(at(i, j), at(i + 1, j));
            sums[1] += distance(at(i, j), at(i, j + 1));
        }
        let [one, two] = sums.map(|sum| sum / (columns * rows) as f64);
        [one.min(two), one.max(two)]
    }
}
