//! The geometry of slave faces: their own smooth surface, as far as they have one.
//!
//! Points of a flat face lie inside a curved body: h²/8R below its surface. Against a smooth master that is a gap which is not there.
//! So a face is interpolated, quadratically, between its corners and points of the fit through the slave's own nodes: the middles of its
//! edges and, of a quadrilateral, its centre. The points are affine combinations of nodes, whose weights φ_k are those of the first
//! configuration (docs/equations.md, section 18).

use super::slave_nodes::SlaveNodes;
use crate::affine::Carrier;
use crate::interface::{
    ContactElement, ContactInterface, InterfaceError, InterfaceOptions, PointsWithinReach,
};
use crate::neighbourhood::SearchOptions;
use crate::surface::window::{Window, WindowError};
use crate::surface::{Facet, Image, MasterSurface, Symmetry, SymmetryPlane, shape_of};
use crate::vector::Vector3;
use crate::{Basis, Mode, Point, Weight};

/// A place where the ω of a node is 1 up to this is that of the node.
const AT_A_NODE: f64 = 1e-13;

/// Points of interpolation of a quadrilateral, of a triangle six.
const MOST_POINTS: usize = 9;

/// All faces.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    pub faces: Vec<SkinFace>,
    /// Images of nodes, where planes of symmetry are near.
    symmetry: Symmetry,
    /// Points without a fit, which lie in the middle between the corners.
    pub straight: usize,
}

/// One face.
#[derive(Clone, Debug, Default)]
pub struct SkinFace {
    /// How many it has.
    corners: usize,
    /// Nodes that carry it, and images of them, ascending.
    pub carriers: Vec<Carrier>,
    /// What each of them has of the points of interpolation: corners, middles of edges, centre.
    terms: Vec<[f64; MOST_POINTS]>,
}

impl SkinFace {
    /// What each carrier has of the point at natural coordinates.
    pub fn weights(&self, natural: [f64; 2]) -> impl Iterator<Item = f64> + '_ {
        let functions = quadratic(self.corners, natural);
        self.terms.iter().map(move |terms| terms.iter().zip(&functions).map(|(term, n)| term * n).sum())
    }

    fn add(&mut self, carrier: Carrier, point: usize, weight: f64) {
        let place = match self.carriers.binary_search(&carrier) {
            Ok(place) => place,
            Err(place) => {
                self.carriers.insert(place, carrier);
                self.terms.insert(place, [0.0; MOST_POINTS]);
                place
            }
        };
        self.terms[place][point] += weight;
    }
}

impl Skin {
    /// The image that a carrier is.
    pub fn image(&self, carrier: Carrier) -> Option<&Image> {
        carrier.image.map(|number| self.symmetry.image(number))
    }

    /// The direction without what points out of the planes of symmetry that hold `point`.
    pub fn within_planes(&self, point: Point, direction: Vector3) -> Vector3 {
        self.symmetry.within_planes(point, direction)
    }

    /// The position of a face's point.
    pub fn position(&self, face: usize, natural: [f64; 2], positions: &[Point]) -> Point {
        let face = &self.faces[face];
        let place = |carrier: Carrier| {
            let x = positions[carrier.node as usize];
            Vector3::from(self.image(carrier).map_or(x, |image| image.of(x)))
        };
        // From the first carrier: digits are those of the face.
        let Some(&first) = face.carriers.first() else { return [f64::NAN; 3] };
        let origin = place(first);
        let offset = face
            .carriers
            .iter()
            .zip(face.weights(natural))
            .fold(Vector3::zeros(), |sum, (&carrier, weight)| sum + (place(carrier) - origin) * weight);
        (origin + offset).into()
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

impl Skin {
    /// The facets of a surface in their first configuration.
    pub fn new(
        surface: MasterSurface,
        first: &[Point],
        options: &InterfaceOptions,
        planes: &[SymmetryPlane],
    ) -> Result<Self, InterfaceError> {
        let faces: Vec<Facet> = (0..surface.facet_count()).map(|facet| surface.facet(facet)).collect();
        match options.element {
            ContactElement::NodeToFacet => {
                let extents = faces.iter().map(|face| shape_of(face, first).extent());
                let symmetry = Symmetry::of_planes(planes, extents.fold(0.0, f64::max))?;
                Ok(Self { symmetry, straight: 0, ..Self::of(&faces, |_| None) })
            }
            ContactElement::Diffuse { weight, search, .. } => {
                let options = own_options(options, weight, search.basis);
                let mut own = ContactInterface::new(surface, Vec::new(), &[], first, options)?;
                if !planes.is_empty() {
                    own.set_symmetry(planes)?;
                }
                let numbered: Vec<(u32, Facet)> = (0..).zip(faces).collect();
                Self::through(&mut own, &numbered, first, weight)
            }
        }
    }

    /// The faces of a window's core and their nodes, which stand from `offset` on.
    pub fn in_window(
        window: &Window,
        offset: usize,
        options: &InterfaceOptions,
    ) -> Result<(Self, SlaveNodes), InterfaceError> {
        let ContactElement::Diffuse { weight, search, .. } = options.element else {
            return Err(WindowError::NeedsDomains.into());
        };
        let first: Vec<Point> = window.first_positions().collect();
        let faces: Vec<(u32, Facet)> = window.core_facets().collect();
        let options = own_options(options, weight, search.basis);
        let mut own = ContactInterface::in_window(window, Vec::new(), &[], &first, options)?;
        let numbers: Vec<u32> = faces.iter().map(|&(number, _)| number).collect();
        let mut slaves = SlaveNodes::new(own.master(), &numbers, &first, options.feature_angle_degrees)?;
        slaves.nodes.iter_mut().for_each(|node| *node += offset);
        let mut skin = Self::through(&mut own, &faces, &first, weight)?;
        let carriers = skin.faces.iter_mut().flat_map(|face| &mut face.carriers);
        carriers.for_each(|carrier| carrier.node += offset as u32);
        Ok((skin, slaves))
    }

    /// Faces of a surface, with their numbers, whose points between the corners lie on its fits.
    fn through(
        own: &mut ContactInterface,
        faces: &[(u32, Facet)],
        first: &[Point],
        weight: Weight,
    ) -> Result<Self, InterfaceError> {
        let (mut positions, mut numbers, mut facets) = (first.to_vec(), Vec::new(), Vec::new());
        for &(number, face) in faces {
            let points = between(&face);
            numbers.extend(points.iter().map(|_| number));
            positions.extend(points.iter().map(|nodes| Point::from(mean(first, nodes))));
            facets.push(face);
        }
        // Each over its own face: where surfaces touch, others are as near.
        own.pair_points(positions, first.len(), &numbers)?;
        own.evaluate(Mode::Value)?;
        let skin = Self::of(&facets, |k| fit(own, weight, k));
        Ok(Self { symmetry: own.images(), ..skin })
    }

    /// Faces with what fits the k-th of their points between the corners.
    fn of(faces: &[Facet], fit: impl Fn(usize) -> Option<Vec<(Carrier, f64)>>) -> Self {
        let (mut skin, mut number) = (Self::default(), 0);
        for facet in faces {
            let mut face = SkinFace { corners: facet.corners().len(), ..SkinFace::default() };
            for (k, &corner) in facet.corners().iter().enumerate() {
                face.add(Carrier::from(corner as u32), k, 1.0);
            }
            for (k, middle) in between(facet).iter().enumerate() {
                let point = face.corners + k;
                if let Some(weights) = fit(number) {
                    weights.into_iter().for_each(|(carrier, weight)| face.add(carrier, point, weight));
                } else {
                    skin.straight += 1;
                    let weight = 1.0 / middle.len() as f64;
                    middle.iter().for_each(|&node| face.add(Carrier::from(node as u32), point, weight));
                }
                number += 1;
            }
            skin.faces.push(face);
        }
        skin
    }
}

fn mean(positions: &[Point], nodes: &[usize]) -> Vector3 {
    let sum = nodes.iter().fold(Vector3::zeros(), |sum, &node| sum + Vector3::from(positions[node]));
    sum * (1.0 / nodes.len() as f64)
}

/// Options of the smooth surface through the faces' nodes, of the same basis as the master's.
fn own_options(options: &InterfaceOptions, weight: Weight, basis: Basis) -> InterfaceOptions {
    let search = SearchOptions { basis, ..SearchOptions::domains() };
    let element = ContactElement::diffuse(search).with_weight(weight);
    // Feet of points on a curved border lie a little beyond its straight edges.
    InterfaceOptions { element, distance_limit: None, areas: false, border_tolerance: 0.5, ..*options }
}

/// What the smooth surface's nodes have of its place next to the k-th point; `None` without a fit.
fn fit(own: &ContactInterface, weight: Weight, k: usize) -> Option<Vec<(Carrier, f64)>> {
    let contact = own.contacts().get(k);
    let (points, basis) = own.fit(k).ok()?;
    let foot = contact.outcome.is_contact().then(|| Vector3::from(contact.point.foot))?;
    weights_at(&points, (weight, basis), foot)
}

/// φ_k of a fit at a place of the surface, with the carriers; `None` if the fit's equations are singular.
fn weights_at(
    points: &PointsWithinReach,
    (weight, basis): (Weight, Basis),
    place: Vector3,
) -> Option<Vec<(Carrier, f64)>> {
    let unit = 1.0 / points.unit;
    let [t1, t2] = [points.frame.t1, points.frame.t2].map(Vector3::from);
    let size = basis.size();
    let monomials = |x: Point| {
        let offset = (Vector3::from(x) - place) * unit;
        let (a, b) = (t1.dot(&offset), t2.dot(&offset));
        [1.0, a, b, a * a, a * b, b * b]
    };
    let rows: Vec<[f64; 6]> = points.positions.iter().map(|&x| monomials(x)).collect();
    let mut weights: Vec<f64> = points.nodes.iter().map(|node| weight.fitting(node.distance())).collect();
    if weight.is_interpolating() {
        // ω/(1 − ω), over that of the nearest.
        let nearest = weights.iter().fold(0.0, |nearest: f64, &fitting| nearest.max(fitting));
        if 1.0 - nearest < AT_A_NODE {
            weights.iter_mut().for_each(|own| *own = f64::from(u8::from(*own == nearest)));
            return Some(carried(points, weights));
        }
        weights.iter_mut().for_each(|own| *own *= (1.0 - nearest) / (1.0 - *own));
    }
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
    Some(carried(points, rows.iter().zip(&weights).map(|(row, weight)| weight * value(row))))
}

/// What carriers have of a place that the points have these weights of.
fn carried(points: &PointsWithinReach, weights: impl IntoIterator<Item = f64>) -> Vec<(Carrier, f64)> {
    let parts =
        points.sources.iter().zip(weights).flat_map(|(point, weight)| {
            point.carriers().map(move |(carrier, part)| (carrier, part * weight))
        });
    parts.collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Without friction's anchors and images, what nodes have of a point is what puts it where the kernels' foot is.
    #[test]
    fn the_weights_of_a_fit_make_its_foot() {
        let height = |x: f64, y: f64| 0.3 * (0.8 * x).sin() * (0.7 * y).cos();
        let place = |k: usize| [(k % 9) as f64, (k / 9) as f64];
        let mut positions: Vec<Point> = (0..81).map(place).map(|[x, y]| [x, y, height(x, y)]).collect();
        let corner = |cell: usize| cell % 8 + 9 * (cell / 8);
        let facets = (0..64).map(corner).map(|k| Facet::Quadrilateral([k, k + 1, k + 10, k + 9])).collect();
        positions.extend([[3.5, 4.2, 0.1], [3.0, 4.0, height(3.0, 4.0)], [0.2, 0.1, 0.0], [5.01, 4.0, -0.1]]);
        let surface: MasterSurface = MasterSurface::new(&positions, facets).unwrap();
        for weight in Weight::ALL {
            let options = own_options(&InterfaceOptions::default(), weight, Basis::Quadratic);
            let slaves: Vec<usize> = (81..positions.len()).collect();
            let mut own =
                ContactInterface::new(surface.clone(), slaves.clone(), &[], &positions, options).unwrap();
            own.refresh_pairing(&positions).unwrap();
            own.evaluate(Mode::Value).unwrap();
            for k in 0..slaves.len() {
                let weights = fit(&own, weight, k).unwrap();
                let sum = weights.iter().fold(Vector3::zeros(), |sum, &(carrier, part)| {
                    sum + Vector3::from(positions[carrier.node as usize]) * part
                });
                let foot = Vector3::from(own.contacts().get(k).point.foot);
                let along = sum - foot;
                assert!(along.norm() < 1e-9, "{weight:?} {k} {along:?}");
            }
        }
    }
}
