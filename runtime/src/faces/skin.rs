//! The geometry of slave faces: their own smooth surface, as far as they have one.
//!
//! Points of a flat face lie inside a curved body: h²/8R below its surface. Against a smooth master that is a gap which is not there.
//! So a face is interpolated, quadratically, between its corners and points of the fit through the slave's own nodes: the middles of its
//! edges and, of a quadrilateral, its centre. The points are affine combinations of nodes, whose weights φ_k are those of the first
//! configuration (docs/equations.md, section 18).

use crate::interface::{ContactElement, ContactInterface, InterfaceError, InterfaceOptions, PairedElement};
use crate::neighbourhood::SearchOptions;
use crate::pairing::Pairing;
use crate::surface::{Facet, MasterSurface, Shape};
use crate::vector::Vector3;
use crate::{Mode, Point};

/// Points of interpolation of a quadrilateral, of a triangle six.
const MOST_POINTS: usize = 9;
/// How far towards the centre of its face a point moves to be that face's and not its neighbour's, in parts of the way.
const INWARD: f64 = 1e-6;

/// One face.
#[derive(Clone, Debug, Default)]
pub struct SkinFace {
    /// Nodes that carry it, ascending.
    pub nodes: Vec<u32>,
    /// What each of them has of the points of interpolation: corners, middles of edges, centre.
    terms: Vec<[f64; MOST_POINTS]>,
}

impl SkinFace {
    /// What each node has of the point at natural coordinates.
    pub fn weights(&self, corners: usize, natural: [f64; 2]) -> impl Iterator<Item = f64> + '_ {
        let functions = quadratic(corners, natural);
        self.terms.iter().map(move |terms| terms.iter().zip(&functions).map(|(term, n)| term * n).sum())
    }

    fn add(&mut self, node: u32, point: usize, weight: f64) {
        let place = match self.nodes.binary_search(&node) {
            Ok(place) => place,
            Err(place) => {
                self.nodes.insert(place, node);
                self.terms.insert(place, [0.0; MOST_POINTS]);
                place
            }
        };
        self.terms[place][point] += weight;
    }
}

/// The quadratic shape functions of corners, middles of edges, and centre: nine of a quadrilateral, six of a triangle.
fn quadratic(corners: usize, [xi, eta]: [f64; 2]) -> [f64; MOST_POINTS] {
    if corners == 3 {
        let [a, b, c] = [1.0 - xi - eta, xi, eta];
        let corner = |x: f64| x * (2.0 * x - 1.0);
        return [corner(a), corner(b), corner(c), 4.0 * a * b, 4.0 * b * c, 4.0 * c * a, 0.0, 0.0, 0.0];
    }
    let along = |x: f64| [0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)];
    let (first, second) = (along(xi), along(eta));
    [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
        .map(|(i, j)| first[i] * second[j])
}

/// Points between the corners, in the order of [`quadratic`], with the corners that they are in the middle of.
fn between(facet: &Facet) -> Vec<Vec<usize>> {
    let corners = facet.corners();
    let edges = (0..corners.len()).map(|k| vec![corners[k], corners[(k + 1) % corners.len()]]);
    let centre = (corners.len() == 4).then(|| corners.to_vec());
    edges.chain(centre).collect()
}

/// All faces, and how many of their points have no fit: they lie in the middle between the corners.
pub fn skin(
    faces: &[Facet],
    first: &[Point],
    options: &InterfaceOptions,
) -> Result<(Vec<SkinFace>, usize), InterfaceError> {
    let mean = |nodes: &[usize]| {
        let sum = nodes.iter().fold(Vector3::zeros(), |sum, &node| sum + Vector3::from(first[node]));
        sum * (1.0 / nodes.len() as f64)
    };
    let middles: Vec<Vec<usize>> = faces.iter().flat_map(between).collect();
    let fitted = match options.element {
        ContactElement::NodeToFacet => vec![None; middles.len()],
        ContactElement::Diffuse { weight, .. } => {
            let owners = faces.iter().flat_map(|face| vec![face; between(face).len()]);
            let inside = owners.zip(&middles).map(|(face, middle)| {
                let centre = match face {
                    Facet::Triangle(corners) => mean(corners),
                    Facet::Quadrilateral(corners) => mean(corners),
                };
                let x = mean(middle);
                x + (centre - x) * INWARD
            });
            let mut positions = first.to_vec();
            positions.extend(inside.map(Point::from));
            let element = ContactElement::diffuse(SearchOptions::domains()).with_weight(weight);
            let options = InterfaceOptions {
                element,
                distance_limit: None,
                areas: false,
                border_tolerance: 0.5,
                ..*options
            };
            let surface = MasterSurface::new(first, faces.to_vec())?;
            let points = (first.len()..positions.len()).collect();
            let mut own = ContactInterface::new(surface, points, &[], &positions, options)?;
            own.refresh_pairing(&positions)?;
            own.evaluate(Mode::Value)?;
            let fit = |(k, middle): (usize, &Vec<usize>)| {
                let contact = own.contacts().get(k);
                let PairedElement::Diffuse { slave, pairing } = own.element(k).ok()? else { return None };
                let back = mean(middle) - Vector3::from(slave);
                let foot = contact.outcome.is_contact().then(|| Vector3::from(contact.point.foot) + back)?;
                weights_at(&pairing, foot)
            };
            middles.iter().enumerate().map(fit).collect()
        }
    };
    let (mut all, mut straight) = (Vec::with_capacity(faces.len()), 0);
    let mut points = middles.iter().zip(fitted);
    for facet in faces {
        let mut face = SkinFace::default();
        for (k, &corner) in facet.corners().iter().enumerate() {
            face.add(corner as u32, k, 1.0);
        }
        let count = between(facet).len();
        for (k, (middle, fit)) in points.by_ref().take(count).enumerate() {
            let point = facet.corners().len() + k;
            if let Some(weights) = fit {
                weights.into_iter().for_each(|(node, weight)| face.add(node as u32, point, weight));
            } else {
                straight += 1;
                middle.iter().for_each(|&node| face.add(node as u32, point, 1.0 / middle.len() as f64));
            }
        }
        all.push(face);
    }
    if options.element == ContactElement::NodeToFacet {
        straight = 0;
    }
    Ok((all, straight))
}

/// φ_k of a fit at a place of the surface, with the nodes; `None` if the fit's equations are singular.
fn weights_at(pairing: &Pairing, place: Vector3) -> Option<Vec<(usize, f64)>> {
    let unit = 1.0 / pairing.support_radius;
    let [t1, t2] = [pairing.frame.t1, pairing.frame.t2].map(Vector3::from);
    let size = pairing.basis.size();
    let monomials = |x: Point| {
        let offset = (Vector3::from(x) - place) * unit;
        let (a, b) = (t1.dot(&offset), t2.dot(&offset));
        [1.0, a, b, a * a, a * b, b * b]
    };
    let rows: Vec<[f64; 6]> = pairing.positions.iter().map(|&x| monomials(x)).collect();
    let weights: Vec<f64> =
        pairing.material.iter().map(|node| pairing.weight.fitting(node.distance())).collect();
    let mut matrix = [[0.0; 6]; 6];
    for (row, weight) in rows.iter().zip(&weights) {
        for i in 0..size {
            for j in 0..size {
                matrix[i][j] += weight * row[i] * row[j];
            }
        }
    }
    let coefficients = solve_for_first(matrix, size)?;
    let value = |row: &[f64; 6]| (0..size).map(|i| row[i] * coefficients[i]).sum::<f64>();
    let weights = rows.iter().zip(&weights).map(|(row, weight)| weight * value(row));
    Some(pairing.masters.iter().copied().zip(weights).collect())
}

/// The first column of the inverse of a symmetric positive definite matrix, by Cholesky's factors.
fn solve_for_first(mut a: [[f64; 6]; 6], size: usize) -> Option<[f64; 6]> {
    for j in 0..size {
        let pivot = a[j][j] - (0..j).map(|k| a[j][k] * a[j][k]).sum::<f64>();
        if !(pivot > 0.0) {
            return None;
        }
        a[j][j] = pivot.sqrt();
        for i in j + 1..size {
            a[i][j] = (a[i][j] - (0..j).map(|k| a[i][k] * a[j][k]).sum::<f64>()) / a[j][j];
        }
    }
    let mut x = [0.0; 6];
    x[0] = 1.0;
    for i in 0..size {
        x[i] = (x[i] - (0..i).map(|k| a[i][k] * x[k]).sum::<f64>()) / a[i][i];
    }
    for i in (0..size).rev() {
        x[i] = (x[i] - (i + 1..size).map(|k| a[k][i] * x[k]).sum::<f64>()) / a[i][i];
    }
    Some(x)
}

/// The position of a face's point.
pub fn position(face: &SkinFace, corners: usize, natural: [f64; 2], positions: &[Point]) -> Point {
    // From the first node: digits are those of the face.
    let Some(&first) = face.nodes.first() else { return [f64::NAN; 3] };
    let origin = Vector3::from(positions[first as usize]);
    let offset = face
        .nodes
        .iter()
        .zip(face.weights(corners, natural))
        .fold(Vector3::zeros(), |sum, (&node, weight)| {
            sum + (Vector3::from(positions[node as usize]) - origin) * weight
        });
    (origin + offset).into()
}

/// A face as it lies.
pub fn shape(facet: &Facet, positions: &[Point]) -> Shape {
    match facet {
        Facet::Triangle(corners) => Shape::Triangle(corners.map(|node| positions[node].into())),
        Facet::Quadrilateral(corners) => Shape::Quadrilateral(corners.map(|node| positions[node].into())),
    }
}
